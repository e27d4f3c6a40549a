// L4. The cost of a controller's parameters as an objective for the searches.
#pragma once

#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/parallel/thread_pool.hpp"
#include "nfopidn/search/objective.hpp"
#include "nfopidn/tuning/batch.hpp"
#include "nfopidn/tuning/family_cost.hpp"
#include "nfopidn/tuning/parameter_space.hpp"

namespace nfopidn {

// Cost of a controller over scenarios, of which FamilyCost makes one.
class TuneObjective : public Objective {
 public:
  // The scenarios must outlive this.
  TuneObjective(const std::vector<const Scenario*>& scenarios, const ParameterSpace& space,
                FamilyCost family, int threads)
      : structure_(space.structure),
        parameters_(space.parameters),
        dimension_(static_cast<int>(space.dimension())),
        family_(std::move(family)),
        pool_(threads) {
    for (const Scenario* scenario : scenarios) {
      evaluators_.emplace_back(prepare(*scenario), structure_.settings);
    }
  }

  bool has_gradient() const override { return true; }
  bool is_cheap() const override { return true; }
  // A moment's worth, so that a time limit is kept and little is lost to it; but enough for the
  // lanes, or for the threads.
  Eigen::Index most_at_once() const override {
    double steps = 0;  // of a candidate
    for (const BatchEvaluator& one : evaluators_) {
      const PreparedRun& run = one.run();
      steps += static_cast<double>(run.reference.size()) * run.scenario->substeps;
    }
    constexpr double published = 751;
    constexpr Eigen::Index widest_block = 32;  // of lanes
    const auto scenarios = static_cast<Eigen::Index>(evaluators_.size());
    const bool single = runs_one_by_one();
    const auto affordable =
        static_cast<Eigen::Index>((single ? 64.0 : 4096.0) * published / std::max(steps, 1.0));
    const Eigen::Index fewest = (single ? 1 : widest_block) * pool_.size();
    return std::max({affordable, fewest / scenarios, Eigen::Index{1}});
  }
  Eigen::Index partials_at_once() const override {
    return runs_one_by_one() ? pool_.size() : dimension_;
  }

  void costs(const Points& points, double* costs) override {
    bounded_costs(points, nullptr, costs);
  }
  void bounded_costs(const Points& points, const double* bounds, double* costs) override {
    const StandardArithmetic arithmetic;
    const std::vector<double> laws = laws_of(points);
    const Eigen::Index count = points.cols();
    const auto scenarios = static_cast<Eigen::Index>(evaluators_.size());
    if (scenarios == 1 && family_.caps.empty()) {
      share_out_costs(laws, count, bounds, 0, costs);
      return;
    }
    Eigen::MatrixXd each_bound;
    if (bounds != nullptr) {
      const Eigen::VectorXd most =
          Eigen::Map<const Eigen::VectorXd>(bounds, count) * family_.worst(scenarios);
      if (family_.caps.empty()) {
        each_bound = most;  // one column for all scenarios
      } else {
        each_bound.resize(count, scenarios);
        for (Eigen::Index i = 0; i < scenarios; ++i) {
          for (Eigen::Index j = 0; j < count; ++j) {
            each_bound(j, i) = family_.cap(i).unseen(most(j));
          }
        }
      }
    }
    Eigen::MatrixXd each(count, scenarios);
    share_out_costs(laws, count, bounds != nullptr ? each_bound.data() : nullptr,
                    each_bound.cols() > 1 ? count : 0, each.data());
    for (Eigen::Index j = 0; j < count; ++j) {
      Eigen::VectorXd row = each.row(j);
      family_.see(row);
      costs[j] = dot(row, worst_share_weights(row, family_.share));
    }
  }

