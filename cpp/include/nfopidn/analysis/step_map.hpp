// L4. The closed loop as a map from one sample to the next, for any Scalar.
#pragma once

#include "nfopidn/analysis/periodic_reference.hpp"
#include "nfopidn/analysis/state_filter.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/json_controller.hpp"
#include "nfopidn/math/dual.hpp"

namespace nfopidn {

constexpr int most_loop_states = 200;

// The numbers that a loop's state has, in this order.
struct LoopStates {
  int filter;   // a channel's: past errors, and then the modes of a long memory
  int errors;   // how many of them are past errors: M + 1 without modes
  bool adds;    // incremental form: the last feedback torques
  bool tracks;  // the tracking law: the last pose, drive and steering, their integral states
  int delay;    // torques on their way

  static constexpr int pose = 0;      // error x, y [m], theta [rad], in the reference's frame
  static constexpr int velocity = 3;  // v [m/s], omega [rad/s]
  static constexpr int past = 5;      // of x, of y, of theta, as the law was fed them
  constexpr int feedback() const { return past + channel_count * filter; }  // left, right
  constexpr int tracking() const { return feedback() + (adds ? 2 : 0); }
  constexpr int line() const { return tracking() + (tracks ? 7 : 0); }  // left, right; next first
  constexpr int size() const { return line() + 2 * delay; }
};

// The kernels with which the loop has few enough states: all taps, or else modes.
NFOPIDN_HOST StateKernels loop_kernels(const Scenario& scenario, const ControllerDesign& design,
                                       LoopStates& states);

// The scenario's loop, without noise, on a period of its reference.
//
// The error is in the reference's frame, and so on a line or circle the map is the same at every
// sample. Law and plant are those that simulate.
template <class Scalar>
class StepMap {
 public:
  // What is borrowed must outlive the map; size() must be at most most_loop_states.
  StepMap(const PreparedRun& run, const ControllerDesign& design,
          const PeriodicReference& reference)
      : plant_(run.plant),
        reference_(reference),
        disturbance_(run.disturbance.front()),
        feedforward_(run.scenario->feedforward) {
    law_.configure_structure(design, run.limits);
    if (design.needs_tracking_law()) law_.set_parameters(law_parameters<Scalar>(design));
    steers_ =
        design.form == Form::positional && design.allocation.kind() == AllocationKind::decoupled;
    differences_ = design.net == Net::speed_errors;
    sums_drive_ = steers_ && design.integral_x != 0;
    sums_steering_ = steers_ && (design.integral_y != 0 || design.integral_theta != 0);
    law_.set_filter(StateFilter<Scalar>(loop_kernels(*run.scenario, design, states_)));
  }

  const LoopStates& states() const { return states_; }
  int size() const { return states_.size(); }
  int period() const { return reference_.period; }

  // From sample k of the period to k + 1. Returns the total torques before the limit.
  TorquePair<Scalar> advance(int k, const Scalar* from, Scalar* to) {
    const ReferenceSample<double>& now = reference_.samples[static_cast<std::size_t>(k)];
    LoopState<Scalar> loop = restore(from, now);
    LoopInputs<double> inputs;
    inputs.reference = &now;
    inputs.samples = 1;
    inputs.disturbance = &disturbance_;
    inputs.feedforward = feedforward_;
    inputs.divergence_distance = std::numeric_limits<double>::infinity();
    run_closed_loop<Scalar>(plant_, law_, loop, inputs, [](int, auto&&...) {});
    keep(loop, (&now)[1], to);
    const TorquePair<Scalar> feedback = law_.feedback();
    if (!feedforward_) return feedback;
    return {feedback.left + now.tau_left, feedback.right + now.tau_right};
  }

 private:
  using Law = Controller<Scalar, StateFilter<Scalar>, TrackingVariant<double>>;

  LoopState<Scalar> restore(const Scalar* z, const ReferenceSample<double>& reference) {
    const Heading<double> h = math<double>::heading(reference.theta);
    const Scalar* const e = z + LoopStates::pose;
    LoopState<Scalar> loop{{reference.x - (e[0] * h.cosine - e[1] * h.sine),
                            reference.y - (e[0] * h.sine + e[1] * h.cosine), reference.theta - e[2],
                            z[LoopStates::velocity], z[LoopStates::velocity + 1]},
                           DelayLine<Scalar>(states_.delay)};
    for (int i = 0; i < states_.delay; ++i) {
      loop.delay.ahead(i) = {z[states_.line() + 2 * i], z[states_.line() + 2 * i + 1]};
    }
    const Scalar* past = z + LoopStates::past;
    for (int channel = 0; channel < channel_count; ++channel) {
      for (int i = 0; i < states_.filter; ++i) law_.filter().state(channel, i) = *past++;
    }
    if (states_.adds) law_.set_feedback({z[states_.feedback()], z[states_.feedback() + 1]});
    if (states_.tracks) restore_tracking(z + states_.tracking(), reference, h);
    return loop;
  }

