// L3. Points, and the box in which they are searched for.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "nfopidn/math/math.hpp"

namespace nfopidn {

using Points = Eigen::MatrixXd;  // a column a point
using Point = Eigen::VectorXd;

// The box of the search. `power` maps the unit box to it: 1 in proportion; 2 by a parabola and 3 by
// a cubic, which search small values more finely; 0 by an exponential, for bounds above 0, so that
// equal steps are equal ratios. Parabola and cubic leave 0 with a slope: with none, as u^2 has it,
// every cost is stationary at the lower bound, and a descent that touches it never leaves.
struct Box {
  static constexpr double start_slope = 0.03;  // before division by 1 + start_slope
  static constexpr double logarithmic = 0;
  Point low, high, power;

  Eigen::Index dimension() const { return low.size(); }
  Points to_user(const Eigen::Ref<const Points>& unit) const {
    Points points;
    to_user(unit, points);
    return points;
  }
  // The same into `points`, which keeps its memory where the size is the same.
  void to_user(const Eigen::Ref<const Points>& unit, Points& points) const {
    points.resize(unit.rows(), unit.cols());
    if ((power.array() == 1).all()) {
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        points.col(j) = low + (high - low).cwiseProduct(unit.col(j));
      }
      return;
    }
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      for (Eigen::Index i = 0; i < points.rows(); ++i) {
        points(i, j) = coordinate(i, unit(i, j));
      }
    }
  }
  Point to_unit(const Point& point) const {
    Point unit(point.size());
    for (Eigen::Index i = 0; i < point.size(); ++i) unit(i) = unit_coordinate(i, point(i));
    return unit;
  }
  // d user / d unit.
  Point stretch(const Point& unit) const {
    Point slopes(unit.size());
    for (Eigen::Index i = 0; i < unit.size(); ++i) {
      const double u = unit(i);
      double slope = 1;
      if (power(i) == 2) slope = (2 * u + start_slope) / (1 + start_slope);
      if (power(i) == 3) slope = (3 * u * u + start_slope) / (1 + start_slope);
      slopes(i) = (high(i) - low(i)) * slope;
      if (power(i) == logarithmic) slopes(i) = coordinate(i, u) * log_ratio(i);
    }
    return slopes;
  }

 private:
  double log_ratio(Eigen::Index i) const { return math<double>::log(high(i) / low(i)); }

  double coordinate(Eigen::Index i, double u) const {
    double share = u;
    if (power(i) == 2) share = u * (u + start_slope) / (1 + start_slope);
    if (power(i) == 3) share = u * (u * u + start_slope) / (1 + start_slope);
    if (power(i) == logarithmic) {
      if (u >= 1) return high(i);
      return low(i) * math<double>::exponential(u * log_ratio(i));
    }
    return low(i) + (high(i) - low(i)) * share;
  }

  double unit_coordinate(Eigen::Index i, double value) const {
    constexpr double half = start_slope / 2;
    if (!(high(i) > low(i))) return 0;
    if (power(i) == logarithmic) {
      const double bounded = std::min(high(i), std::max(low(i), value));
      return std::min(1.0, math<double>::log(bounded / low(i)) / log_ratio(i));
    }
    const double share = std::min(1.0, std::max(0.0, (value - low(i)) / (high(i) - low(i))));
    if (power(i) == 2) return std::sqrt(share * (1 + start_slope) + half * half) - half;
    if (power(i) == 3) return root_of_cubic(share * (1 + start_slope));
    return share;
  }

  // u of u (u^2 + start_slope) = value, by Newton's method from above, where it falls to the root.
  static double root_of_cubic(double value) {
    double u = 1;
    for (int i = 0; i < 60; ++i) {
      const double next = u - (u * (u * u + start_slope) - value) / (3 * u * u + start_slope);
      if (!(next < u)) break;
      u = next;
    }
    return std::max(0.0, u);
  }
};

template <class Expression>
auto clip_to_box(const Eigen::MatrixBase<Expression>& point) {
  return point.cwiseMax(0.0).cwiseMin(1.0);
}

}  // namespace nfopidn
