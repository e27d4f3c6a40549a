// L2. What the tracking law remembers and does beside the neurons: speed errors from the pose
// alone, a pole against the delay of one sample, and integral states. docs/theory.md has the
// equations.
#pragma once

#include "nfopidn/control/law_parameters.hpp"
#include "nfopidn/control/reference.hpp"

namespace nfopidn {

// How far the robot went and turned since the last measurement, against how far the reference did.
template <class Scalar>
class SpeedErrors {
 public:
  using Base = base_t<Scalar>;
  using M = math<Scalar>;

  // The first sample after this has the reference's whole motion as its error, which suits a robot
  // at rest. After `in_motion` it has none: the first pose only primes the differences.
  constexpr void reset(bool in_motion) {
    first_ = true;
    in_motion_ = in_motion;
    intervals_ = 1;
  }
  // A sample without a measurement: the next motion is that of one sample more.
  constexpr void miss() { ++intervals_; }

  // The last measured pose, to be read or put elsewhere between two steps.
  constexpr const Channels<Scalar>& last_pose() const { return last_; }
  constexpr void set_last_pose(const Channels<Scalar>& pose) {
    last_ = pose;
    first_ = false;
  }

  // n of the channels x [m] and theta [rad]; y is 0. The errors are those of the pose, in the
  // world's frame; `heading` is the robot's.
  NFOPIDN_INLINE constexpr Channels<Scalar> step(const Channels<Scalar>& world_error,
                                                 const Heading<Scalar>& heading,
                                                 const ReferenceSample<Base>& reference,
                                                 Base sample_time) {
    const Scalar zero = Scalar(Base(0));
    const Channels<Scalar> pose = {reference.x - world_error.x, reference.y - world_error.y,
                                   reference.theta - world_error.theta};
    Channels<Scalar> moved = {zero, zero, zero};
    if (!first_) {
      moved = {pose.x - last_.x, pose.y - last_.y, M::wrap(pose.theta - last_.theta)};
    }
    last_ = pose;
    const bool primes = first_ && in_motion_;
    const Base share = Base(1) / Base(intervals_);
    first_ = false;
    intervals_ = 1;
    if (primes) return {zero, zero, zero};
    const Heading<Scalar> half = M::heading(moved.theta * Base(0.5));
    // cos h and sin h of the heading h midway between the last and the present one.
    const Scalar cosine = heading.cosine * half.cosine + heading.sine * half.sine;
    const Scalar sine = heading.sine * half.cosine - heading.cosine * half.sine;
    const Scalar way = (moved.x * cosine + moved.y * sine) * share;
    const Scalar turn = moved.theta * share;
    const Scalar alignment = M::heading(world_error.theta).cosine;
    return {alignment * (sample_time * reference.v) - way, zero,
            sample_time * reference.omega - turn};
  }

 private:
  Channels<Scalar> last_ = {};  // the last measured pose
  bool first_ = true;
  bool in_motion_ = false;
  int intervals_ = 1;  // samples since the last measurement
};

// Drive D and steering R after the pole, and the integral states beside the neurons.
template <class Scalar>
struct DriveAndSteering {
  using Base = base_t<Scalar>;
  using M = math<Scalar>;

  Scalar drive = Scalar(Base(0));              // D [N m]
  Scalar steering = Scalar(Base(0));           // R [N m]
  Scalar drive_integral = Scalar(Base(0));     // z_x [N m]
  Scalar steering_integral = Scalar(Base(0));  // z_s [N m]

  // The feedback torques, of the neurons' outputs and the errors that the integral states sum, y as
  // its neuron is fed it.
  NFOPIDN_INLINE constexpr TorquePair<Scalar> step(const Channels<Scalar>& output,
                                                   const Channels<Scalar>& error,
                                                   const LawParameters<Scalar>& law) {
    drive = output.x - law.pole_x * drive;
    steering = (output.y + output.theta) - law.pole_theta * steering;
    drive_integral = clip(law.integral_retention * drive_integral + law.integral_x * error.x, law);
    steering_integral = clip(law.integral_retention * steering_integral +
                                 (law.integral_y * error.y + law.integral_theta * error.theta),
                             law);
    const Scalar both = drive + drive_integral;
    const Scalar difference = steering + steering_integral;
    return {both + difference, both - difference};
  }

 private:
  NFOPIDN_INLINE static constexpr Scalar clip(const Scalar& value,
                                              const LawParameters<Scalar>& law) {
    return M::maximum(M::minimum(value, law.integral_limit), law.integral_limit * Base(-1));
  }
};

// V_r (V_r^2 + v0^2)^(-p/2), by which the lateral error is multiplied.
template <class Scalar>
NFOPIDN_INLINE constexpr Scalar lateral_schedule(base_t<Scalar> speed,
                                                 const LawParameters<Scalar>& law) {
  using M = math<Scalar>;
  const Scalar square = law.lateral_speed_square + Scalar(speed * speed);
  return M::exponential(law.minus_half_lateral_power * M::log(square)) * speed;
}

namespace detail {

// What a controller whose variant has the tracking law holds besides; others hold nothing of it.
template <class Scalar, bool has_tracking_law>
struct TrackingMemory {
  SpeedErrors<Scalar> speed_errors;
  DriveAndSteering<Scalar> drive_and_steering;
  LawParameters<Scalar> parameters;
  Channels<Scalar> last_error = {};  // in the robot's frame, the lateral one as measured
  base_t<Scalar> sample_time = base_t<Scalar>(0);
};
template <class Scalar>
struct TrackingMemory<Scalar, false> {};

}  // namespace detail

}  // namespace nfopidn
