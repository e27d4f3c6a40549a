// L1. The reference torques: what the motion asks of the wheels, with their friction made up for.
//
// Eqs. 5, 6, 9 and 10 are those of a robot without friction. Where the wheels rub, the reference
// torques are short by the friction, and the feedback has to make up for it by an error.
#pragma once

#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

// The friction that the reference torques make up for, at each wheel. It is what the model knows;
// the friction that acts is the plant's.
template <class Base = double>
struct FrictionFeedforward {
  Base viscous = Base(0);  // [N m s/rad]
  Base coulomb = Base(0);  // [N m]
  Base speed = Base(0.5);  // wheel speed at which tanh has 76 % of the Coulomb torque [rad/s]

  constexpr bool is_none() const noexcept { return viscous == Base(0) && coulomb == Base(0); }

  // The torque that turns a wheel at `wheel_speed` [rad/s] against its friction. Coulomb friction
  // jumps at standstill; tanh(wheel_speed / speed) in its place makes the torque smooth there.
  constexpr Base torque(Base wheel_speed) const {
    return wheel_speed * viscous + math<Base>::sigmoid(Base(2) * wheel_speed / speed) * coulomb;
  }
};

// The torques that give the accelerations dv/dt [m/s^2] and d(omega)/dt [rad/s^2] at the speeds
// v [m/s] and omega [rad/s].
template <class Base>
constexpr TorquePair<Base> reference_torques(const Robot<Base>& robot,
                                             const FrictionFeedforward<Base>& friction, Base v,
                                             Base omega, Base linear, Base angular) {
  const TorquePair<Base> torque = inverse_dynamics(robot, linear, angular);
  if (friction.is_none()) return torque;
  const TorquePair<Base> speeds = wheel_speeds(robot, v, omega);
  return {torque.left + friction.torque(speeds.left), torque.right + friction.torque(speeds.right)};
}

}  // namespace nfopidn
