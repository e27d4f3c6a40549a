// L3. A bounded quasi-Newton descent in the unit box: BFGS on the free coordinates.
#pragma once

#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/search/session.hpp"

namespace nfopidn {

class QuasiNewton {
 public:
  explicit QuasiNewton(SearchSession& search) : search_(search) {}

  // Descends from `point` for at most about `evaluations`; leaves there the point it came to, and
  // returns its cost. Stops at a minimum, on a cliff, or when progress is too small to go on.
  // `goes_on` is asked after each step, with the cost. The curvature learnt in an earlier descent
  // is where this one starts from, until it proves wrong; forget() it where it would not help.
  template <class GoesOn>
  double descend(Point& point, std::int64_t evaluations, const GoesOn& goes_on) {
    const std::int64_t last = search_.result.evaluations + evaluations;
    const Eigen::Index p = search_.dimension();
    double cost = 0;
    if (!search_.objective().has_gradient()) cost = search_.evaluate(point)(0);
    Point slopes;
    if (!slopes_at(point, cost, slopes)) return std::numeric_limits<double>::infinity();
    if (inverse_.rows() != p) forget(p);
    for (int small = 0; small < 3 && search_.result.evaluations < last && !search_.done();) {
      const Point direction = choose_direction(point, slopes);
      if (direction.size() == 0) break;
      Point next = point;
      double next_cost = cost;
      if (!look_along(direction, next, next_cost) && !tumble(next, next_cost)) {
        if (fresh_) break;
        forget(p);
        continue;
      }
      const double before = cost;
      Point next_slopes;
      if (!slopes_at(next, next_cost, next_slopes)) {
        point = next;
        return next_cost;
      }
      learn(next - point, next_slopes - slopes);
      point = next;
      slopes = next_slopes;
      cost = next_cost;
      small = before - cost < 1e-9 * std::fabs(cost) ? small + 1 : 0;
      if (!goes_on(cost)) break;
    }
    return cost;
  }

  void forget() { forget(inverse_.rows()); }

 private:
  void forget(Eigen::Index p) {
    inverse_ = Eigen::MatrixXd::Identity(p, p);
    fresh_ = true;
  }

  // Exact where the objective has gradients, and then the cost too; else central differences.
  bool slopes_at(const Point& point, double& cost, Point& slopes) {
    if (search_.objective().has_gradient()) return search_.gradient(point, cost, slopes);
    constexpr double half_width = 1e-6;
    const Eigen::Index p = point.size();
    if (search_.left() < 2 * p) return false;
    Points stencil = point.replicate(1, 2 * p);
    for (Eigen::Index i = 0; i < p; ++i) {
      stencil(i, 2 * i) = std::min(1.0, point(i) + half_width);
      stencil(i, 2 * i + 1) = std::max(0.0, point(i) - half_width);
    }
    const Eigen::VectorXd costs = search_.evaluate(stencil);
    slopes.resize(p);
    for (Eigen::Index i = 0; i < p; ++i) {
      slopes(i) = (costs(2 * i) - costs(2 * i + 1)) / (stencil(i, 2 * i) - stencil(i, 2 * i + 1));
    }
    return slopes.allFinite() && std::isfinite(cost);
  }

  // Downhill on the coordinates that are not held at a bound; empty where there is none.
  Point choose_direction(const Point& point, const Point& slopes) {
    Point free = slopes;
    for (Eigen::Index i = 0; i < point.size(); ++i) {
      if ((point(i) <= 0 && slopes(i) > 0) || (point(i) >= 1 && slopes(i) < 0)) free(i) = 0;
    }
    if (norm(free) < 1e-12) return {};
    Point direction = -product(inverse_, free);
    for (Eigen::Index i = 0; i < point.size(); ++i) {
      if (free(i) == 0) direction(i) = 0;
    }
    if (dot(direction, free) > -1e-14 * norm(direction) * norm(free)) {
      forget(point.size());
      direction = -free;
    }
    constexpr double first_length = 0.02;
    constexpr double greatest_length = 0.5;
    const double length = norm(direction);
    if (fresh_) return direction * (first_length / length);
    return length > greatest_length ? Point(direction * (greatest_length / length)) : direction;
  }

