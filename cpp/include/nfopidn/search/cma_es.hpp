// L3. Evolution strategy with covariance matrix adaptation: CMA-ES with negative weights, restarted
// with larger populations for as long as the budget lasts (A. Auger and N. Hansen, A Restart CMA
// Evolution Strategy With Increasing Population Size, 2005).
//
// A generation's points are drawn from a normal distribution, which learns from their ranks where
// the good ones lie and along which axes: see covariance_adaptation.hpp. The distribution knows no
// bounds. A point outside the box is evaluated at its mirror image inside, as if the cost were
// mirrored at each bound, and the distribution learns from the point as it was drawn.
#pragma once

#include "nfopidn/search/cma_es_options.hpp"
#include "nfopidn/search/covariance_adaptation.hpp"
#include "nfopidn/search/session.hpp"

namespace nfopidn {

class CmaEs {
 public:
  using Options = CmaEsOptions;
  static constexpr const char* name = "cma";
  static constexpr std::int64_t default_budget = 10000;

  CmaEs(SearchSession& search, const CmaEsOptions& options) : search_(search), options_(options) {}

  void run() {
    const Eigen::Index n = search_.dimension();
    for (restart_ = 0; !search_.done(); ++restart_) {
      const bool starts = restart_ == 0 && search_.start.size() != 0;
      const Point mean =
          starts ? search_.box().to_unit(search_.start) : random_point(search_.random, n);
      run_once(CmaConstants(n, population_of_run()), mean,
               starts ? options_.start_step : options_.step);
    }
  }

  // The point of the unit box that a point anywhere is evaluated at.
  static double mirrored(double u) {
    u = std::fabs(u);
    u -= 2 * std::floor(u / 2);
    return u > 1 ? 2 - u : u;
  }

 private:
  Eigen::Index population_of_run() {
    constexpr double most = 1e6;
    const auto n = static_cast<double>(search_.dimension());
    if (restart_ == 0) {
      population_ = options_.population > 0 ? options_.population
                                            : 4 + std::floor(3 * math<double>::log(n));  // eq. 48
      return static_cast<Eigen::Index>(population_);
    }
    population_ = std::min(most, population_ * options_.growth);
    return static_cast<Eigen::Index>(population_);
  }

  void run_once(const CmaConstants& constants, const Point& mean, double step) {
    AdaptedNormal normal(constants, mean, step);
    best_costs_.clear();
    median_costs_.clear();
    for (int generation = 0; !search_.done(); ++generation) {
      if (!evaluate_generation(normal, constants.population, generation)) return;
      normal.learn(drawn_, order_);
      if (is_over(normal, constants.population)) return;
    }
  }

  // Draws and evaluates a generation and ranks it; false if the search ends within it.
  bool evaluate_generation(AdaptedNormal& normal, Eigen::Index population, int generation) {
    const Eigen::Index n = search_.dimension();
    drawn_.resize(n, population);
    places_.resize(n, population);
    for (Eigen::Index k = 0; k < population; ++k) {
      normal.sample(search_.random, drawn_.col(k).data());
      for (Eigen::Index i = 0; i < n; ++i) places_(i, k) = mirrored(drawn_(i, k));
    }
    // What is known to be good is tried itself, so that the result is no worse.
    if (restart_ == 0 && generation == 0 && search_.start.size() != 0) {
      drawn_.col(0) = places_.col(0) = normal.mean();
    }
    const std::int64_t before = search_.result.evaluations;
    search_.evaluate(places_, costs_);
    search_.spend();
    note(normal, search_.result.evaluations - before, generation);
    if (search_.done()) return false;
    order_ = ranking(costs_);
    best_costs_.push_back(costs_(order_.front()));
    median_costs_.push_back(costs_(order_[order_.size() / 2]));
    return true;
  }

  // A row of the history a generation, the last one with the points that were evaluated.
  void note(const AdaptedNormal& normal, std::int64_t evaluated, int generation) {
    if (evaluated == 0 || search_.result.reason == StopReason::not_a_number) return;
    double squares = 0;
    for (Eigen::Index i = 0; i < search_.dimension(); ++i) {
      squares += normal.deviation(i) * normal.deviation(i);
    }
    const double step = std::sqrt(squares / static_cast<double>(search_.dimension()));
    search_.note(restart_, 0, generation, places_.leftCols(evaluated), costs_.head(evaluated),
                 step);
  }

  // Whether the run has nothing more to find (appendix B.3 of the tutorial).
  bool is_over(const AdaptedNormal& normal, Eigen::Index population) const {
    constexpr double finest = 1e-12, widest = 1e4;  // in units of the box
    constexpr double greatest_ratio = 1e7;          // of the axes, whose squares are in C
    double width = 0;
    for (Eigen::Index i = 0; i < search_.dimension(); ++i) {
      width = std::max(width, normal.deviation(i));
    }
    const Point& lengths = normal.lengths();
    return !(width >= finest && width <= widest) ||
           !(lengths.maxCoeff() <= greatest_ratio * lengths.minCoeff()) ||
           has_converged(population) || stagnates(population);
  }

  // Generations over which the best cost must change: 30 n / lambda, and `least`.
  std::size_t period(Eigen::Index population, std::size_t least) const {
    const Eigen::Index share = (30 * search_.dimension() + population - 1) / population;
    return least + static_cast<std::size_t>(share);
  }

  // Whether the costs of this generation and the best ones of the last period are nearly the same.
  bool has_converged(Eigen::Index population) const {
    const std::size_t count = period(population, 10);
    if (best_costs_.size() < count) return false;
    const auto [least, most] =
        std::minmax_element(best_costs_.end() - as_steps(count), best_costs_.end());
    const double worst = std::max(*most, costs_(order_.back()));
    return !(worst - *least > options_.tolerance * std::fabs(*least));
  }

  // Whether neither the best nor the median costs get better over the last fifth of the run.
  bool stagnates(Eigen::Index population) const {
    constexpr std::size_t most = 20000;
    const std::size_t size = best_costs_.size();
    const std::size_t count = std::max(period(population, 120), std::min(most, size / 5));
    return size >= count && !improves(best_costs_, count) && !improves(median_costs_, count);
  }

  // Whether of the last `count` costs the median of the last three tenths is under that of the
  // first three.
  static bool improves(const std::vector<double>& costs, std::size_t count) {
    const std::size_t part = 3 * count / 10;
    const auto median = [part](std::vector<double>::const_iterator first) {
      std::vector<double> some(first, first + as_steps(part));
      std::nth_element(some.begin(), some.begin() + as_steps(part / 2), some.end());
      return some[part / 2];
    };
    return median(costs.end() - as_steps(part)) < median(costs.end() - as_steps(count));
  }

  static std::ptrdiff_t as_steps(std::size_t count) { return static_cast<std::ptrdiff_t>(count); }

  SearchSession& search_;
  CmaEsOptions options_;
  int restart_ = 0;
  double population_ = 0;  // lambda of the present run

  // Of the present run, a number a generation.
  std::vector<double> best_costs_, median_costs_;

  // Of the present generation.
  Points drawn_, places_;
  Eigen::VectorXd costs_;
  std::vector<Eigen::Index> order_;  // from best to worst
};

}  // namespace nfopidn
