// L4. The robot's motion over one sample, linearised on a straight line at a given speed.
#pragma once

#include <Eigen/Core>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/math/dual.hpp"
#include "nfopidn/simulation/prepared_run.hpp"

namespace nfopidn {

constexpr int plant_size = RobotDrive<double>::size;

// Of the state x, y, theta, v, omega and the torques left, right.
struct LinearPlant {
  Eigen::Matrix<double, plant_size, plant_size> state;
  Eigen::Matrix<double, plant_size, 2> torque;
};

namespace detail {

inline State<Dual<double>> advance(const RobotDrive<double>& plant, double speed,
                                   const double (&torque)[2], int direction) {
  const auto number = [&](int i, double value) {
    return Dual<double>(value, i == direction ? 1.0 : 0.0);
  };
  State<Dual<double>> state = {number(0, 0), number(1, 0), number(2, 0), number(3, speed),
                               number(4, 0)};
  plant.advance(
      state, math<Dual<double>>::heading(state.theta),
      TorquePair<Dual<double>>{number(plant_size, torque[0]), number(plant_size + 1, torque[1])});
  return state;
}

}  // namespace detail

// At the torques that keep the speed against friction.
NFOPIDN_HOST LinearPlant linearise_plant(const RobotDrive<double>& plant, double speed);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST LinearPlant linearise_plant(const RobotDrive<double>& plant, double speed) {
  double torque[2] = {0, 0};
  // Between the corners of Coulomb friction v depends on the torque linearly: a few steps do.
  for (int i = 0; i < 8; ++i) {
    const Dual<double> v = detail::advance(plant, speed, torque, plant_size).v;
    if (v.slope == 0 || v.value == speed) break;
    const double change = (speed - v.value) / (2 * v.slope);
    torque[0] += change;
    torque[1] += change;
  }
  LinearPlant result;
  for (int direction = 0; direction < 7; ++direction) {
    const State<Dual<double>> to = detail::advance(plant, speed, torque, direction);
    Eigen::Matrix<double, plant_size, 1> slopes;
    slopes << to.x.slope, to.y.slope, to.theta.slope, to.v.slope, to.omega.slope;
    if (direction < plant_size) {
      result.state.col(direction) = slopes;
    } else {
      result.torque.col(direction - plant_size) = slopes;
    }
  }
  return result;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