  // Takes the best of a few lengths at once: they are evaluated together.
  bool look_along(const Point& direction, Point& point, double& cost) {
    static constexpr double lengths[3][4] = {
        {1, 0.4, 0.12, 2.2}, {0.03, 0.008, 0.002, 5}, {5e-4, 1e-4, 2e-5, 3e-6}};
    for (const auto& row : lengths) {
      Points ahead(point.size(), 4);
      for (Eigen::Index n = 0; n < 4; ++n) ahead.col(n) = clip_to_box(point + row[n] * direction);
      if (take_best(ahead, point, cost)) return true;
    }
    return false;
  }

  // On a cliff, where no gradient leads on: sparse tumbles of 1 to 3 coordinates.
  bool tumble(Point& point, double& cost) {
    constexpr double greatest = 0.01;
    for (int attempt = 0; attempt < 3 && fresh_; ++attempt) {
      Points around = point.replicate(1, 16);
      for (Eigen::Index n = 0; n < around.cols(); ++n) {
        Random& random = search_.random;
        const double size = greatest * math<double>::exponential(-3 * random.uniform());
        const int coordinates = 1 + static_cast<int>(3 * random.uniform());
        for (int c = 0; c < coordinates; ++c) {
          const double where = random.uniform() * static_cast<double>(point.size());
          around(static_cast<Eigen::Index>(where), n) += size * random.normal();
        }
        around.col(n) = clip_to_box(around.col(n));
      }
      if (take_best(around, point, cost)) return true;
    }
    return false;
  }

  bool take_best(const Points& candidates, Point& point, double& cost) {
    const Eigen::VectorXd bounds = Eigen::VectorXd::Constant(candidates.cols(), cost);
    Eigen::VectorXd costs;
    search_.evaluate(candidates, costs, &bounds);
    const Eigen::Index best = place_of_least(costs);
    const double least = costs(best);
    if (!(least < cost)) return false;
    point = candidates.col(best);
    cost = least;
    return true;
  }

  void learn(const Point& step, const Point& change) {
    const double curvature = dot(step, change);
    if (!(curvature > 1e-12 * norm(step) * norm(change))) return;
    if (fresh_) inverse_ *= curvature / squared_norm(change);
    fresh_ = false;
    const Point turned = product(inverse_, change);
    const double scale = (1 + dot(change, turned) / curvature) / curvature;
    for (Eigen::Index j = 0; j < step.size(); ++j) {
      for (Eigen::Index i = 0; i < step.size(); ++i) {
        inverse_(i, j) +=
            (scale * step(i)) * step(j) - (turned(i) * step(j) + step(i) * turned(j)) / curvature;
      }
    }
  }

  SearchSession& search_;
  Eigen::MatrixXd inverse_;
  bool fresh_ = true;
};

// Tells which of many descents to give up: what they would cost is better spent on another start.
class DescentWatch {
 public:
  explicit DescentWatch(double patience) : patience_(patience) {}

  // A descent starts that is worth going on with once it is under `best`.
  void begin(double best) {
    best_ = best;
    costs_.clear();
  }

  // Whether at its present pace it would come under the best in time.
  bool is_promising(double cost) {
    constexpr std::size_t first_steps = 13, steps = 8;
    costs_.push_back(cost);
    if (cost <= best_ || costs_.size() <= first_steps) return true;
    const double gained = costs_[costs_.size() - 1 - steps] - cost;
    return cost - best_ <= patience_ * gained;
  }

 private:
  std::vector<double> costs_;  // of the present descent, after each step
  double best_ = 0;
  double patience_;  // times `steps`
};

}  // namespace nfopidn
