// L2. The closed loop: control, cost and motion, sample by sample.
#pragma once

#include "nfopidn/control/controller.hpp"
#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/loop/poll.hpp"
#include "nfopidn/plant/differential_drive.hpp"

namespace nfopidn {

constexpr int maximum_delay = 64;  // [samples]

// What happens to the loop from outside. Pointers are borrowed.
template <class Base>
struct LoopInputs {
  const ReferenceSample<Base>* reference = nullptr;  // `samples` of them
  int samples = 0;
  const Heading<Base>* headings = nullptr;   // of the reference's angles; only lanes need them
  const Measurement<Base>* noise = nullptr;  // added to the measurement, per sample; may be null
  const Disturbance<Base>* disturbance = nullptr;  // may be null
  bool disturbance_by_sample = false;   // else disturbance points to one, which is constant
  int delay = 0;                        // samples from measurement to applied torque
  bool feedforward = true;              // the law is given the reference torques
  Base divergence_distance = Base(10);  // [m]
};

// Eq. 41's sum, and the divergence rule: a run diverges when its state is not finite or the robot
// is more than a given distance from its reference; each sample from there on costs that distance
// squared, and the sample count stays the full one.
template <class Scalar>
class CostMeter {
 public:
  using Base = base_t<Scalar>;
  using M = math<Scalar>;

  explicit constexpr CostMeter(Base divergence_distance)
      : square_limit_(divergence_distance * divergence_distance) {}

  // True errors, total torque after the limit. Returns whether any component is still running.
  NFOPIDN_INLINE constexpr bool add(const Channels<Scalar>& error, const TorquePair<Scalar>& torque,
                                    const ReferenceSample<Base>& reference) {
    const Scalar distance = error.x * error.x + error.y * error.y;
    const Scalar angle_square = error.theta * error.theta;
    const Scalar left = reference.tau_left - torque.left;
    const Scalar right = reference.tau_right - torque.right;
    const Scalar term = distance + angle_square + (left * left + right * right);
    // The rule in one comparison while all is well: a term within the limit has every part of it
    // within, and is a number.
    if (all_running_ && M::surely_under(term, square_limit_)) {
      sum_ = sum_ + term;
      return true;
    }
    running_ = M::both(running_, M::both(distance <= square_limit_, angle_square == angle_square));
    all_running_ = M::every(running_);
    sum_ = sum_ + M::select(running_, term, Scalar(square_limit_));
    return M::any(running_);
  }

  // Whether no component has diverged.
  constexpr bool all_running() const { return all_running_; }
  // An error that is zero where a component has diverged.
  constexpr Channels<Scalar> of_running(const Channels<Scalar>& error) const {
    const Scalar zero = Scalar(Base(0));
    return {M::select(running_, error.x, zero), M::select(running_, error.y, zero),
            M::select(running_, error.theta, zero)};
  }

  // Counts `samples` more as missing.
  constexpr void miss(int samples) {
    // One by one, so that a component's sum does not depend on when the others diverged.
    for (int k = 0; k < samples; ++k) sum_ = sum_ + square_limit_;
  }

  constexpr Scalar mean(int samples) const { return sum_ * (Base(1) / Base(samples)); }

  // Called now and then; here nothing is dear enough to be given up.
  constexpr void check_bound() {}

 protected:
  Scalar sum_ = Scalar(Base(0));
  Base square_limit_;
  typename M::Mask running_ = M::all();
  bool all_running_ = true;
};

template <class Scalar>
struct LoopResult {
  Scalar cost;    // eq. 41, E
  int completed;  // samples until every component has diverged, all of them if one did not
};

// Torques on their way from the controller to the wheels. The wheels have none until the first.
template <class Scalar>
class DelayLine {
 public:
  explicit constexpr DelayLine(int delay) : delay_(delay) {
    const Scalar zero = Scalar(base_t<Scalar>(0));
    for (int i = 0; i < delay_; ++i) torques_[i] = {zero, zero};
  }
  NFOPIDN_INLINE constexpr TorquePair<Scalar> pass(const TorquePair<Scalar>& torque) {
    return delay_ == 0 ? torque : exchange(torque);
  }
  // The torque that the wheels get `samples` from now, 0 <= samples < delay.
  constexpr TorquePair<Scalar>& ahead(int samples) { return torques_[(next_ + samples) % delay_]; }

