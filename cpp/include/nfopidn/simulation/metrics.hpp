// L3. What a run is judged by.
#pragma once

#include <Eigen/Core>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn {

// Columns of the run table.
enum Column : int {
  column_t,
  column_x_ref,
  column_y_ref,
  column_theta_ref,
  column_x,
  column_y,
  column_theta,
  column_v,
  column_omega,
  column_e_x,
  column_e_y,
  column_e_theta,
  column_tau_ref_left,
  column_tau_ref_right,
  column_tau_fb_left,
  column_tau_fb_right,
  column_tau_left,
  column_tau_right,
  column_count
};
constexpr const char* column_names[column_count] = {"t",
                                                    "x_ref",
                                                    "y_ref",
                                                    "theta_ref",
                                                    "x",
                                                    "y",
                                                    "theta",
                                                    "v",
                                                    "omega",
                                                    "e_x",
                                                    "e_y",
                                                    "e_theta",
                                                    "tau_ref_left",
                                                    "tau_ref_right",
                                                    "tau_fb_left",
                                                    "tau_fb_right",
                                                    "tau_left",
                                                    "tau_right"};

using RunTable = Eigen::Array<double, Eigen::Dynamic, column_count, Eigen::RowMajor>;

struct Metrics {
  double cost = 0;
  double pose_mse = 0;
  double position_rms = 0;
  double position_max = 0;
  double heading_rms = 0;
  double iae = 0;
  double ise = 0;
  double itae = 0;
  double torque_peak = 0;
  double torque_variation = 0;
  double share_at_limit = 0;
  double energy = 0;
  double lateral_force_peak = 0;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using M = Metrics;
    const auto add = [&](const char* name, double M::*member, const char* unit, const char* text) {
      visit(field(name, member, unit, any_number(), text));
    };
    add("cost", &M::cost, "", "E of eq. 41");
    add("pose_mse", &M::pose_mse, "", "mean square of the pose error, m^2 and rad^2 added");
    add("position_rms", &M::position_rms, "m", "root mean square position error");
    add("position_max", &M::position_max, "m", "largest position error");
    add("heading_rms", &M::heading_rms, "rad", "root mean square heading error");
    add("iae", &M::iae, "m s", "integral of the position error's size");
    add("ise", &M::ise, "m^2 s", "integral of its square");
    add("itae", &M::itae, "m s^2", "integral of its size times time");
    add("torque_peak", &M::torque_peak, "N m", "largest torque of a wheel");
    add("torque_variation", &M::torque_variation, "N m", "total variation of both torques");
    add("share_at_limit", &M::share_at_limit, "", "samples with a torque at its limit");
    add("energy", &M::energy, "J", "integral of |torque times wheel speed|");
    add("lateral_force_peak", &M::lateral_force_peak, "N", "largest force across the wheels");
  }
};

// Metrics of the recorded rows, and the cost as the loop measured it. Without rows all but the cost
// are zero.
NFOPIDN_HOST Metrics measure(const RunTable& table, double cost, const Scenario& scenario);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST Metrics measure(const RunTable& table, double cost, const Scenario& scenario) {
  Metrics m;
  m.cost = cost;
  const Eigen::Index n = table.rows();
  if (n == 0) return m;
  const double dt = scenario.trajectory.dt();
  const Eigen::ArrayXd square = table.col(column_e_x).square() + table.col(column_e_y).square();
  const Eigen::ArrayXd distance = square.sqrt();
  const auto heading = table.col(column_e_theta);
  const auto left = table.col(column_tau_left);
  const auto right = table.col(column_tau_right);
  m.pose_mse = mean(square + heading.square());
  m.position_rms = std::sqrt(mean(square));
  m.position_max = distance.maxCoeff();
  m.heading_rms = std::sqrt(mean(heading.square()));
  m.iae = sum(distance) * dt;
  m.ise = sum(square) * dt;
  m.itae = sum(distance * table.col(column_t)) * dt;
  m.torque_peak = std::max(left.abs().maxCoeff(), right.abs().maxCoeff());
  m.torque_variation = sum((left.tail(n - 1) - left.head(n - 1)).abs()) +
                       sum((right.tail(n - 1) - right.head(n - 1)).abs());
  int at_limit = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double v = table(k, column_v);
    const double omega = table(k, column_omega);
    const double torque = std::max(std::fabs(left(k)), std::fabs(right(k)));
    at_limit += torque >= scenario.torque_limit ? 1 : 0;
    const TorquePair<double> speed = wheel_speeds(scenario.robot, v, omega);
    m.energy += (std::fabs(left(k) * speed.left) + std::fabs(right(k) * speed.right)) * dt;
    m.lateral_force_peak =
        std::max(m.lateral_force_peak, std::fabs(lateral_force(scenario.robot, v, omega)));
  }
  m.share_at_limit = static_cast<double>(at_limit) / static_cast<double>(n);
  return m;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
