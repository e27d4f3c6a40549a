// What the tests of the robot's motion share.
#pragma once

#include "support.hpp"

namespace nfopidn::test {

// The paper's robot turns each wheel almost alone (its inertia is that of a hoop); in the others a
// torque on one wheel pulls the other along, or pushes it back.
inline std::vector<Robot<double>> some_robots() {
  return {Robot<double>::eddie(), Robot<double>::eddie_datasheet(), {4, 0.5, 0.3, 0.1}};
}

struct Surroundings {
  Robot<double> robot;
  Friction<double> friction = {};
  TorquePair<double> torque = {0, 0};
  Disturbance<double> outside = {0, 0};
};

inline State<double> moved(const Surroundings& around, Integrator integrator, double span,
                           int substeps, State<double> state) {
  const DifferentialDrive<double> plant(around.robot, around.friction, integrator, span, substeps);
  plant.advance(state, math<double>::heading(state.theta), around.torque, &around.outside);
  return state;
}

inline double largest_difference(const State<double>& a, const State<double>& b) {
  return std::max({std::fabs(a.x - b.x), std::fabs(a.y - b.y), std::fabs(a.theta - b.theta),
                   std::fabs(a.v - b.v), std::fabs(a.omega - b.omega)});
}

inline double energy(const Robot<double>& robot, const State<double>& state) {
  return 0.5 * robot.mass * state.v * state.v + 0.5 * robot.inertia * state.omega * state.omega;
}

struct RealState {
  Real x, y, theta, v, omega;
};

// Runge and Kutta's fourth-order method on the design's equations of motion, with friction at the
// axles. Each wheel's Coulomb friction opposes `slide` (+-1), and its speed must keep that sign.
class RungeKutta {
 public:
  RungeKutta(const Surroundings& around, const std::array<Real, 2>& slide)
      : around_(around), slide_(slide) {}

  RealState run(RealState s, Real span, int steps) const {
    const Real h = span / steps;
    for (int i = 0; i < steps; ++i) {
      const RealState k1 = slope(s);
      const RealState k2 = slope(shifted(s, k1, h / 2));
      const RealState k3 = slope(shifted(s, k2, h / 2));
      const RealState k4 = slope(shifted(s, k3, h));
      s = shifted(shifted(shifted(shifted(s, k1, h / 6), k2, h / 3), k3, h / 3), k4, h / 6);
      expect_sliding(s);
    }
    return s;
  }

  std::array<Real, 2> wheels(const RealState& s) const {
    const Robot<double>& r = around_.robot;
    return {(s.v + s.omega * r.track_width / 2) / r.wheel_radius,
            (s.v - s.omega * r.track_width / 2) / r.wheel_radius};
  }

 private:
  static RealState shifted(const RealState& s, const RealState& slope, Real h) {
    return {s.x + h * slope.x, s.y + h * slope.y, s.theta + h * slope.theta, s.v + h * slope.v,
            s.omega + h * slope.omega};
  }
  RealState slope(const RealState& s) const {
    const Robot<double>& r = around_.robot;
    const Friction<double>& f = around_.friction;
    const std::array<Real, 2> speed = wheels(s);
    const Real left = around_.torque.left - f.viscous * speed[0] - f.coulomb * slide_[0];
    const Real right = around_.torque.right - f.viscous * speed[1] - f.coulomb * slide_[1];
    return {s.v * std::cos(s.theta), s.v * std::sin(s.theta), s.omega,
            (left + right) / (Real(r.mass) * r.wheel_radius) + around_.outside.force / r.mass,
            r.track_width * (left - right) / (2 * Real(r.inertia) * r.wheel_radius) +
                around_.outside.moment / r.inertia};
  }
  void expect_sliding(const RealState& s) const {
    if (around_.friction.coulomb == 0) return;
    const std::array<Real, 2> speed = wheels(s);
    EXPECT_GT(speed[0] * slide_[0], 0);
    EXPECT_GT(speed[1] * slide_[1], 0);
  }

  Surroundings around_;
  std::array<Real, 2> slide_;
};

}  // namespace nfopidn::test
