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
  Base dead_band = Base(0);             // voltage that drive and gear swallow [V]

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
    visit(field("dead_band", &Motor::dead_band, "V", between(0, 1e6),
                "voltage below which a motor gives no torque; above, it is missing"));
  }

  // Torque at the wheel per volt at standstill [N m/V].
  constexpr Base torque_per_volt() const { return gear_ratio * torque_constant / resistance; }
  // What the back EMF takes of the torque per turning rate of the wheel [N m s/rad].
  constexpr Base back_emf_damping() const {
    return torque_per_volt() * gear_ratio * back_emf_constant;
  }
  // What back EMF and bearings take from the wheel per turning rate [N m s/rad].
  constexpr Base damping() const { return back_emf_damping() + viscous_friction; }

  // The voltage at which the motor gives a torque [N m] at a wheel that turns with `wheel_speed`
  // [rad/s], within the supply's. The bearings' friction and the dead band are not made up for.
  template <class Scalar>
  NFOPIDN_INLINE constexpr Scalar voltage(const Scalar& torque, const Scalar& wheel_speed) const {
    return supplied(torque * (Base(1) / torque_per_volt()) +
                    wheel_speed * (gear_ratio * back_emf_constant));
  }

  // A voltage as the supply can give it.
  template <class Scalar>
  NFOPIDN_INLINE constexpr Scalar supplied(const Scalar& voltage) const {
    return clipped(voltage, supply_voltage);
  }

  // A torque [N m] as the supply can give it at a wheel that turns with `wheel_speed` [rad/s].
  template <class Scalar>
  NFOPIDN_INLINE constexpr Scalar available(const Scalar& torque, const Scalar& wheel_speed) const {
    using M = math<Scalar>;
    const Scalar taken = wheel_speed * back_emf_damping();
    const Base stall = supply_voltage * torque_per_volt();
    return M::maximum(M::minimum(torque, Scalar(stall) - taken), Scalar(-stall) - taken);
  }

  // What is left of an applied voltage behind the dead band.
  template <class Scalar>
  NFOPIDN_INLINE constexpr Scalar effective(const Scalar& voltage) const {
    return voltage - clipped(voltage, dead_band);
  }

 private:
  template <class Scalar>
  static constexpr Scalar clipped(const Scalar& value, const Base& limit) {
    using M = math<Scalar>;
    return M::maximum(M::minimum(value, Scalar(limit)), Scalar(limit * Base(-1)));
  }
};

// Counts of a pulse-width modulator, of which `full_scale` is the supply's voltage: the nearest
// whole number, within +-full_scale.
template <class Base>
constexpr int pulse_width(const Motor<Base>& motor, Base voltage, int full_scale) {
  const Base counts = motor.supplied(voltage) * (Base(full_scale) / motor.supply_voltage);
  return static_cast<int>(counts < Base(0) ? counts - Base(0.5) : counts + Base(0.5));
}

// The robot with what the rotors add to its mass and inertia.
template <class Number, class Base>
constexpr Robot<Number> with_rotors(const Robot<Number>& robot, const Motor<Base>& motor) {
  return with_wheels(robot, motor.gear_ratio * motor.gear_ratio * motor.rotor_inertia);
}

// A plant (plant.hpp) whose input is the pair of voltages [V], in the paper's sign as torques are.
template <class Number>
class MotorDrive {
 public:
  using Base = base_t<Number>;
  using Parameters = Motor<Base>;
  static constexpr int size = DifferentialDrive<Number>::size;

  // `dt` is the sample time [s], divided into `substeps` equal steps. `more` is friction besides
  // the motors' own.
  constexpr MotorDrive(const Robot<Number>& robot, const Motor<Base>& motor, Integrator integrator,
                       Base dt, int substeps, const Friction<Number>& more = {})
      : drive_(with_rotors(robot, motor),
               {more.viscous + motor.damping(), more.coulomb + motor.coulomb_friction,
                more.scrub_viscous, more.scrub_coulomb},
               integrator, dt, substeps),
        motor_(motor) {}

  template <class Scalar>
  NFOPIDN_INLINE constexpr void advance(State<Scalar>& state, const Heading<Scalar>& heading,
                                        const TorquePair<Scalar>& voltage,
                                        const Disturbance<Number>* outside = nullptr) const {
    drive_.advance(state, heading, TorquePair<Scalar>{torque(voltage.left), torque(voltage.right)},
                   outside);
  }

  // The voltages that give the accelerations at the state's speeds, with the viscous friction and
  // the back EMF made up for and without Coulomb friction and dead band. The supply's limit is not
  // applied.
  template <class Scalar>
  constexpr TorquePair<Scalar> inverse(const State<Scalar>& state, const Scalar& linear,
                                       const Scalar& angular) const {
    const TorquePair<Scalar> torque = drive_.inverse(state, linear, angular);
    const Base volts = Base(1) / motor_.torque_per_volt();
    return {torque.left * volts, torque.right * volts};
  }

  constexpr bool is_exact() const { return drive_.is_exact(); }
  constexpr const Motor<Base>& motor() const { return motor_; }

  template <class Scalar>
  static constexpr Heading<Scalar> heading(const State<Scalar>& state) {
    return DifferentialDrive<Number>::heading(state);
  }

 private:
  // Of the motor at standstill: the back EMF is friction of the drive.
  template <class Scalar>
  NFOPIDN_INLINE constexpr Scalar torque(const Scalar& voltage) const {
    return motor_.effective(motor_.supplied(voltage)) * motor_.torque_per_volt();
  }

  DifferentialDrive<Number> drive_;
  Motor<Base> motor_;
};

}  // namespace nfopidn
