// L1. Friction at the wheels' axles, and scrub against turning: viscous, and Coulomb with sticking.
//
// Both wheels have the same. In (v, omega) viscous friction stays decoupled; Coulomb friction acts
// on the wheels and couples them through M = [[A, B], [B, A]], the wheels' accelerations per
// torque. Scrub is a moment about the vertical axis that opposes omega: what tyres with a wide rim
// and casters resist turning with.
#pragma once

#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

template <class Base>
struct Friction {
  Base viscous = Base(0);        // at each wheel [N m s/rad]
  Base coulomb = Base(0);        // at each wheel [N m]
  Base scrub_viscous = Base(0);  // against turning [N m s/rad]
  Base scrub_coulomb = Base(0);  // against turning [N m]

  // Whether it takes the lanes' way for speeds that relax and for scrub: that of what is neither
  // differs from it by rounding errors.
  constexpr bool is_braked() const {
    return viscous > Base(0) || scrub_viscous > Base(0) || scrub_coulomb > Base(0);
  }
};

template <class Number>
struct FrictionCoefficients {
  using Base = base_t<Number>;

  Number linear_rate;   // viscous decay of v [1/s]: 2 b/(m r^2)
  Number angular_rate;  // viscous decay of omega [1/s]: b L^2/(2 I r^2) + s/I
  Number viscous;       // [N m s/rad]
  Number coulomb;       // [N m]
  Number own;           // A: a wheel's acceleration per its own torque [rad/s^2 per N m]
  Number other;         // B: per the other wheel's
  Number half_track;    // L/2 [m]
  Number wheel_radius;  // [m]
  Number scrub;         // what Coulomb scrub takes from d(omega)/dt [rad/s^2]
  Number half_scrub;    // half of what viscous scrub has of angular_rate [1/s]: s/(2 I)

  constexpr FrictionCoefficients(const Robot<Number>& robot, const Friction<Number>& friction)
      : linear_rate(Base(2) * friction.viscous /
                    (robot.mass * robot.wheel_radius * robot.wheel_radius)),
        angular_rate(friction.viscous * robot.track_width * robot.track_width /
                         (Base(2) * robot.inertia * robot.wheel_radius * robot.wheel_radius) +
                     friction.scrub_viscous / robot.inertia),
        viscous(friction.viscous),
        coulomb(friction.coulomb),
        own(Base(0)),
        other(Base(0)),
        half_track(robot.track_width * Base(0.5)),
        wheel_radius(robot.wheel_radius),
        scrub(friction.scrub_coulomb / robot.inertia),
        half_scrub(friction.scrub_viscous * Base(0.5) / robot.inertia) {
    const Number forward = Base(1) / (robot.mass * robot.wheel_radius * robot.wheel_radius);
    const Number turning =
        half_track * half_track / (robot.inertia * robot.wheel_radius * robot.wheel_radius);
    own = forward + turning;
    other = forward - turning;
  }

  // Those of some of the robots that a Number of many holds: `pick` gives their part of a number.
  template <class Many, class Pick>
  constexpr FrictionCoefficients(const FrictionCoefficients<Many>& all, const Pick& pick)
      : linear_rate(pick(all.linear_rate)),
        angular_rate(pick(all.angular_rate)),
        viscous(pick(all.viscous)),
        coulomb(pick(all.coulomb)),
        own(pick(all.own)),
        other(pick(all.other)),
        half_track(pick(all.half_track)),
        wheel_radius(pick(all.wheel_radius)),
        scrub(pick(all.scrub)),
        half_scrub(pick(all.half_scrub)) {}

  // While the robot turns about a wheel that sticks: the rate at which the other wheel's speed
  // relaxes [1/s], and what that speed adds to the acceleration that the stuck wheel's friction has
  // to take, per rad/s, but for its sign.
  constexpr Number pivot_rate() const {
    return viscous * (own - other * other / own) + half_scrub * (Base(1) + other / own);
  }
  constexpr Number pivot_coupling() const { return other * viscous - half_scrub; }
};

// What is left of a turning rate, or of its acceleration, when scrub has brought it as near to zero
// as it can by at most `limit` of the same unit. Friction of the wheels acts after it: that stops a
// turn but never reverses it, so that one after the other they do what all three contacts do
// together (docs/theory.md).
template <class Scalar, class Number>
constexpr Scalar scrubbed(const Scalar& turning, const Number& limit) {
  using M = math<Scalar>;
  const Number low = limit * base_t<Number>(-1);
  return turning - M::maximum(M::minimum(turning, Scalar(limit)), Scalar(low));
}

// The friction f of both wheels, each within +-limit, that brings `motion` + M f as near to zero as
// it can and elsewhere opposes it: a complementarity problem in two variables. `motion` may be
// speeds (f is then an impulse) or accelerations. Best responses in turn; the unconstrained answer
// as the start makes them exact once a wheel is at its limit.
template <class Scalar, class Number>
constexpr TorquePair<Scalar> opposing_friction(const FrictionCoefficients<Number>& friction,
                                               const TorquePair<Scalar>& motion,
                                               const Number& limit) {
  using Base = base_t<Number>;
  const Number low = limit * Base(-1);
  const auto clip = [&](const Scalar& value) {
    return math<Scalar>::maximum(math<Scalar>::minimum(value, Scalar(limit)), Scalar(low));
  };
  const Number a = friction.own;
  const Number b = friction.other;
  const Number determinant = Base(1) / (a * a - b * b);
  TorquePair<Scalar> f = {clip((motion.right * b - motion.left * a) * determinant),
                          clip((motion.left * b - motion.right * a) * determinant)};
  for (int sweep = 0; sweep < 4; ++sweep) {
    f.right = clip((motion.right + f.left * b) * (Base(-1) / a));
    f.left = clip((motion.left + f.right * b) * (Base(-1) / a));
  }
  return f;
}

}  // namespace nfopidn