  // The last pose is kept in the frame of the reference, as the present one is.
  void restore_tracking(const Scalar* z, const ReferenceSample<double>& reference,
                        const Heading<double>& h) {
    auto& memory = law_.tracking_memory();
    memory.speed_errors.set_last_pose({reference.x - (z[0] * h.cosine - z[1] * h.sine),
                                       reference.y - (z[0] * h.sine + z[1] * h.cosine),
                                       reference.theta - z[2]});
    memory.drive_and_steering = {z[3], z[4], z[5], z[6]};
  }
  void keep_tracking(const ReferenceSample<double>& reference, const Heading<double>& h,
                     Scalar* z) {
    const auto& memory = law_.tracking_memory();
    const Channels<Scalar>& last = memory.speed_errors.last_pose();
    const Scalar zero = Scalar(0.0);
    const Channels<Scalar> error = rotate_into_robot(
        world_errors(Measurement<Scalar>{last.x, last.y, last.theta, zero, zero}, reference),
        Heading<Scalar>{Scalar(h.cosine), Scalar(h.sine)});
    // What the law does not use stays as it is, which is no motion of the loop.
    const auto& held = memory.drive_and_steering;
    const Scalar numbers[] = {differences_ ? error.x : zero,
                              differences_ ? error.y : zero,
                              differences_ ? error.theta : zero,
                              steers_ ? held.drive : zero,
                              steers_ ? held.steering : zero,
                              sums_drive_ ? held.drive_integral : zero,
                              sums_steering_ ? held.steering_integral : zero};
    std::copy(std::begin(numbers), std::end(numbers), z);
  }

  void keep(LoopState<Scalar>& loop, const ReferenceSample<double>& reference, Scalar* z) {
    const State<Scalar>& robot = loop.robot;
    const Heading<double> h = math<double>::heading(reference.theta);
    const Channels<Scalar> error = rotate_into_robot(
        world_errors(Measurement<Scalar>{robot.x, robot.y, robot.theta, robot.v, robot.omega},
                     reference),
        Heading<Scalar>{Scalar(h.cosine), Scalar(h.sine)});
    z[0] = error.x;
    z[1] = error.y;
    z[2] = error.theta;
    z[LoopStates::velocity] = robot.v;
    z[LoopStates::velocity + 1] = robot.omega;
    Scalar* past = z + LoopStates::past;
    for (int channel = 0; channel < channel_count; ++channel) {
      for (int i = 0; i < states_.filter; ++i) *past++ = law_.filter().state(channel, i);
    }
    if (states_.adds) {
      z[states_.feedback()] = law_.feedback().left;
      z[states_.feedback() + 1] = law_.feedback().right;
    }
    if (states_.tracks) keep_tracking(reference, h, z + states_.tracking());
    for (int i = 0; i < states_.delay; ++i) {
      z[states_.line() + 2 * i] = loop.delay.ahead(i).left;
      z[states_.line() + 2 * i + 1] = loop.delay.ahead(i).right;
    }
  }

  RobotDrive<double> plant_;
  const PeriodicReference& reference_;
  Disturbance<double> disturbance_;
  LoopStates states_ = {};
  bool feedforward_;
  // Which states of the tracking law are used.
  bool differences_, steers_, sums_drive_, sums_steering_;
  Law law_;
};

// Whether the loop can be analysed as a map: its number of states and its disturbance.
NFOPIDN_HOST Outcome check_loop(const Scenario& scenario, const ControllerDesign& design);

#ifdef NFOPIDN_COMPILED
extern template class StepMap<double>;
extern template class StepMap<Dual<double>>;
#endif

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST StateKernels loop_kernels(const Scenario& scenario, const ControllerDesign& design,
                                       LoopStates& states) {
  states.adds = design.form == Form::incremental;
  states.tracks = design.needs_tracking_law();
  states.delay = scenario.delay;
  states.filter = std::min<int>(design.memory, most_loop_states) + 1;
  const bool modal = states.size() > most_loop_states && has_modes(design);
  StateKernels kernels = state_kernels(design, modal);
  states.filter = static_cast<int>(StateFilter<double>::state_count(kernels[0]));
  states.errors = static_cast<int>(StateFilter<double>::past_count(kernels[0]));
  return kernels;
}

NFOPIDN_HOST Outcome check_loop(const Scenario& scenario, const ControllerDesign& design) {
  if (Outcome outcome = explain_sample_time(design, scenario.trajectory.dt()); !outcome) {
    return outcome;
  }
  LoopStates states = {};
  loop_kernels(scenario, design, states);
  if (states.size() > most_loop_states) {
    return refuse_number("number of states (memory " + std::to_string(design.memory) + ", delay " +
                             std::to_string(scenario.delay) + ")",
                         states.size(), between(1, most_loop_states));
  }
  if (scenario.disturbance.size() > 1) {
    return refuse(Status::inconsistent, "disturbance", "one pair a sample", "constant");
  }
  return {};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
