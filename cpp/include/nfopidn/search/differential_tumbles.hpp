// L3. Tumbles of a cell along differences between cells of its colony.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "nfopidn/math/math.hpp"
#include "nfopidn/math/random.hpp"
#include "nfopidn/search/box.hpp"

namespace nfopidn {

// How far they reach, and in what share of the coordinates, is drawn around what succeeded before.
class DifferentialTumbles {
 public:
  struct Size {
    double reach;
    double share;
  };

  // Where cell k tumbles to: towards one of the colony's best fifth and along the difference of two
  // of its cells, in some coordinates. `mates` are the colony's cells from best to worst.
  Size tumble(Random& random, const Points& cells, const std::vector<Eigen::Index>& mates,
              Eigen::Index k, double* __restrict place) const {
    const Size size = draw(random);
    const auto count = static_cast<Eigen::Index>(mates.size());
    const auto [place_of_leader, always] =
        random.pair(std::max<Eigen::Index>(2, count / 5), cells.rows());
    const Eigen::Index leader = mates[static_cast<std::size_t>(place_of_leader)];
    Eigen::Index a = k, b = k;
    while (a == k || b == k || a == b) {
      const auto [one, other] = random.pair(count, count);
      a = mates[static_cast<std::size_t>(one)];
      b = mates[static_cast<std::size_t>(other)];
    }
    const double* const own = cells.col(k).data();
    const double* const best = cells.col(leader).data();
    const double* const from = cells.col(b).data();
    const double* const to = cells.col(a).data();
    const auto move = [&](Eigen::Index i, double by) {
      const double target = own[i] + by * ((best[i] - own[i]) + (to[i] - from[i]));
      // Half way to the wall it would have passed.
      place[i] = target < 0 ? own[i] / 2 : (target > 1 ? (1 + own[i]) / 2 : target);
    };
    // Each coordinate moves with probability `share`, rounded to 2^-16, and one moves in any case.
    // A table replaces the branch, which the processor could not predict.
    const double by[] = {0, size.reach};
    const auto bar = static_cast<std::uint64_t>(size.share * 65536);
    std::uint64_t draw = 0;
    for (Eigen::Index i = 0; i < cells.rows(); ++i) {
      draw = i % 4 == 0 ? random.bits() : draw >> 16;
      move(i, by[static_cast<int>((draw & 0xFFFF) < bar)]);
    }
    move(always, size.reach);
    return size;
  }

  // A tumble of this size led to a better place.
  void succeeded(const Size& size) {
    reach_sum_ += size.reach;
    reach_squares_ += size.reach * size.reach;
    share_sum_ += size.share;
    successes_ += 1;
  }

  // Once all cells have tumbled.
  void learn() {
    if (successes_ > 0) {
      reach_ = 0.9 * reach_ + 0.1 * reach_squares_ / reach_sum_;
      share_ = 0.9 * share_ + 0.1 * share_sum_ / successes_;
    }
    reach_sum_ = reach_squares_ = share_sum_ = successes_ = 0;
  }

 private:
  Size draw(Random& random) const {
    Size size = {};
    do {
      const Heading<double> h =
          math<double>::heading(math<double>::pi * (random.uniform() - 0.5));  // Cauchy: a tangent
      size.reach = reach_ + 0.1 * h.sine / h.cosine;
    } while (!(size.reach > 0));
    size.reach = std::min(size.reach, 1.0);
    constexpr double spread = 0.35;  // of a uniform distribution with standard deviation 0.1
    size.share = std::min(1.0, std::max(0.0, share_ + spread * (random.uniform() - 0.5)));
    return size;
  }

  double reach_ = 0.5;
  double share_ = 0.6;
  double reach_sum_ = 0, reach_squares_ = 0, share_sum_ = 0, successes_ = 0;  // of this step
};

}  // namespace nfopidn