  // The cost and its gradient.
  double gradient(const Point& point, double* slopes) {
    return partials(point, 0, dimension_, slopes);
  }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    const StandardArithmetic arithmetic;
    const std::size_t size = law_size();
    std::vector<double> law(size), directions(size * static_cast<std::size_t>(count));
    differentiate_law(point, first, count, law, directions);
    const auto scenarios = static_cast<Eigen::Index>(evaluators_.size());
    Eigen::VectorXd each(scenarios);
    Eigen::MatrixXd each_slopes(count, scenarios);
    constexpr int together = 16;  // directions that take hardly longer than half of them
    over_scenarios(count, together, [&](auto scenario, auto from, auto there) {
      const double cost = evaluators_[static_cast<std::size_t>(scenario)].gradient(
          law.data(), directions.data() + static_cast<std::size_t>(from) * size,
          static_cast<int>(there), each_slopes.col(scenario).data() + from);
      if (from == 0) each(scenario) = cost;
    });
    if (!family_.caps.empty()) {
      for (Eigen::Index i = 0; i < scenarios; ++i) {
        each_slopes.col(i) *= family_.cap(i).slope(each(i));
      }
      family_.see(each);
    }
    const Eigen::VectorXd weight = worst_share_weights(each, family_.share);
    Eigen::Map<Eigen::VectorXd>(slopes, count) = product(each_slopes, weight);
    return dot(each, weight);
  }

 private:
  // Whether a memory beyond that of the lanes makes each candidate and direction a run of its own.
  bool runs_one_by_one() const { return structure_.settings.memory + 2 > batch_capacity; }

  // The numbers of the law at a point, and how they change with its coordinates first .. first +
  // count - 1.
  void differentiate_law(const Point& point, Eigen::Index first, Eigen::Index count,
                         std::vector<double>& law, std::vector<double>& directions) const {
    const std::size_t size = law_size();
    std::vector<Dual<double>> x(static_cast<std::size_t>(dimension_)), fused(size);
    double* slope = directions.data();
    for (Eigen::Index i = first; i < first + count; ++i) {
      for (Eigen::Index k = 0; k < dimension_; ++k) {
        x[static_cast<std::size_t>(k)] = {point(k), k == i ? 1.0 : 0.0};
      }
      parameters_to_law(structure_, parameters_.full(x.data()), fused.data());
      for (std::size_t n = 0; n < size; ++n) {
        law[n] = fused[n].value;
        *slope++ = fused[n].slope;
      }
    }
  }

  // Calls run(scenario, first, count) until each scenario has all of `size` things, which are
  // shared out in pieces of `together`.
  template <class Run>
  void over_scenarios(std::ptrdiff_t size, std::ptrdiff_t together, const Run& run) {
    const auto scenarios = static_cast<std::ptrdiff_t>(evaluators_.size());
    pool_.for_each_share(scenarios * size, together,
                         [&](std::ptrdiff_t first, std::ptrdiff_t count) {
                           while (count > 0) {
                             const std::ptrdiff_t from = first % size;
                             const std::ptrdiff_t there = std::min(count, size - from);
                             run(first / size, from, there);
                             first += there;
                             count -= there;
                           }
                         });
  }

  // costs: [scenarios][count], bounds: [count], those of the next scenario `stride` further.
  void share_out_costs(const std::vector<double>& laws, Eigen::Index count, const double* bounds,
                       Eigen::Index stride, double* costs) {
    constexpr int together = 8;  // candidates, with the widest instructions
    over_scenarios(count, together, [&](auto scenario, auto first, auto there) {
      evaluators_[static_cast<std::size_t>(scenario)].costs_of_laws(
          laws.data() + static_cast<std::size_t>(first) * law_size(), static_cast<int>(there),
          costs + scenario * count + first,
          bounds == nullptr ? nullptr : bounds + scenario * stride + first);
    });
  }

  std::vector<double> laws_of(const Points& points) const {
    const std::size_t size = law_size();
    std::vector<double> laws(static_cast<std::size_t>(points.cols()) * size);
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      parameters_to_law(structure_, parameters_.full(points.col(j).data()),
                        laws.data() + static_cast<std::size_t>(j) * size);
    }
    return laws;
  }

  std::size_t law_size() const {
    return static_cast<std::size_t>(
        nfopidn::law_size(structure_.settings, structure_.settings.memory + 2));
  }

  std::vector<BatchEvaluator> evaluators_;
  Structure structure_;
  FreeParameters parameters_;
  int dimension_;
  FamilyCost family_;
  ThreadPool pool_;
};

}  // namespace nfopidn
