// L1. The differential drive behind two DC motors with gears: voltages in.
//
// The inductance of a winding is neglected, so that the current follows the voltage at once. With
// the wheel's speed w, the gear ratio N, the winding's resistance R, the torque constant k_t and
// the back-EMF constant k_e a wheel receives
//   torque = N k_t (V - N k_e w) / R - friction.
// The term in w is viscous friction of N^2 k_t k_e / R, and a rotor's inertia J, seen through the
// gear, is mass 2 N^2 J / r^2 and inertia N^2 J L^2 / (2 r^2): the drive's own motion serves.
#pragma once

#include "nfopidn/plant/differential_drive.hpp"

namespace nfopidn {

// One motor with its gear; both wheels have the same. Defaults: a 12 V motor with a 30:1 gear.
template <class Base = double>
struct Motor {
  Base resistance = Base(2.4);          // R of the winding [ohm]
  Base torque_constant = Base(0.01);    // k_t [N m/A]
  Base back_emf_constant = Base(0.01);  // k_e [V s/rad]
  Base gear_ratio = Base(30);           // N, turns of the motor per turn of the wheel
  Base rotor_inertia = Base(0);         // J [kg m^2]
  Base viscous_friction = Base(0);      // at the wheel [N m s/rad]
  Base coulomb_friction = Base(0);      // at the wheel [N m]
  Base supply_voltage = Base(12);       // more is not applied, in either direction [V]

  constexpr Status validate() const noexcept { return check_ranges(*this).status; }

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    visit(field("resistance", &Motor::resistance, "ohm", between(1e-6, 1e6),
                "resistance of the winding"));
    visit(field("torque_constant", &Motor::torque_constant, "N m/A", between(1e-9, 1e3),
                "torque of the motor per ampere"));
    visit(field("back_emf_constant", &Motor::back_emf_constant, "V s/rad", between(0, 1e3),
                "voltage that the turning motor induces"));
    visit(field("gear_ratio", &Motor::gear_ratio, "", between(1e-3, 1e6),
                "turns of the motor per turn of the wheel"));
    visit(field("rotor_inertia", &Motor::rotor_inertia, "kg m^2", between(0, 1e3),
                "moment of inertia of the rotor"));
    visit(field("viscous_friction", &Motor::viscous_friction, "N m s/rad", between(0, 1e6),
                "viscous friction at each wheel"));
    visit(field("coulomb_friction", &Motor::coulomb_friction, "N m", between(0, 1e6),
                "Coulomb friction at each wheel"));
    visit(field("supply_voltage", &Motor::supply_voltage, "V", between(1e-6, 1e6),
                "largest voltage of a motor, in either direction"));
  }

  // Torque at the wheel per volt at standstill [N m/V].
  constexpr Base torque_per_volt() const { return gear_ratio * torque_constant / resistance; }
  // What back EMF and bearings take from the wheel per turning rate [N m s/rad].
  constexpr Base damping() const {
    return torque_per_volt() * gear_ratio * back_emf_constant + viscous_friction;
  }
};

// The robot with what the rotors add to its mass and inertia.
template <class Base>
constexpr Robot<Base> with_rotors(const Robot<Base>& robot, const Motor<Base>& motor) {
  const Base at_rim = motor.gear_ratio * motor.gear_ratio * motor.rotor_inertia /
                      (robot.wheel_radius * robot.wheel_radius);
  Robot<Base> loaded = robot;
  loaded.mass = robot.mass + Base(2) * at_rim;
  loaded.inertia = robot.inertia + at_rim * robot.track_width * robot.track_width * Base(0.5);
  return loaded;
}

// A plant (plant.hpp) whose input is the pair of voltages [V], in the paper's sign as torques are.
template <class Base>
class MotorDrive {
 public:
  using Parameters = Motor<Base>;
  static constexpr int size = DifferentialDrive<Base>::size;

  // `dt` is the sample time [s], divided into `substeps` equal steps.
  constexpr MotorDrive(const Robot<Base>& robot, const Motor<Base>& motor, Integrator integrator,
                       Base dt, int substeps)
      : drive_(with_rotors(robot, motor), {motor.damping(), motor.coulomb_friction}, integrator, dt,
               substeps),
        torque_per_volt_(motor.torque_per_volt()),
        supply_(motor.supply_voltage) {}

  template <class Scalar>
  NFOPIDN_INLINE constexpr void advance(State<Scalar>& state, const Heading<Scalar>& heading,
                                        const TorquePair<Scalar>& voltage,
                                        const Disturbance<Base>* outside = nullptr) const {
    drive_.advance(state, heading,
                   TorquePair<Scalar>{supplied(voltage.left) * torque_per_volt_,
                                      supplied(voltage.right) * torque_per_volt_},
                   outside);
  }

  // The voltages that give the accelerations at the state's speeds, with the viscous friction and
  // the back EMF made up for and without Coulomb friction. The supply's limit is not applied.
  template <class Scalar>
  constexpr TorquePair<Scalar> inverse(const State<Scalar>& state, const Scalar& linear,
                                       const Scalar& angular) const {
    const TorquePair<Scalar> torque = drive_.inverse(state, linear, angular);
    const Base volts = Base(1) / torque_per_volt_;
    return {torque.left * volts, torque.right * volts};
  }

  constexpr bool is_exact() const { return drive_.is_exact(); }

  template <class Scalar>
  static constexpr Heading<Scalar> heading(const State<Scalar>& state) {
    return DifferentialDrive<Base>::heading(state);
  }

 private:
  template <class Scalar>
  NFOPIDN_INLINE constexpr Scalar supplied(const Scalar& voltage) const {
    using M = math<Scalar>;
    return M::maximum(M::minimum(voltage, Scalar(supply_)), Scalar(-supply_));
  }

  DifferentialDrive<Base> drive_;
  Base torque_per_volt_;  // [N m/V]
  Base supply_;           // [V]
};

}  // namespace nfopidn
