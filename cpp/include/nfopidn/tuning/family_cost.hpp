// L4. One cost of the costs of several scenarios: the mean of the worst of them, each capped.
#pragma once

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/search/objective.hpp"
#include "nfopidn/search/ranking.hpp"
#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn {

// A cost E beyond the cap c counts as c (1 + ln(E / c)): one run that diverges does not outweigh
// all others, and of two that diverge the better one still counts as the better. Value and slope
// are continuous at the cap.
struct CostCap {
  double cap = std::numeric_limits<double>::infinity();

  double seen(double cost) const { return cost > cap ? cap * (1 + std::log(cost / cap)) : cost; }
  // What d(seen)/d(cost) is at a cost.
  double slope(double cost) const { return cost > cap ? cap / cost : 1.0; }
  // The cost that is seen as this.
  double unseen(double seen) const { return seen > cap ? cap * std::exp(seen / cap - 1) : seen; }
};

namespace detail {

inline double sign_of(double value) { return std::copysign(value != 0 ? 1.0 : 0.0, value); }

}  // namespace detail

// The cost (eq. 41) of nothing but the torques that friction takes on the reference: no controller
// that stays on the path costs less, for the reference torques are without friction.
inline double friction_cost(const Scenario& scenario) {
  const Trajectory& t = scenario.trajectory;
  double sum = 0;
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const TorquePair<double> speed = wheel_speeds(scenario.robot, t.v(k), t.omega(k));
    // What scrub takes of the left wheel, and gives back at the right one.
    const double scrub = (scenario.viscous_scrub * t.omega(k) +
                          detail::sign_of(t.omega(k)) * scenario.coulomb_scrub) *
                         scenario.robot.wheel_radius / scenario.robot.track_width;
    for (const auto& [wheel, more] : {std::pair{speed.left, scrub}, {speed.right, -scrub}}) {
      const double torque = scenario.viscous_friction * wheel +
                            detail::sign_of(wheel) * scenario.coulomb_friction + more;
      sum += torque * torque;
    }
  }
  return scenario.cost_weights[2] * sum / static_cast<double>(t.size());
}

// The cap of a search over a family: 1, or ten times what friction alone costs, if that is more.
inline double family_cap(const Scenario& scenario) {
  return std::max(1.0, 10 * friction_cost(scenario));
}

// The weight of each scenario's cost in the mean of the worst `share` of them.
inline Eigen::VectorXd worst_share_weights(const Eigen::VectorXd& costs, double share) {
  const double worst = std::max(share * static_cast<double>(costs.size()), 1.0);
  Eigen::VectorXd weight = Eigen::VectorXd::Zero(costs.size());
  double left = worst;
  const std::vector<Eigen::Index> order = ranking(costs);
  for (auto place = order.rbegin(); place != order.rend() && left > 0; ++place) {
    weight(*place) = std::min(left, 1.0) / worst;
    left -= 1;
  }
  return weight;
}

// The sum of the largest `amount` of the costs, of the last of them a part.
inline double sum_of_worst(const Eigen::VectorXd& costs, double amount) {
  double sum = 0;
  const std::vector<Eigen::Index> order = ranking(costs);
  for (auto place = order.rbegin(); place != order.rend() && amount > 0; ++place) {
    sum += std::min(amount, 1.0) * costs(*place);
    amount -= 1;
  }
  return sum;
}

// The mean of the worst `share` of the scenarios' costs (the conditional value at risk), so that 1
// is the mean and 0 the worst case.
struct FamilyCost {
  double share = 1;
  std::vector<CostCap> caps = {};  // one a scenario; none: costs count as they are

  // NOLINTNEXTLINE(google-explicit-constructor): a share alone is a mean without caps
  FamilyCost(double worst_share, const std::vector<double>& given = {}) : share(worst_share) {
    for (const double cap : given) caps.push_back({cap});
  }

  CostCap cap(Eigen::Index scenario) const {
    return caps.empty() ? CostCap{} : caps[static_cast<std::size_t>(scenario)];
  }
  // How many scenarios' costs make the mean; the mean is no less than what one of them gives to it.
  double worst(Eigen::Index scenarios) const {
    return std::max(share * static_cast<double>(scenarios), 1.0);
  }
  // The cost of one that they are. Of some of them, with 0 for the others, a bound from below.
  double of_seen(const Eigen::VectorXd& seen) const {
    return dot(seen, worst_share_weights(seen, share));
  }
  // What the next scenario's cost may be as it is, with these seen and 0 for those still to come,
  // so that the family's stays within `bound`: more is surely too much.
  double most_of_next(const Eigen::VectorXd& seen, double bound, Eigen::Index next) const {
    const double amount = worst(seen.size());
    const double rest = spared(bound) * amount - sum_of_worst(seen, amount - 1);
    return cap(next).unseen(std::max(rest, 0.0));
  }
  bool is_surely_over(const Eigen::VectorXd& seen, double bound) const {
    return of_seen(seen) > spared(bound);
  }
  // Costs as they count, in the place of costs as they are.
  void see(Eigen::VectorXd& costs) const {
    if (caps.empty()) return;
    for (Eigen::Index i = 0; i < costs.size(); ++i) costs(i) = cap(i).seen(costs(i));
  }

 private:
  // A bound beyond which no rounding brings a cost that is within it.
  static double spared(double bound) { return bound * (1 + 1e-9); }
};

}  // namespace nfopidn
