// L3. The order of costs.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <vector>

namespace nfopidn {

// From best to worst; equal ones in their order.
inline std::vector<Eigen::Index> ranking(const Eigen::VectorXd& costs) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(costs.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Eigen::Index>(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](Eigen::Index a, Eigen::Index b) { return costs(a) < costs(b); });
  return order;
}

// The same from an earlier order, in which few are out of place.
inline void rank_anew(const Eigen::VectorXd& costs, std::vector<Eigen::Index>& order) {
  for (std::size_t n = 1; n < order.size(); ++n) {
    const Eigen::Index moved = order[n];
    std::size_t place = n;
    for (; place > 0; --place) {
      const Eigen::Index other = order[place - 1];
      if (costs(other) < costs(moved) || (costs(other) == costs(moved) && other < moved)) break;
      order[place] = other;
    }
    order[place] = moved;
  }
}

}  // namespace nfopidn
