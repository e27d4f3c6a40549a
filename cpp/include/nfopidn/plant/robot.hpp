// L1. The differential-drive robot: parameters, state, forward and inverse dynamics.
//
// Sign: in the paper a positive *left* torque turns the robot counter-clockwise, mirrored from a
// real robot and from REP-103. The paper's sign is kept here; convert where a real robot is met.
#pragma once

#include "nfopidn/foundation/schema.hpp"
#include "nfopidn/math/math.hpp"

namespace nfopidn {

template <class Scalar>
struct TorquePair {
  Scalar left;   // [N m]
  Scalar right;  // [N m]
};

template <class Scalar>
struct State {
  Scalar x;      // [m]
  Scalar y;      // [m]
  Scalar theta;  // [rad]
  Scalar v;      // forward speed [m/s]
  Scalar omega;  // turning rate [rad/s]
};

// A force along the robot's axis and a moment about its centre, positive as v and omega. From the
// world-frame tau_d of eq. 4: force = -(tau_dx cos theta + tau_dy sin theta), moment = -tau_dtheta.
template <class Base>
struct Disturbance {
  Base force;   // [N]
  Base moment;  // [N m]
};

template <class Base = double>
struct Robot {
  Base mass = Base(11.5);           // [kg]
  Base inertia = Base(0.5873);      // about the vertical axis [kg m^2]
  Base track_width = Base(0.452);   // L, between the wheels [m]
  Base wheel_radius = Base(0.076);  // r [m]

  // The paper's robot (its Table 1).
  static constexpr Robot eddie() { return {}; }

  // The same robot by its vendor's datasheet: 0.452 m is the diameter of the body, the track is
  // 0.390 m, and a disc of that body has 0.294 kg m^2 where the paper's value is that of a hoop.
  static constexpr Robot eddie_datasheet() {
    return {Base(11.5), Base(0.294), Base(0.390), Base(0.076)};
  }

  constexpr Status validate() const noexcept { return check_ranges(*this).status; }

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    visit(field("mass", &Robot::mass, "kg", between(1e-6, 1e6), "mass of the robot"));
    visit(field("inertia", &Robot::inertia, "kg m^2", between(1e-9, 1e9),
                "moment of inertia about the vertical axis"));
    visit(field("track_width", &Robot::track_width, "m", between(1e-4, 1e3),
                "distance L between the wheels"));
    visit(field("wheel_radius", &Robot::wheel_radius, "m", between(1e-4, 1e3),
                "radius r of the wheels"));
  }
};

// The robot with what its wheels' spin adds to its mass and inertia: wheel_inertia is that of each
// wheel about its axle, J [kg m^2], and what turns with it. The wheels' own mass is the robot's.
template <class Number, class Base>
constexpr Robot<Number> with_wheels(const Robot<Number>& robot, const Base& wheel_inertia) {
  const Number at_rim = Number(wheel_inertia) / (robot.wheel_radius * robot.wheel_radius);
  Robot<Number> loaded = robot;
  loaded.mass = robot.mass + base_t<Number>(2) * at_rim;
  loaded.inertia =
      robot.inertia + at_rim * robot.track_width * robot.track_width * base_t<Number>(0.5);
  return loaded;
}

// What the torques and a disturbance do (eq. 4 without its constraint force).
template <class Number>
struct Acceleration {
  using Base = base_t<Number>;

  Number drive;            // dv/dt per N m of tau_L + tau_R: 1/(m r)
  Number steer;            // d(omega)/dt per N m of tau_L - tau_R: L/(2 I r)
  Number inverse_mass;     // dv/dt per N
  Number inverse_inertia;  // d(omega)/dt per N m

  explicit constexpr Acceleration(const Robot<Number>& robot)
      : drive(Base(1) / (robot.mass * robot.wheel_radius)),
        steer(robot.track_width / (Base(2) * robot.inertia * robot.wheel_radius)),
        inverse_mass(Base(1) / robot.mass),
        inverse_inertia(Base(1) / robot.inertia) {}

  // Those of some of the robots that a Number of many holds: `pick` gives their part of a number.
  template <class Many, class Pick>
  constexpr Acceleration(const Acceleration<Many>& all, const Pick& pick)
      : drive(pick(all.drive)),
        steer(pick(all.steer)),
        inverse_mass(pick(all.inverse_mass)),
        inverse_inertia(pick(all.inverse_inertia)) {}

  template <class Scalar>
  constexpr Scalar linear(const TorquePair<Scalar>& torque,
                          const Disturbance<Number>& outside) const {
    return (torque.left + torque.right) * drive + outside.force * inverse_mass;
  }
  template <class Scalar>
  constexpr Scalar angular(const TorquePair<Scalar>& torque,
                           const Disturbance<Number>& outside) const {
    return (torque.left - torque.right) * steer + outside.moment * inverse_inertia;
  }
};

// The torques that give the accelerations dv/dt [m/s^2] and d(omega)/dt [rad/s^2] without friction
// (eqs. 5, 6, 9, 10): the feedforward.
template <class Scalar, class Base>
constexpr TorquePair<Scalar> inverse_dynamics(const Robot<Base>& robot, const Scalar& linear,
                                              const Scalar& angular) {
  const Scalar sum = linear * (robot.mass * robot.wheel_radius);
  const Scalar difference =
      angular * (Base(2) * robot.inertia * robot.wheel_radius / robot.track_width);
  return {(sum + difference) * Base(0.5), (sum - difference) * Base(0.5)};
}

// Wheel speeds [rad/s] in the paper's sign: (v +- L omega / 2) / r.
template <class Scalar, class Base>
constexpr TorquePair<Scalar> wheel_speeds(const Robot<Base>& robot, const Scalar& v,
                                          const Scalar& omega) {
  const Scalar turn = omega * (Base(0.5) * robot.track_width);
  return {(v + turn) * (Base(1) / robot.wheel_radius), (v - turn) * (Base(1) / robot.wheel_radius)};
}

// The force across the wheels that keeps them from slipping, the lambda of eq. 4 [N].
template <class Scalar, class Base>
constexpr Scalar lateral_force(const Robot<Base>& robot, const Scalar& v, const Scalar& omega) {
  return v * omega * robot.mass;
}

}  // namespace nfopidn
