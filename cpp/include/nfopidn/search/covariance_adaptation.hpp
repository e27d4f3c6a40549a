// L3. The normal distribution of CMA-ES and how it learns from ranked points (N. Hansen, The CMA
// Evolution Strategy: A Tutorial, arXiv:1604.00772, whose equation numbers stand beside the lines).
//
// All sums are plain loops in a fixed order, so that a search has the same bits on every processor.
#pragma once

#include <utility>
#include <vector>

#include "nfopidn/math/math.hpp"
#include "nfopidn/math/random.hpp"
#include "nfopidn/math/symmetric_eigen.hpp"
#include "nfopidn/search/box.hpp"

namespace nfopidn {

// The tutorial's default settings for a dimension n and a population lambda (table 1).
struct CmaConstants {
  Eigen::Index dimension;
  Eigen::Index population;   // lambda
  Eigen::Index parents;      // mu, the points with positive weights
  Eigen::VectorXd weights;   // w_i from the best point to the worst; the positive ones sum to 1
  double weight_sum;         // of all of them
  double effective_parents;  // mu_eff
  double path_rate;          // c_sigma
  double damping;            // d_sigma
  double shape_rate;         // c_c
  double rank_one_rate;      // c_1
  double rank_mu_rate;       // c_mu
  double expected_length;    // E|N(0, I)|

  // The least population for which the weights have both signs is 2.
  CmaConstants(Eigen::Index n, Eigen::Index lambda)
      : dimension(n), population(lambda), weights(lambda) {
    const auto size = static_cast<double>(n);
    rank_weights();
    const double m = effective_parents;
    path_rate = (m + 2) / (size + m + 5);  // eq. 55
    damping = 1 + 2 * std::max(0.0, std::sqrt((m - 1) / (size + 1)) - 1) + path_rate;
    shape_rate = (4 + m / size) / (size + 4 + 2 * m / size);  // eq. 56
    rank_one_rate = 2 / ((size + 1.3) * (size + 1.3) + m);    // eq. 57
    rank_mu_rate = std::min(1 - rank_one_rate,                // eq. 58
                            2 * (0.25 + m + 1 / m - 2) / ((size + 2) * (size + 2) + m));
    expected_length = std::sqrt(size) * (1 - 1 / (4 * size) + 1 / (21 * size * size));
    scale_negative_weights(size);
  }

 private:
  // Eqs. 49 and 8; the negative weights are not scaled yet.
  void rank_weights() {
    const double middle = math<double>::log((static_cast<double>(population) + 1) / 2);
    double sum = 0, squares = 0;
    parents = 0;
    for (Eigen::Index i = 0; i < population; ++i) {
      weights(i) = middle - math<double>::log(static_cast<double>(i + 1));
      if (!(weights(i) > 0)) continue;
      ++parents;
      sum += weights(i);
      squares += weights(i) * weights(i);
    }
    effective_parents = sum * sum / squares;
    for (Eigen::Index i = 0; i < parents; ++i) weights(i) /= sum;
  }

  // Eqs. 50 to 53.
  void scale_negative_weights(double size) {
    double sum = 0, squares = 0;
    for (Eigen::Index i = parents; i < population; ++i) {
      sum -= weights(i);
      squares += weights(i) * weights(i);
    }
    const double effective = squares > 0 ? sum * sum / squares : 0;
    const double balanced = 1 + rank_one_rate / rank_mu_rate;
    const double certain = 1 + 2 * effective / (effective_parents + 2);
    const double definite = (1 - rank_one_rate - rank_mu_rate) / (size * rank_mu_rate);
    const double wanted = std::max(0.0, std::min(balanced, std::min(certain, definite)));
    weight_sum = 0;
    for (Eigen::Index i = 0; i < population; ++i) {
      if (i >= parents && sum > 0) weights(i) *= wanted / sum;
      weight_sum += weights(i);
    }
  }
};

// N(mean, step^2 C). The points' coordinates may be any numbers.
class AdaptedNormal {
 public:
  AdaptedNormal(const CmaConstants& constants, Point mean, double step)
      : constants_(constants), mean_(std::move(mean)), step_(step) {
    const Eigen::Index n = constants.dimension;
    covariance_ = Eigen::MatrixXd::Identity(n, n);
    path_ = shape_path_ = Point::Zero(n);
    lengths_ = Point::Ones(n);
    eigen_.decompose(covariance_);
  }

  const Point& mean() const { return mean_; }
  double step() const { return step_; }  // sigma
  const Eigen::MatrixXd& covariance() const { return covariance_; }
  const Point& path() const { return path_; }              // p_sigma
  const Point& shape_path() const { return shape_path_; }  // p_c
  // Principal axes of C, and the roots of its eigenvalues, as of the last decomposition.
  const Eigen::MatrixXd& axes() const { return eigen_.vectors(); }
  const Point& lengths() const { return lengths_; }
  double deviation(Eigen::Index i) const { return step_ * std::sqrt(covariance_(i, i)); }

  // A point x = m + sigma B D z (eqs. 38 to 40).
  void sample(Random& random, double* __restrict point) {
    const Eigen::Index n = mean_.size();
    for (Eigen::Index i = 0; i < n; ++i) point[i] = 0;
    for (Eigen::Index k = 0; k < n; ++k) {
      const double along = lengths_(k) * random.normal();
      const double* __restrict const axis = axes().col(k).data();
      for (Eigen::Index i = 0; i < n; ++i) point[i] += axis[i] * along;
    }
    for (Eigen::Index i = 0; i < n; ++i) point[i] = mean_(i) + step_ * point[i];
  }