 private:
  // Never inlined, so that a torque without delay need not lie in memory.
  NFOPIDN_NOINLINE constexpr TorquePair<Scalar> exchange(TorquePair<Scalar> torque) {
    const TorquePair<Scalar> oldest = torques_[next_];
    torques_[next_] = torque;
    next_ = next_ + 1 == delay_ ? 0 : next_ + 1;
    return oldest;
  }

  TorquePair<Scalar> torques_[maximum_delay];
  int delay_;
  int next_ = 0;
};

// Where a loop stands between two samples, but for its law.
template <class Scalar>
struct LoopState {
  State<Scalar> robot;
  DelayLine<Scalar> delay;
};

namespace detail {

template <class Scalar, class = void>
constexpr bool remembers_quadrant = false;
template <class Scalar>
constexpr bool remembers_quadrant<Scalar, traits::void_t<typename math<Scalar>::Turn>> = true;
template <class Scalar, class = void>
constexpr bool has_heading_relative_to = false;
template <class Scalar>
constexpr bool
    has_heading_relative_to<Scalar, traits::void_t<decltype(&math<Scalar>::heading_relative_to)>> =
        true;

// Where the robot looks, sample by sample: the angle between it and the reference, given as it
// comes, is taken to [-pi, pi], and the robot's cosine and sine are found.
template <class Scalar, bool remembers = remembers_quadrant<Scalar>,
          bool beside = has_heading_relative_to<Scalar>>
struct HeadingTracker {
  using Base = base_t<Scalar>;
  NFOPIDN_INLINE Heading<Scalar> track(Scalar& between, const Scalar& angle,
                                       const LoopInputs<Base>& /*inputs*/, int /*k*/) {
    between = math<Scalar>::wrap(between);
    return math<Scalar>::heading(angle);
  }
};
// The angles change little from one to the next.
template <class Scalar>
struct HeadingTracker<Scalar, true, false> {
  using Base = base_t<Scalar>;
  typename math<Scalar>::Turn turn = math<Scalar>::no_turn();
  NFOPIDN_INLINE Heading<Scalar> track(Scalar& between, const Scalar& angle,
                                       const LoopInputs<Base>& /*inputs*/, int /*k*/) {
    between = math<Scalar>::wrap(between);
    return math<Scalar>::heading(angle, turn);
  }
};
// The reference's cosine and sine, one for all lanes, are known.
template <class Scalar>
struct HeadingTracker<Scalar, false, true> {
  using Base = base_t<Scalar>;
  NFOPIDN_INLINE Heading<Scalar> track(Scalar& between, const Scalar& /*angle*/,
                                       const LoopInputs<Base>& inputs, int k) {
    return math<Scalar>::heading_relative_to(inputs.headings[k], between);
  }
};

// Whether the law takes the measured pose's errors and heading, if the caller has them.
template <class Law, class Scalar, class = void>
constexpr bool takes_errors = false;
template <class Law, class Scalar>
constexpr bool
    takes_errors<Law, Scalar,
                 traits::void_t<decltype(traits::declval<Law&>().step(
                     traits::declval<Channels<Scalar>>(), traits::declval<Heading<Scalar>>(),
                     traits::declval<ReferenceSample<base_t<Scalar>>>()))>> = true;

// The samples first .. last - 1. Returns `last`, or the sample at which every component had
// diverged; the robot's state then stays as it was. Without noise the true and the measured pose
// are one, and its cosine and sine are computed once.
template <bool noisy, class Scalar, class Law, class Meter, class Observer>
constexpr int run_piece(const DifferentialDrive<base_t<Scalar>>& plant, Law& law,
                        LoopState<Scalar>& loop, const LoopInputs<base_t<Scalar>>& inputs,
                        int first, int last, Meter& total, Observer& observe) {
  using Base = base_t<Scalar>;
  constexpr int bound_check_period = 32;  // a power of two
  // Copies, so that they never leave their registers.
  State<Scalar> state = loop.robot;
  Meter meter = total;
  HeadingTracker<Scalar> heading_tracker;
  for (int k = first; k < last; ++k) {
    const ReferenceSample<Base>& reference = inputs.reference[k];
    const Measurement<Scalar> exact = {state.x, state.y, state.theta, state.v, state.omega};
    Measurement<Scalar> measured = exact;
    if constexpr (noisy) {
      measured.x = measured.x + inputs.noise[k].x;
      measured.y = measured.y + inputs.noise[k].y;
      measured.theta = measured.theta + inputs.noise[k].theta;
    }
    ReferenceSample<Base> shown = reference;
    if (!inputs.feedforward) shown.tau_left = shown.tau_right = Base(0);
    Channels<Scalar> error = plain_errors(exact, reference);
    // Lanes that have diverged would keep the others from what is done sooner near the reference.
    if (!meter.all_running()) error = meter.of_running(error);
    const Heading<Scalar> heading = heading_tracker.track(error.theta, state.theta, inputs, k);
    TorquePair<Scalar> torque;
    if constexpr (takes_errors<Law, Scalar> && !noisy) {
      torque = law.step(error, heading, shown);
    } else {
      torque = law.step(measured, shown);
    }
    if (k % bound_check_period == bound_check_period - 1) meter.check_bound();
    const bool running = meter.add(error, torque, reference);
    if (!running) {
      total = meter;
      return k;
    }
    const TorquePair<Scalar> applied = loop.delay.pass(torque);
    observe(k, state, torque, applied);
    const Disturbance<Base>* outside = inputs.disturbance;
    if (outside != nullptr && inputs.disturbance_by_sample) outside += k;
    plant.advance(state, heading, applied, outside);
  }
  loop.robot = state;
  total = meter;
  return last;
}

// A run that the poll stops has no result: what is returned means nothing.
template <bool noisy, class Scalar, class Law, class Meter, class Observer, class SomePoll>
constexpr LoopResult<Scalar> run_loop(const DifferentialDrive<base_t<Scalar>>& plant, Law& law,
                                      LoopState<Scalar>& loop,
                                      const LoopInputs<base_t<Scalar>>& inputs, Meter meter,
                                      Observer& observe, const SomePoll& poll) {
  const int samples = inputs.samples;
  int done = 0;
  while (done < samples && !poll.is_stopped()) {
    const int last = samples - done > poll.samples ? done + poll.samples : samples;
    done = run_piece<noisy, Scalar>(plant, law, loop, inputs, done, last, meter, observe);
    if (done < last) {
      meter.miss(samples - done - 1);
      break;
    }
  }
  return {meter.mean(samples), done};
}

}  // namespace detail

// As run_closed_loop() below, with another meter than a plain CostMeter, and in pieces between
// which a poll may end the run.
template <class Scalar, class Law, class Meter, class Observer, class SomePoll = NoPoll>
constexpr LoopResult<Scalar> run_metered_loop(const DifferentialDrive<base_t<Scalar>>& plant,
                                              Law& law, LoopState<Scalar>& loop,
                                              const LoopInputs<base_t<Scalar>>& inputs,
                                              const Meter& meter, Observer&& observe,
                                              const SomePoll& poll = {}) {
  return inputs.noise != nullptr
             ? detail::run_loop<true, Scalar>(plant, law, loop, inputs, meter, observe, poll)
             : detail::run_loop<false, Scalar>(plant, law, loop, inputs, meter, observe, poll);
}

// Runs `law` against `plant` from where `loop` stands, which is then where it ended; of a run that
// diverges the robot's state stays as it was. `observe(k, state, commanded, applied)` is called at
// each sample, before the robot moves; a run that diverges ends before it is called.
template <class Scalar, class Law, class Observer, class SomePoll = NoPoll>
constexpr LoopResult<Scalar> run_closed_loop(const DifferentialDrive<base_t<Scalar>>& plant,
                                             Law& law, LoopState<Scalar>& loop,
                                             const LoopInputs<base_t<Scalar>>& inputs,
                                             Observer&& observe, const SomePoll& poll = {}) {
  return run_metered_loop<Scalar>(plant, law, loop, inputs,
                                  CostMeter<Scalar>(inputs.divergence_distance), observe, poll);
}

// The same from `state`, with no torque on its way to the wheels.
template <class Scalar, class Law, class Observer, class SomePoll = NoPoll>
constexpr LoopResult<Scalar> run_closed_loop(const DifferentialDrive<base_t<Scalar>>& plant,
                                             Law& law, const State<Scalar>& state,
                                             const LoopInputs<base_t<Scalar>>& inputs,
                                             Observer&& observe, const SomePoll& poll = {}) {
  LoopState<Scalar> loop{state, DelayLine<Scalar>(inputs.delay)};
  return run_closed_loop<Scalar>(plant, law, loop, inputs, observe, poll);
}

}  // namespace nfopidn
