// L1. The plant of a scenario: torques are commanded, and arrive as they are or by motors.
#pragma once

#include "nfopidn/plant/motor.hpp"

namespace nfopidn {

// A plant (plant.hpp) whose input is the pair of torques that the controller commands. With motors
// each becomes a voltage by the motor's model and the speed of its wheel at the sample's start;
// what the supply cannot give is missing. The voltage stands for the sample, so that the torque
// falls while a wheel speeds up.
template <class Number>
class RobotDrive {
 public:
  using Base = base_t<Number>;
  using Parameters = Robot<Number>;
  static constexpr int size = DifferentialDrive<Number>::size;

  // `motor` may be null. `dt` is the sample time [s], divided into `substeps` equal steps.
  constexpr RobotDrive(const Robot<Number>& robot, const Friction<Number>& friction,
                       const Motor<Base>* motor, Integrator integrator, Base dt, int substeps)
      : plain_(robot, friction, integrator, dt, substeps),
        driven_(robot, motor == nullptr ? Motor<Base>{} : *motor, integrator, dt, substeps,
                friction),
        robot_(robot),
        has_motors_(motor != nullptr) {}

  constexpr bool is_exact() const { return plain_.is_exact(); }
  constexpr bool has_motors() const { return has_motors_; }

  template <class Scalar>
  NFOPIDN_INLINE constexpr void advance(State<Scalar>& state, const Heading<Scalar>& heading,
                                        const TorquePair<Scalar>& torque,
                                        const Disturbance<Number>* outside = nullptr) const {
    if (has_motors_) {
      advance_by_motors(state, heading, torque, outside);
    } else {
      plain_.advance(state, heading, torque, outside);
    }
  }

  // What the supply can give of the commanded torques at the sample's start.
  template <class Scalar>
  constexpr TorquePair<Scalar> available(const State<Scalar>& state,
                                         const TorquePair<Scalar>& torque) const {
    const TorquePair<Scalar> speeds = wheel_speeds(robot_, state.v, state.omega);
    return {driven_.motor().available(torque.left, speeds.left),
            driven_.motor().available(torque.right, speeds.right)};
  }

  // The commands that give the accelerations at the state's speeds, with the rotors' inertia and
  // the viscous friction made up for and without Coulomb friction and dead band. The supply's limit
  // is not applied.
  template <class Scalar>
  constexpr TorquePair<Scalar> inverse(const State<Scalar>& state, const Scalar& linear,
                                       const Scalar& angular) const {
    if (!has_motors_) return plain_.inverse(state, linear, angular);
    const Motor<Base>& motor = driven_.motor();
    const TorquePair<Scalar> voltage = driven_.inverse(state, linear, angular);
    const TorquePair<Scalar> speeds = wheel_speeds(robot_, state.v, state.omega);
    return {voltage.left * motor.torque_per_volt() - speeds.left * motor.back_emf_damping(),
            voltage.right * motor.torque_per_volt() - speeds.right * motor.back_emf_damping()};
  }

  template <class Scalar>
  static constexpr Heading<Scalar> heading(const State<Scalar>& state) {
    return DifferentialDrive<Number>::heading(state);
  }

 private:
  template <class Scalar>
  constexpr TorquePair<Scalar> voltages(const State<Scalar>& state,
                                        const TorquePair<Scalar>& torque) const {
    const TorquePair<Scalar> speeds = wheel_speeds(robot_, state.v, state.omega);
    const Motor<Base>& motor = driven_.motor();
    return {motor.voltage(torque.left, speeds.left), motor.voltage(torque.right, speeds.right)};
  }

  // Never inlined, so that a robot without motors keeps its registers.
  template <class Scalar>
  NFOPIDN_NOINLINE constexpr void advance_by_motors(State<Scalar>& state,
                                                    const Heading<Scalar>& heading,
                                                    const TorquePair<Scalar>& torque,
                                                    const Disturbance<Number>* outside) const {
    driven_.advance(state, heading, voltages(state, torque), outside);
  }

  DifferentialDrive<Number> plain_;
  MotorDrive<Number> driven_;
  Robot<Number> robot_;
  bool has_motors_;
};

}  // namespace nfopidn
