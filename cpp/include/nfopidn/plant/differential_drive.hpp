// L1. One sample of the robot's motion under constant torques, by either integrator.
#pragma once

#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/plant/exact_motion.hpp"
#include "nfopidn/plant/friction.hpp"

namespace nfopidn {

enum class Integrator : unsigned char {
  semi_implicit_euler,  // v and omega first, then the pose with them: the paper's scenario
  exact,                // the pose to 1e-10: see exact_motion.hpp
};

template <>
struct ChoiceNames<Integrator> {
  static constexpr const char* names[] = {"semi-implicit-euler", "exact"};
};

// The robot's parameters may be lanes, each lane a robot of its own; the sample time is one number.
template <class Number>
class DifferentialDrive {
 public:
  using Base = base_t<Number>;
  using Parameters = Robot<Number>;
  static constexpr int size = 5;  // numbers of State

  // `dt` is the sample time [s], divided into `substeps` equal steps.
  constexpr DifferentialDrive(const Robot<Number>& robot, const Friction<Number>& friction,
                              Integrator integrator, Base dt, int substeps)
      : acceleration_(robot),
        friction_(robot, friction),
        integrator_(integrator),
        step_(dt / Base(substeps)),
        drive_gain_(step_ * acceleration_.drive),
        steer_gain_(step_ * acceleration_.steer),
        force_gain_(step_ * acceleration_.inverse_mass),
        moment_gain_(step_ * acceleration_.inverse_inertia),
        substeps_(substeps),
        has_coulomb_(!math<Number>::every(friction.coulomb == Base(0))),
        has_scrub_(!math<Number>::every(friction.scrub_coulomb == Base(0))),
        has_friction_(!math<Number>::every(friction.viscous == Base(0)) ||
                      !math<Number>::every(friction.scrub_viscous == Base(0)) || has_coulomb_ ||
                      has_scrub_) {}

  constexpr bool is_exact() const { return integrator_ == Integrator::exact; }

  // `heading` is that of state.theta; `outside` may be null.
  template <class Scalar>
  NFOPIDN_INLINE constexpr void advance(State<Scalar>& state, const Heading<Scalar>& heading,
                                        const TorquePair<Scalar>& torque,
                                        const Disturbance<Number>* outside = nullptr) const {
    if (integrator_ == Integrator::semi_implicit_euler) {
      euler(state, heading, torque, outside);
      for (int i = 1; i < substeps_; ++i) {
        euler(state, math<Scalar>::heading(state.theta), torque, outside);
      }
    } else {
      const Disturbance<Number> calm = {Number(Base(0)), Number(Base(0))};
      const Disturbance<Number>& acting = outside != nullptr ? *outside : calm;
      const Scalar linear = acceleration_.linear(torque, acting);
      const Scalar angular = acceleration_.angular(torque, acting);
      // Moved in a copy: the caller's state never leaves its registers.
      State<Scalar> moved = state;
      ExactMotion<Scalar>::advance(acceleration_, friction_, step_, substeps_, linear, angular,
                                   heading, moved);
      state = moved;
    }
  }

  // The torques that give the accelerations at the state's speeds, with the viscous friction made
  // up for and without Coulomb friction.
  template <class Scalar>
  constexpr TorquePair<Scalar> inverse(const State<Scalar>& state, const Scalar& linear,
                                       const Scalar& angular) const {
    const Scalar both =
        (linear + state.v * friction_.linear_rate) * (Base(1) / acceleration_.drive);
    const Scalar difference =
        (angular + state.omega * friction_.angular_rate) * (Base(1) / acceleration_.steer);
    return {(both + difference) * Base(0.5), (both - difference) * Base(0.5)};
  }

  template <class Scalar>
  static constexpr Heading<Scalar> heading(const State<Scalar>& state) {
    return math<Scalar>::heading(state.theta);
  }

 private:
  template <class Scalar>
  NFOPIDN_INLINE constexpr void euler(State<Scalar>& state, const Heading<Scalar>& heading,
                                      const TorquePair<Scalar>& torque,
                                      const Disturbance<Number>* outside) const {
    const Scalar sum = torque.left + torque.right;
    const Scalar difference = torque.left - torque.right;
    if (outside != nullptr) {
      state.v = state.v + outside->force * force_gain_;
      state.omega = state.omega + outside->moment * moment_gain_;
    }
    const State<Scalar> before = state;
    state.v = state.v + sum * drive_gain_;
    state.omega = state.omega + difference * steer_gain_;
    if constexpr (traits::is_floating_point<Scalar>) {
      if (!has_friction_) {
        // The sums below with what is known before the torque summed first: it is known last, and
        // everything waits for it. Many lanes at once have no waiting to shorten.
        const Scalar coasted = before.v * step_;
        const Number push = drive_gain_ * step_;
        state.x = (state.x + coasted * heading.cosine) + sum * (heading.cosine * push);
        state.y = (state.y + coasted * heading.sine) + sum * (heading.sine * push);
        state.theta = (state.theta + before.omega * step_) + difference * (steer_gain_ * step_);
        return;
      }
    }
    if (has_friction_) {
      State<Scalar> slowed_down = state;
      apply_friction(slowed_down);
      state.v = slowed_down.v;
      state.omega = slowed_down.omega;
    }
    const Scalar distance = state.v * step_;
    state.x = state.x + distance * heading.cosine;
    state.y = state.y + distance * heading.sine;
    state.theta = state.theta + state.omega * step_;
  }

  // Implicit in both kinds of friction, so that no step size makes it unstable or chatter.
  template <class Scalar>
  NFOPIDN_NOINLINE constexpr void apply_friction(State<Scalar>& state) const {
    state.v = state.v * (Base(1) / (Base(1) + step_ * friction_.linear_rate));
    state.omega = state.omega * (Base(1) / (Base(1) + step_ * friction_.angular_rate));
    if (has_scrub_) state.omega = scrubbed(state.omega, friction_.scrub * step_);
    if (!has_coulomb_) return;
    const Scalar turn = state.omega * friction_.half_track;
    const Number per_radius = Base(1) / friction_.wheel_radius;
    const TorquePair<Scalar> speeds = {(state.v + turn) * per_radius,
                                       (state.v - turn) * per_radius};
    const TorquePair<Scalar> impulse =
        opposing_friction(friction_, speeds, friction_.coulomb * step_);
    state.v = state.v + (impulse.left + impulse.right) * acceleration_.drive;
    state.omega = state.omega + (impulse.left - impulse.right) * acceleration_.steer;
  }

  Acceleration<Number> acceleration_;
  FrictionCoefficients<Number> friction_;
  Integrator integrator_;
  Base step_;          // [s]
  Number drive_gain_;  // changes of v and omega in a step, per N m, N and N m
  Number steer_gain_;
  Number force_gain_;
  Number moment_gain_;
  int substeps_;
  bool has_coulomb_;
  bool has_scrub_;  // Coulomb
  bool has_friction_;
};

}  // namespace nfopidn
