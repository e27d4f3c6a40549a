// L3. Points, and the box in which they are searched for.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace nfopidn {

using Points = Eigen::MatrixXd;  // a column a point
using Point = Eigen::VectorXd;

// The box of the search. `bend` maps the unit box to it: 1 in proportion, 2 by a parabola, which
// searches small values more finely. The parabola leaves 0 with a slope: with none, as u^2 has it,
// every cost is stationary at the lower bound, and a descent that touches it never leaves.
struct Box {
  static constexpr double start_slope = 0.03;  // before division by 1 + start_slope
  Point low, high, bend;

  Eigen::Index dimension() const { return low.size(); }
  Points to_user(const Eigen::Ref<const Points>& unit) const {
    Points points;
    to_user(unit, points);
    return points;
  }
  // The same into `points`, which keeps its memory where the size is the same.
  void to_user(const Eigen::Ref<const Points>& unit, Points& points) const {
    points.resize(unit.rows(), unit.cols());
    if ((bend.array() != 2).all()) {
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        points.col(j) = low + (high - low).cwiseProduct(unit.col(j));
      }
      return;
    }
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      for (Eigen::Index i = 0; i < points.rows(); ++i) {
        const double u = unit(i, j);
        points(i, j) = low(i) + (high(i) - low(i)) *
                                    (bend(i) == 2 ? u * (u + start_slope) / (1 + start_slope) : u);
      }
    }
  }
  Point to_unit(const Point& point) const {
    constexpr double half = start_slope / 2;
    Point unit(point.size());
    for (Eigen::Index i = 0; i < point.size(); ++i) {
      const double share = high(i) > low(i) ? (point(i) - low(i)) / (high(i) - low(i)) : 0;
      const double inside = std::min(1.0, std::max(0.0, share));
      unit(i) = bend(i) == 2 ? std::sqrt(inside * (1 + start_slope) + half * half) - half : inside;
    }
    return unit;
  }
  // d user / d unit.
  Point stretch(const Point& unit) const {
    Point slopes(unit.size());
    for (Eigen::Index i = 0; i < unit.size(); ++i) {
      const double slope = (2 * unit(i) + start_slope) / (1 + start_slope);
      slopes(i) = (high(i) - low(i)) * (bend(i) == 2 ? slope : 1);
    }
    return slopes;
  }
};

template <class Expression>
auto clip_to_box(const Eigen::MatrixBase<Expression>& point) {
  return point.cwiseMax(0.0).cwiseMin(1.0);
}

}  // namespace nfopidn
