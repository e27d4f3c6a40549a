// L2. The nonlinear fractional-order PID neural controller: the law, once, for every Scalar.
#pragma once

#include "nfopidn/control/law_variant.hpp"
#include "nfopidn/control/torque_limit.hpp"
#include "nfopidn/control/tracking_law.hpp"

namespace nfopidn {

// tau(k) = tau_ref(k) + tau_fb(k), limited, with
//   tau_fb = [tau_fb(k-1) +] allocation * O(net),  net = taps * errors      (eqs. 31-36)
// The tracking law adds speed errors, amplitudes, a pole and integral states (docs/theory.md).
// Filter is Fir<Scalar, Capacity, Slack>; Variant is RuntimeVariant<Base> or a FixedVariant, or
// with the tracking law TrackingVariant<Base> or a FixedTrackingVariant. step() runs in constant
// time; it neither allocates nor throws.
template <class Scalar, class Filter, class Variant = RuntimeVariant<base_t<Scalar>>>
class Controller
    : private detail::FeedforwardHeadroom<Scalar>,  // bases, so that none takes no memory
      private detail::TrackingMemory<Scalar, Variant::has_tracking_law> {
 public:
  using Base = base_t<Scalar>;
  using Structure = Variant;

  // --- The law, one sample ---

  // The limited total torque. Call once a sample.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> step(
      const Measurement<Scalar>& measured, const ReferenceSample<Base>& reference) noexcept {
    return step(world_errors(measured, reference), M::heading(measured.theta), reference);
  }

