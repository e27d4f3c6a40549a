// L3. What of a run is kept where there are many: its metrics, and what comparisons add.
#pragma once

#include <cmath>
#include <limits>
#include <vector>

#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn {

// A run has settled when its position error stays within this [m].
constexpr double settled_within = 0.05;

struct RunFigures {
  Metrics metrics;
  double settling_time;     // [s]
  double torque_deviation;  // [N m]
  double diverged_at;       // [s]; nan where it did not

  // Calls visit(name, value) for each in order.
  template <class Visit>
  void for_each(const Visit& visit) const {
    Metrics::fields([&](const auto& field) { visit(field.name, metrics.*field.member); });
    visit("settling_time", settling_time);
    visit("torque_deviation", torque_deviation);
    visit("diverged_at", diverged_at);
  }

  static std::vector<const char*> names() {
    std::vector<const char*> all;
    RunFigures{}.for_each([&](const char* name, double /*value*/) { all.push_back(name); });
    return all;
  }
};

// The last time [s] at which the position error exceeds settled_within: 0 if it never does,
// infinite if the run diverges or exceeds it at its last sample.
inline double settling_time(const SimulationResult& run) {
  const RunTable& table = run.table;
  constexpr double never = std::numeric_limits<double>::infinity();
  if (run.diverged) return never;
  for (Eigen::Index k = table.rows(); k-- > 0;) {
    const double x = table(k, column_e_x), y = table(k, column_e_y);
    if (!(std::sqrt(x * x + y * y) > settled_within)) continue;
    if (k + 1 == table.rows()) return never;
    return table(k, column_t);
  }
  return 0;
}

// The root mean square of the torques' distance from the reference's [N m]; nan without samples.
inline double torque_deviation(const SimulationResult& run) {
  const RunTable& table = run.table;
  if (table.rows() == 0) return std::numeric_limits<double>::quiet_NaN();
  const auto left = table.col(column_tau_ref_left) - table.col(column_tau_left);
  const auto right = table.col(column_tau_ref_right) - table.col(column_tau_right);
  return std::sqrt(mean(left.square() + right.square()));
}

inline RunFigures figures_of(const SimulationResult& run) {
  return {run.metrics, settling_time(run), torque_deviation(run),
          run.diverged ? run.diverged_at : std::numeric_limits<double>::quiet_NaN()};
}

}  // namespace nfopidn
