// L3. Points that cover the unit box.
#pragma once

#include "nfopidn/search/session.hpp"

namespace nfopidn {

// In each coordinate every `count`-th part of the box holds one point.
inline Points latin_hypercube(Random& random, Eigen::Index dimension, Eigen::Index count) {
  Points points(dimension, count);
  std::vector<Eigen::Index> strata(static_cast<std::size_t>(count));
  for (Eigen::Index i = 0; i < dimension; ++i) {
    for (std::size_t k = 0; k < strata.size(); ++k) strata[k] = static_cast<Eigen::Index>(k);
    for (std::size_t k = strata.size() - 1; k > 0; --k) {
      const double place = random.uniform() * static_cast<double>(k + 1);
      std::swap(strata[k], strata[static_cast<std::size_t>(place)]);
    }
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto stratum = static_cast<double>(strata[static_cast<std::size_t>(k)]);
      points(i, k) = (stratum + random.uniform()) / static_cast<double>(count);
    }
  }
  return points;
}

}  // namespace nfopidn
