// L2. For bases that take velocities and no torques.
#pragma once

#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

template <class Scalar>
struct Velocity {
  Scalar v;      // [m/s]
  Scalar omega;  // counter-clockwise [rad/s]
};

// Of either direction, each 0 or more; at 0 the base does not move. The defaults limit nothing.
template <class Base>
struct VelocityLimits {
  Base v = Base(1e30);                     // [m/s]
  Base omega = Base(1e30);                 // [rad/s]
  Base acceleration = Base(1e30);          // [m/s^2]
  Base angular_acceleration = Base(1e30);  // [rad/s^2]

  constexpr Status validate() const noexcept {
    const Base limits[] = {v, omega, acceleration, angular_acceleration};
    for (const Base limit : limits) {
      if (limit != limit) return Status::not_finite;
      if (limit < Base(0)) return Status::out_of_range;
    }
    return Status::ok;
  }
};

// The velocities that the torques would give the nominal robot, without friction: overcoming that
// is the work of the base's own speed loop. Within the limits, and so is what is remembered: a
// velocity at its limit leaves it with the first torque that points back. A limit that is negative
// or no number (VelocityLimits::validate() says so) counts as 0: the base does not move. Call
// step() once a sample.
template <class Scalar>
class VelocityOutput {
 public:
  using Base = base_t<Scalar>;

  // `dt` [s].
  constexpr VelocityOutput(const Robot<Base>& robot, Base dt,
                           const VelocityLimits<Base>& limits = {}) noexcept
      : drive_(dt * Acceleration<Base>(robot).drive),
        steer_(dt * Acceleration<Base>(robot).steer),
        limits_{usable(limits.v), usable(limits.omega), usable(dt * limits.acceleration),
                usable(dt * limits.angular_acceleration)} {}

  // Torques in the paper's sign, as the controller gives them. Ones that are no numbers change
  // nothing.
  constexpr Velocity<Scalar> step(const TorquePair<Scalar>& torque) noexcept {
    velocity_ = {
        next(velocity_.v, (torque.left + torque.right) * drive_, limits_.v, limits_.acceleration),
        next(velocity_.omega, (torque.left - torque.right) * steer_, limits_.omega,
             limits_.angular_acceleration)};
    return velocity_;
  }

  // Goes on from the base's measured velocity, if that is a number. From one beyond the limits it
  // comes back at the limits of acceleration.
  constexpr void synchronise(const Velocity<Scalar>& measured) noexcept {
    using M = math<Scalar>;
    if (M::is_finite(measured.v) && M::is_finite(measured.omega)) velocity_ = measured;
  }

  constexpr void reset() noexcept { velocity_ = {Scalar(0), Scalar(0)}; }
  constexpr const Velocity<Scalar>& velocity() const noexcept { return velocity_; }

 private:
  static constexpr Base usable(Base limit) noexcept { return limit >= Base(0) ? limit : Base(0); }
  static constexpr Scalar next(Scalar last, Scalar change, Base limit, Base step) noexcept {
    const Scalar wanted = change == change ? last + change : last;
    return clipped(clipped(wanted, -limit, limit), last - step, last + step);
  }
  static constexpr Scalar clipped(Scalar value, Scalar low, Scalar high) noexcept {
    return math<Scalar>::minimum(math<Scalar>::maximum(value, low), high);
  }

  Base drive_;  // changes of v and omega in a sample, per N m
  Base steer_;
  VelocityLimits<Base> limits_;  // those of acceleration times dt
  Velocity<Scalar> velocity_ = {Scalar(0), Scalar(0)};
};

}  // namespace nfopidn
