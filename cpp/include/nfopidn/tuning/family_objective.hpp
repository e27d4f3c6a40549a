// L4. The cost of candidates over a family of scenarios, whatever is tuned: how the costs of the
// scenarios make one, and how the work is shared out to threads.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/parallel/thread_pool.hpp"
#include "nfopidn/search/objective.hpp"
#include "nfopidn/simulation/simulate.hpp"
#include "nfopidn/tuning/family_cost.hpp"

namespace nfopidn {

// Control periods times substeps of a run.
inline double steps_of(const PreparedRun& run) {
  return static_cast<double>(run.reference.size()) * run.scenario->substeps;
}

class FamilyObjective : public Objective {
 public:
  Eigen::Index partials_at_once() const override {
    return runs_one_by_one() ? pool_.size() : dimension_;
  }
  // So few that a time limit is kept closely, but enough to fill the lanes or the threads.
  Eigen::Index most_at_once() const override;

  void costs(const Points& points, double* costs) override {
    bounded_costs(points, nullptr, costs);
  }
  void bounded_costs(const Points& points, const double* bounds, double* costs) override;

  // The cost and its gradient.
  double gradient(const Point& point, double* slopes) {
    return partials(point, 0, dimension_, slopes);
  }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override;

 protected:
  FamilyObjective(Eigen::Index dimension, FamilyCost family, int threads)
      : dimension_(dimension), family_(std::move(family)), pool_(threads) {}

  virtual Eigen::Index scenario_count() const = 0;
  // Control periods and substeps of a candidate's runs over all scenarios.
  virtual double steps_of_a_candidate() const = 0;
  // Whether each candidate and direction is a run of its own, for want of lanes.
  virtual bool runs_one_by_one() const = 0;

  // What the runs are given of candidates, in lists of the objective's own. A value, and no member,
  // so that several threads may ask one objective.
  using Numbers = std::vector<std::vector<double>>;

  virtual Numbers numbers_of(const Points& points) const = 0;
  // The costs [count] of the candidates first .. first + count - 1, called by any thread. One that
  // costs more than its bound, if there are bounds, may have some cost over it.
  virtual void run(const Numbers& numbers, Eigen::Index scenario, Eigen::Index first,
                   Eigen::Index count, double* costs, const double* bounds) const = 0;

  // The same for a point, and for its coordinates first .. first + count - 1 as directions.
  // differentiate() gives the cost, and its slopes in `count` of the directions.
  virtual Numbers directions_of(const Point& point, Eigen::Index first,
                                Eigen::Index count) const = 0;
  virtual double differentiate(const Numbers& numbers, Eigen::Index scenario, Eigen::Index first,
                               Eigen::Index count, double* slopes) const = 0;

  Eigen::Index dimension() const { return dimension_; }

 private:
  // Calls run(scenario, first, count) until each scenario has all of `size` things, which are
  // shared out in pieces of `together`.
  template <class Run>
  void over_scenarios(std::ptrdiff_t size, std::ptrdiff_t together, const Run& run) {
    const std::ptrdiff_t scenarios = scenario_count();
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
  void share_out_costs(const Numbers& numbers, Eigen::Index count, const double* bounds,
                       Eigen::Index stride, double* costs);

  Eigen::Index dimension_;
  FamilyCost family_;
  ThreadPool pool_;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn {

NFOPIDN_HOST Eigen::Index FamilyObjective::most_at_once() const {
  const double steps = steps_of_a_candidate();
  constexpr double published = 751;
  constexpr Eigen::Index widest_block = 32;  // of lanes
  const bool single = runs_one_by_one();
  const auto affordable =
      static_cast<Eigen::Index>((single ? 64.0 : 4096.0) * published / std::max(steps, 1.0));
  const Eigen::Index fewest = (single ? 1 : widest_block) * pool_.size();
  return std::max({affordable, fewest / scenario_count(), Eigen::Index{1}});
}

NFOPIDN_HOST void FamilyObjective::bounded_costs(const Points& points, const double* bounds,
                                                 double* costs) {
  const StandardArithmetic arithmetic;
  const Numbers numbers = numbers_of(points);
  const Eigen::Index count = points.cols();
  const Eigen::Index scenarios = scenario_count();
  if (scenarios == 1 && family_.caps.empty()) {
    share_out_costs(numbers, count, bounds, 0, costs);
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
  share_out_costs(numbers, count, bounds != nullptr ? each_bound.data() : nullptr,
                  each_bound.cols() > 1 ? count : 0, each.data());
  for (Eigen::Index j = 0; j < count; ++j) {
    Eigen::VectorXd row = each.row(j);
    family_.see(row);
    costs[j] = dot(row, worst_share_weights(row, family_.share));
  }
}

NFOPIDN_HOST double FamilyObjective::partials(const Point& point, Eigen::Index first,
                                              Eigen::Index count, double* slopes) {
  const StandardArithmetic arithmetic;
  const Numbers numbers = directions_of(point, first, count);
  const Eigen::Index scenarios = scenario_count();
  Eigen::VectorXd each(scenarios);
  Eigen::MatrixXd each_slopes(count, scenarios);
  constexpr int together = 16;  // directions that take hardly longer than half of them
  over_scenarios(count, together, [&](auto scenario, auto from, auto there) {
    const double cost =
        differentiate(numbers, scenario, from, there, each_slopes.col(scenario).data() + from);
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

NFOPIDN_HOST void FamilyObjective::share_out_costs(const Numbers& numbers, Eigen::Index count,
                                                   const double* bounds, Eigen::Index stride,
                                                   double* costs) {
  constexpr int together = 8;  // candidates, with the widest instructions
  over_scenarios(count, together, [&](auto scenario, auto first, auto there) {
    run(numbers, scenario, first, there, costs + scenario * count + first,
        bounds == nullptr ? nullptr : bounds + scenario * stride + first);
  });
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