  // The same, for a caller that already has the measured pose's errors in the world frame, and its
  // heading's cosine and sine.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> step(
      const Channels<Scalar>& world_error, const Heading<Scalar>& heading,
      const ReferenceSample<Base>& reference) noexcept {
    if constexpr (Structure::has_tracking_law) {
      return track(world_error, heading, reference);
    } else {
      return act(channel_errors(world_error, heading, reference), reference);
    }
  }

 private:
  using M = math<Scalar>;

  // Eq. 30: the errors that the filters receive, in the robot's frame unless a setting says world.
  NFOPIDN_INLINE constexpr Channels<Scalar> channel_errors(
      const Channels<Scalar>& world_error, const Heading<Scalar>& heading,
      const ReferenceSample<Base>& reference) const {
    Channels<Scalar> error = world_error;
    if (structure_.frame == Frame::robot) error = rotate_into_robot(error, heading);
    feed_lateral(error.y, reference);
    return error;
  }

  // The lateral error's sign or factor: backwards the same error asks for the opposite turn.
  NFOPIDN_INLINE constexpr void feed_lateral(Scalar& error,
                                             const ReferenceSample<Base>& reference) const {
    if (structure_.lateral == Lateral::direction) {
      if (reference.reverse) error = error * Base(-1);
    } else if (structure_.lateral == Lateral::speed) {
      error = error * (reference.v * inverse_speed_scale_);
    }
    if constexpr (Structure::has_tracking_law) {
      if (structure_.lateral == Lateral::scheduled) {
        error = error * lateral_schedule<Scalar>(reference.v, this->parameters);
      }
    }
  }

  // Eqs. 34, 33, 31-32, 35-36 and the limit: from the errors to the wheel torques.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> act(const Channels<Scalar>& error,
                                                  const ReferenceSample<Base>& reference) {
    const Channels<Scalar> net = filter_.step(error);  // eq. 34: sum of taps times past errors
    const Channels<Scalar> output = activate(net);     // eq. 33
    return command(allocate(output), reference);       // eqs. 31-32, then 35-36
  }

  // Eq. 33: the neurons' outputs.
  NFOPIDN_INLINE constexpr Channels<Scalar> activate(const Channels<Scalar>& net) const {
    if (structure_.activation == Activation::linear) {
      return {M::identity(net.x), M::identity(net.y), M::identity(net.theta)};
    }
    Channels<Scalar> output = net;
    M::sigmoids(output);
    return output;
  }

  // Eqs. 31-32: maps the three outputs to the two wheel torques.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> allocate(const Channels<Scalar>& output) const {
    const auto& [x, y, theta] = output;
    switch (structure_.allocation_kind) {
      case AllocationKind::paper:
        return {y + theta, x + y};
      case AllocationKind::decoupled:
        return {x + (y + theta), x - (y + theta)};
      case AllocationKind::any:
        break;
    }
    const auto row = [&](const Base* share) {
      return output.x * share[0] + (output.y * share[1] + output.theta * share[2]);
    };
    return {row(structure_.allocation.matrix[0]), row(structure_.allocation.matrix[1])};
  }

  // Eqs. 35-36 on both wheels: the feedback torques, then the sum with the feedforward.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> command(const TorquePair<Scalar>& neurons,
                                                      const ReferenceSample<Base>& reference) {
    feedback_ = {next_feedback(feedback_.left, neurons.left, reference.tau_left),
                 next_feedback(feedback_.right, neurons.right, reference.tau_right)};
    return total(reference);
  }

  // Eqs. 35-36 and the anti-windup rule, for one wheel.
  NFOPIDN_INLINE constexpr Scalar next_feedback(const Scalar& last, const Scalar& neuron,
                                                Base feedforward) const {
    if (structure_.form == Form::positional) return neuron;
    const Scalar next = last + neuron;
    if (structure_.anti_windup == AntiWindup::none) return next;
    const Scalar high = Scalar(limit_ - feedforward);
    const Scalar low = Scalar(-limit_ - feedforward);
    if (structure_.anti_windup == AntiWindup::hold) {
      const Scalar zero = Scalar(Base(0));
      const auto outward =
          M::either(M::both(next > high, neuron > zero), M::both(next < low, neuron < zero));
      return M::select(outward, last, next);
    }
    return M::maximum(M::minimum(next, M::maximum(last, high)), M::minimum(last, low));
  }

  // tau = tau_fb + tau_ref, limited.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> total(const ReferenceSample<Base>& reference) const {
    const TorquePair<Scalar> total = {feedback_.left + reference.tau_left,
                                      feedback_.right + reference.tau_right};
    if (this->has_headroom_for(reference.tau_left) && this->has_headroom_for(reference.tau_right))
      return total;
    return limited(total, limit_);
  }

  // The tracking law of docs/theory.md: the speed errors, then the rest.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> track(const Channels<Scalar>& world_error,
                                                    const Heading<Scalar>& heading,
                                                    const ReferenceSample<Base>& reference) {
    Channels<Scalar> error = world_error;
    if (structure_.frame == Frame::robot) error = rotate_into_robot(error, heading);
    this->last_error = error;
    Channels<Scalar> speed_error = error;  // unused without speed errors
    if (structure_.net == Net::speed_errors) {
      speed_error = this->speed_errors.step(world_error, heading, reference, this->sample_time);
    }
    return respond(error, speed_error, reference);
  }

  // Net, neurons with amplitudes, the pole and the integral states beside the neurons.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> respond(const Channels<Scalar>& measured_error,
                                                      const Channels<Scalar>& speed_error,
                                                      const ReferenceSample<Base>& reference) {
    const LawParameters<Scalar>& law = this->parameters;
    Channels<Scalar> error = measured_error;
    feed_lateral(error.y, reference);
    Channels<Scalar> net;
    if (structure_.net == Net::speed_errors) {
      net = filter_.step({speed_error.x, error.y, speed_error.theta});
      net.x = net.x + law.proportional_x * error.x;
      net.theta = net.theta + law.proportional_theta * error.theta;
    } else {
      net = filter_.step(error);
    }
    const Channels<Scalar> neuron = activate(net);
    const Channels<Scalar> output = {neuron.x * law.amplitude_x, neuron.y * law.amplitude_y,
                                     neuron.theta * law.amplitude_theta};
    if (structure_.allocation_kind == AllocationKind::decoupled &&
        structure_.form == Form::positional) {
      feedback_ = this->drive_and_steering.step(output, error, law);
      return total(reference);
    }
    return command(allocate(output), reference);
  }

 public:
  // --- Settings and memory ---

  // For a memory beyond the filter's capacity, settings out of range, or settings that ask for
  // another structure than a FixedVariant, returns why and changes nothing. Keeps the memory of
  // past errors and the last torque: call reset() for a fresh start.
  constexpr Status configure(const ControllerSettings<Base>& settings,
                             const ControlLimits<Base>& limits = {}) noexcept {
    const Status status = settings.validate();
    if (status != Status::ok) return status;
    if (settings.memory + 2 > Filter::capacity) return Status::out_of_range;
    if (!Structure::offers(settings)) return Status::inconsistent;
    if (!(limits.torque > Base(0)) || !(limits.speed_scale > Base(0))) return Status::out_of_range;
    if (settings.net == Net::speed_errors && !(sample_time_of(settings, limits) > Base(0))) {
      return Status::out_of_range;
    }
    configure_structure(settings, limits);
    if constexpr (Structure::has_tracking_law) {
      fuse_and_set(settings);
      return Status::ok;
    }
    Base taps[channel_count][Filter::capacity] = {};
    Base work[Filter::capacity] = {};
    for (int channel = 0; channel < channel_count; ++channel) {
      const Base* gains = settings.gains[channel];
      fuse_taps(settings.generator, gains[0], gains[1], gains[2], settings.alpha[channel],
                settings.sigma[channel], settings.memory, taps[channel], work);
    }
    set_taps(taps[0], taps[1], taps[2], settings.memory + 2);
    return Status::ok;
  }

  // Everything but the taps, which may be given with set_taps().
  constexpr void configure_structure(const ControllerSettings<Base>& settings,
                                     const ControlLimits<Base>& limits) noexcept {
    structure_.choose(settings);
    limit_ = limits.torque;
    if constexpr (Structure::has_tracking_law) {
      this->sample_time = sample_time_of(settings, limits);
    } else {
      this->configure_headroom(structure_, limit_);
    }
    const Base scale = settings.speed_scale > Base(0) ? settings.speed_scale : limits.speed_scale;
    constexpr Base least = Base(least_speed_scale);
    inverse_speed_scale_ = Base(1) / (scale < least ? least : scale);
  }

  // Taps of the channels x, y, theta as fuse_taps() makes them, in Scalar or in Base.
  template <class Tap>
  constexpr void set_taps(const Tap* x, const Tap* y, const Tap* theta, int count) noexcept {
    const Channels<const Tap*> taps = {x, y, theta};
    filter_.set_taps(taps, {M::net_scale, M::net_scale, M::net_scale}, count);
  }

  // The same for a variant with the tracking law, of which fuse_law() makes both.
  template <class Tap>
  constexpr void set_law(const Tap* taps, int count, const LawParameters<Scalar>& law) noexcept {
    set_taps(taps, taps + count, taps + 2 * count, count);
    set_parameters(law);
  }
  constexpr void set_parameters(const LawParameters<Scalar>& law) noexcept {
    this->parameters = law;
    this->parameters.proportional_x = law.proportional_x * M::net_scale;
    this->parameters.proportional_theta = law.proportional_theta * M::net_scale;
  }

  // A filter that is not made of taps alone.
  void set_filter(Filter filter) { filter_ = static_cast<Filter&&>(filter); }

  constexpr void reset() noexcept {
    filter_.reset();
    feedback_ = {Scalar(Base(0)), Scalar(Base(0))};
    if constexpr (Structure::has_tracking_law) {
      this->speed_errors.reset(false);
      this->drive_and_steering = {};
      this->last_error = {};
    }
  }

  // The same for a robot that moves as its reference does: the first pose only primes the
  // differences of the speed errors, which would otherwise kick.
  constexpr void reset_in_motion() noexcept {
    reset();
    if constexpr (Structure::has_tracking_law) this->speed_errors.reset(true);
  }

  // A sample that passed without the law, whose next motion is then that of one sample more.
  constexpr void miss() noexcept {
    if constexpr (Structure::has_tracking_law) this->speed_errors.miss();
  }

  // A sample without a measurement: the last error once more, and the present feedforward.
  constexpr TorquePair<Scalar> repeat(const ReferenceSample<Base>& reference) noexcept {
    if constexpr (Structure::has_tracking_law) {
      miss();
      return respond(this->last_error, filter_.newest(), reference);
    } else {
      return act(filter_.newest(), reference);
    }
  }

  // A fresh start as if the present error had always been there: the derivative, which after
  // reset() kicks at the step from no error to this one, has nothing to kick at.
  constexpr void reset_to(const Measurement<Scalar>& measured,
                          const ReferenceSample<Base>& reference) noexcept {
    reset_in_motion();
    const Channels<Scalar> world_error = world_errors(measured, reference);
    const Heading<Scalar> heading = M::heading(measured.theta);
    Channels<Scalar> error = channel_errors(world_error, heading, reference);
    if constexpr (Structure::has_tracking_law) {
      this->last_error = world_error;
      if (structure_.frame == Frame::robot) {
        this->last_error = rotate_into_robot(world_error, heading);
      }
      if (structure_.net == Net::speed_errors) error.x = error.theta = Scalar(Base(0));
    }
    filter_.fill(error);
  }

  // What the motors can give of the last step's torque: the rest is saturation, which the
  // anti-windup rules keep out of the sum of eqs. 35-36.
  constexpr void learn_available(const TorquePair<Scalar>& commanded,
                                 const TorquePair<Scalar>& available) noexcept {
    if (structure_.form == Form::positional || structure_.anti_windup == AntiWindup::none) return;
    feedback_.left = feedback_.left + (available.left - commanded.left);
    feedback_.right = feedback_.right + (available.right - commanded.right);
  }

  // The unlimited feedback part of the last step's torque.
  constexpr TorquePair<Scalar> feedback() const noexcept { return feedback_; }
  constexpr const Filter& filter() const noexcept { return filter_; }

  // The law's memory besides its taps, to be read or put elsewhere between two steps.
  constexpr Filter& filter() noexcept { return filter_; }
  constexpr void set_feedback(const TorquePair<Scalar>& feedback) noexcept { feedback_ = feedback; }
  constexpr detail::TrackingMemory<Scalar, Variant::has_tracking_law>& tracking_memory() noexcept {
    return *this;
  }

 private:
  // The controller's own where it carries one, else that of the run.
  static constexpr Base sample_time_of(const ControllerSettings<Base>& settings,
                                       const ControlLimits<Base>& limits) {
    return settings.sample_time.has_value() ? *settings.sample_time : limits.sample_time;
  }

  constexpr void fuse_and_set(const ControllerSettings<Base>& settings) {
    Base taps[channel_count * Filter::capacity] = {};
    Base work[Filter::capacity] = {};
    const LawParameters<Base> law =
        fuse_law<Base>(settings, settings.gains[0], settings.alpha, settings.sigma,
                       tracking_gains<Base>(settings), taps, work);
    Base numbers[LawParameters<Base>::count] = {};
    Base* next = numbers;
    LawParameters<Base>::each(law, [&](const Base& number) { *next++ = number; });
    set_law(taps, settings.memory + 2,
            law_parameters_from<Scalar>(numbers, [](Base number) { return Scalar(number); }));
  }

  Filter filter_ = {};
  TorquePair<Scalar> feedback_ = {Scalar(Base(0)), Scalar(Base(0))};
  Structure structure_ = {};
  Base limit_ = Base(3.078);
  Base inverse_speed_scale_ = Base(1);
};

}  // namespace nfopidn
