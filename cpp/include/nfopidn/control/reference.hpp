// L2. One sample of the reference, and what the controller is shown of the robot.
#pragma once

#include "nfopidn/control/tap_filter.hpp"
#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

template <class Base>
struct ReferenceSample {
  Base x;          // [m]
  Base y;          // [m]
  Base theta;      // [rad]
  Base v;          // signed along the heading [m/s]
  Base omega;      // [rad/s]
  Base tau_left;   // feedforward torque [N m]
  Base tau_right;  // [N m]
  bool reverse;    // the reference drives backwards
};

template <class Scalar>
struct Measurement {
  Scalar x;      // [m]
  Scalar y;      // [m]
  Scalar theta;  // [rad]
  Scalar v;      // [m/s]; NFOPIDN never reads v and omega
  Scalar omega;  // [rad/s]
};

// Reference minus measured, in the world's frame; the angle as it comes.
template <class Scalar>
NFOPIDN_INLINE constexpr Channels<Scalar> plain_errors(
    const Measurement<Scalar>& measured, const ReferenceSample<base_t<Scalar>>& reference) {
  return {reference.x - measured.x, reference.y - measured.y, reference.theta - measured.theta};
}

// The same with the angle in [-pi, pi].
template <class Scalar>
NFOPIDN_INLINE constexpr Channels<Scalar> world_errors(
    const Measurement<Scalar>& measured, const ReferenceSample<base_t<Scalar>>& reference) {
  Channels<Scalar> error = plain_errors(measured, reference);
  error.theta = math<Scalar>::wrap(error.theta);
  return error;
}

template <class Scalar>
NFOPIDN_INLINE constexpr Channels<Scalar> rotate_into_robot(const Channels<Scalar>& world,
                                                            const Heading<Scalar>& heading) {
  return {heading.cosine * world.x + heading.sine * world.y,
          heading.cosine * world.y - heading.sine * world.x, world.theta};
}

}  // namespace nfopidn