  // Learns from the points of a generation; `order` has their indices from the best to the worst.
  void learn(const Points& points, const std::vector<Eigen::Index>& order) {
    const CmaConstants& c = constants_;
    const Eigen::Index n = mean_.size();
    steps_.resize(n, c.population);
    Point mean_step = Point::Zero(n);
    for (Eigen::Index k = 0; k < c.population; ++k) {
      const Eigen::Index from = order[static_cast<std::size_t>(k)];
      for (Eigen::Index i = 0; i < n; ++i) steps_(i, k) = (points(i, from) - mean_(i)) / step_;
      if (k >= c.parents) continue;
      for (Eigen::Index i = 0; i < n; ++i) mean_step(i) += c.weights(k) * steps_(i, k);  // eq. 41
    }
    for (Eigen::Index i = 0; i < n; ++i) mean_(i) += step_ * mean_step(i);  // eq. 42
    move_paths(mean_step);
    adapt_covariance();
    const double longer = length_of(path_) / c.expected_length - 1;
    constexpr double most = 1;  // a generation multiplies the step by e at most
    step_ *= math<double>::exponential(std::min(most, c.path_rate / c.damping * longer));  // eq. 44
    decompose_if_due();
  }

 private:
  static double length_of(const Point& vector) {
    double sum = 0;
    for (const double element : vector) sum += element * element;
    return std::sqrt(sum);
  }

  // D^-1 B' y.
  void whiten(const double* y, Point& white) const {
    const Eigen::Index n = mean_.size();
    white.resize(n);
    for (Eigen::Index k = 0; k < n; ++k) {
      double sum = 0;
      for (Eigen::Index i = 0; i < n; ++i) sum += axes()(i, k) * y[i];
      white(k) = sum / lengths_(k);
    }
  }

  void move_paths(const Point& mean_step) {
    const CmaConstants& c = constants_;
    const Eigen::Index n = mean_.size();
    whiten(mean_step.data(), white_);
    const double kept = 1 - c.path_rate;
    const double gain = std::sqrt(c.path_rate * (2 - c.path_rate) * c.effective_parents);
    for (Eigen::Index i = 0; i < n; ++i) path_(i) *= kept;
    for (Eigen::Index k = 0; k < n; ++k) {
      for (Eigen::Index i = 0; i < n; ++i) path_(i) += gain * white_(k) * axes()(i, k);  // eq. 43
    }
    // The path is as if it had no beginning once the power of what is kept has vanished.
    memory_of_start_ *= kept * kept;
    const double usual = (1.4 + 2 / (static_cast<double>(n) + 1)) * c.expected_length;
    stalled_ = length_of(path_) >= usual * std::sqrt(1 - memory_of_start_);  // h_sigma = 0
    const double shape_gain =
        stalled_ ? 0 : std::sqrt(c.shape_rate * (2 - c.shape_rate) * c.effective_parents);
    for (Eigen::Index i = 0; i < n; ++i) {
      shape_path_(i) = (1 - c.shape_rate) * shape_path_(i) + shape_gain * mean_step(i);  // eq. 45
    }
  }

  void adapt_covariance() {
    const CmaConstants& c = constants_;
    const Eigen::Index n = mean_.size();
    const double lost = stalled_ ? c.shape_rate * (2 - c.shape_rate) : 0;  // delta(h_sigma)
    const double kept =
        1 + c.rank_one_rate * lost - c.rank_one_rate - c.rank_mu_rate * c.weight_sum;
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index i = 0; i <= j; ++i) covariance_(i, j) *= kept;
    }
    add_square(c.rank_one_rate, shape_path_.data());
    for (Eigen::Index k = 0; k < c.population; ++k) {
      double weight = c.rank_mu_rate * c.weights(k);
      if (weight < 0) {  // eq. 46
        whiten(steps_.col(k).data(), white_);
        const double length = length_of(white_);
        if (!(length > 0)) continue;
        weight *= static_cast<double>(n) / (length * length);
      }
      add_square(weight, steps_.col(k).data());  // eq. 47
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index i = 0; i < j; ++i) covariance_(j, i) = covariance_(i, j);
    }
  }

  // Adds weight y y' to the upper half of C.
  void add_square(double weight, const double* __restrict y) {
    for (Eigen::Index j = 0; j < mean_.size(); ++j) {
      const double by = weight * y[j];
      double* __restrict const column = covariance_.col(j).data();
      for (Eigen::Index i = 0; i <= j; ++i) column[i] += by * y[i];
    }
  }

  // A decomposition costs as much as many updates, which change C by little.
  void decompose_if_due() {
    const CmaConstants& c = constants_;
    const double change = (c.rank_one_rate + c.rank_mu_rate) * static_cast<double>(mean_.size());
    undecomposed_ += 10 * change;
    if (undecomposed_ < 1) return;
    undecomposed_ = 0;
    eigen_.decompose(covariance_);
    for (Eigen::Index k = 0; k < mean_.size(); ++k) {
      // Rounding may leave a value that is not positive where the greatest is 1e16 times as large.
      lengths_(k) = std::sqrt(std::max(eigen_.values()(k), 1e-300));
    }
  }

  CmaConstants constants_;
  Point mean_;  // m
  double step_;
  Eigen::MatrixXd covariance_;  // C
  Point path_, shape_path_;
  Point lengths_;  // D
  SymmetricEigen eigen_;
  double memory_of_start_ = 1;  // (1 - c_sigma)^(2 (g + 1))
  bool stalled_ = false;
  double undecomposed_ = 0;  // tenths of C that have changed since the last decomposition

  // Of the present generation; members, so that they are allocated once.
  Points steps_;
  Point white_;
};

}  // namespace nfopidn
