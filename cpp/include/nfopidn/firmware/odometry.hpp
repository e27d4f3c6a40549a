// L2. Wheels of a real robot: whose is the left one, how far they rolled, where that leads.
#pragma once

#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/plant/odometry.hpp"

namespace nfopidn {

// A real robot's wheels in the sense of REP-103: the left one drives the robot forward and turns it
// clockwise. The paper's left wheel turns it counter-clockwise, so the two change places. For
// torques and for wheel speeds, in both directions.
template <class Scalar>
constexpr TorquePair<Scalar> to_rep103(const TorquePair<Scalar>& torque) noexcept {
  return {torque.right, torque.left};
}

// As odometry() where encoders may fail: moves the pose and returns true, or, if one of the wheels
// would have rolled farther than `longest_step` [m], forward or back, or a length is no number,
// leaves the pose and returns false. For the controller that is a sample without a measurement.
template <class Scalar>
bool try_odometry(State<Scalar>& state, Scalar left, Scalar right, base_t<Scalar> track_width,
                  base_t<Scalar> longest_step) noexcept {
  using M = math<Scalar>;
  if (!(M::absolute(left) <= longest_step && M::absolute(right) <= longest_step)) return false;
  if (!M::is_finite(left) || !M::is_finite(right)) return false;  // under an infinite longest step
  state = odometry(state, left, right, track_width);
  return true;
}

// Metres that a wheel has rolled between two counts of its encoder. Counters may wrap around once:
// give them as unsigned integers.
template <class Scalar, class Count>
constexpr Scalar rolled(Count before, Count now, Scalar ticks_per_turn,
                        Scalar wheel_radius) noexcept {
  static_assert(traits::is_unsigned<Count>, "only an unsigned counter wraps around as defined");
  using Signed = traits::make_signed_t<Count>;
  const auto ticks = static_cast<Signed>(static_cast<Count>(now - before));
  return static_cast<Scalar>(ticks) * (2 * math<Scalar>::pi * wheel_radius / ticks_per_turn);
}

}  // namespace nfopidn
