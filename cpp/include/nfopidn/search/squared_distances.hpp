// L3. Squared distances of a point to many, two at a time.
#pragma once

#include "nfopidn/math/ordered_sums.hpp"

namespace nfopidn {

class SquaredDistances {
 public:
  // A column a place.
  void set_places(const Eigen::MatrixXd& places) {
    dimension_ = places.rows();
    count_ = places.cols();
    // Coordinate by coordinate, so that those of two places lie together.
    across_.setZero(count_ + count_ % 2, dimension_);
    across_.topRows(count_) = places.transpose();
  }

  // To each place. The terms are summed in the order of Eigen's squaredNorm() on vectors of two, so
  // that results are those of code that calls it, and the same on every processor.
  void of(const double* point, double* squares) const {
    for (Eigen::Index n = 0; n < count_; n += 2) {
      const Two pair = of_pair(point, n);
      squares[n] = pair[0];
      if (n + 1 < count_) squares[n + 1] = pair[1];
    }
  }

 private:
  using Two [[gnu::vector_size(16)]] = double;

  Two of_pair(const double* point, Eigen::Index n) const {
    const auto term = [&](Eigen::Index i) {
      const double* const places = across_.data() + i * across_.rows() + n;
      const Two away = point[i] - Two{places[0], places[1]};
      return away * away;
    };
    return sum_of<Two>(dimension_, term);
  }

  Eigen::MatrixXd across_;
  Eigen::Index dimension_ = 0;
  Eigen::Index count_ = 0;
};

}  // namespace nfopidn
