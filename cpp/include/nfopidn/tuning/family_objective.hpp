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
  // Calls run(scenario, first, count) until each of the first scenarios has all of `size` things,
  // which are shared out in pieces of `together`.
  template <class Run>
  void over_scenarios(std::ptrdiff_t scenarios, std::ptrdiff_t size, std::ptrdiff_t together,
                      const Run& run) {
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

  // A few scenarios at a time, and only for candidates that may still keep their bounds. The rounds
  // depend on costs alone, so that no number of threads changes a bit.
  void costs_in_rounds(const Numbers& numbers, Eigen::Index count, const double* bounds,
                       double* costs);
  static Numbers of_candidates(const Numbers& numbers, const std::vector<Eigen::Index>& chosen,
                               Eigen::Index count);

  static constexpr int candidates_together = 8;  // with the widest instructions

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
  if (bounds != nullptr && (scenarios > 1 || !family_.caps.empty())) {
    costs_in_rounds(numbers, count, bounds, costs);
    return;
  }
  Eigen::MatrixXd each(count, scenarios);
  over_scenarios(scenarios, count, candidates_together, [&](auto scenario, auto first, auto there) {
    run(numbers, scenario, first, there, each.col(scenario).data() + first,
        bounds == nullptr ? nullptr : bounds + first);
  });
  for (Eigen::Index j = 0; j < count; ++j) {
    Eigen::VectorXd row = each.row(j);
    family_.see(row);
    costs[j] = scenarios == 1 && family_.caps.empty() ? row(0) : family_.of_seen(row);
  }
}

// From the last scenario to the first: families list what is hardest, the corners, last, and that
// is where most candidates fail.
NFOPIDN_HOST void FamilyObjective::costs_in_rounds(const Numbers& numbers, Eigen::Index count,
                                                   const double* bounds, double* costs) {
  constexpr Eigen::Index runs_a_round = 32;  // fill the lanes, or several threads
  Eigen::MatrixXd seen = Eigen::MatrixXd::Zero(scenario_count(), count);
  std::vector<Eigen::Index> left(static_cast<std::size_t>(count));
  for (Eigen::Index j = 0; j < count; ++j) left[static_cast<std::size_t>(j)] = j;
  for (Eigen::Index before = scenario_count(); before > 0 && !left.empty();) {
    const auto size = static_cast<Eigen::Index>(left.size());
    const Eigen::Index together = std::min(before, std::max<Eigen::Index>(1, runs_a_round / size));
    before -= together;
    const Numbers own = of_candidates(numbers, left, count);
    Eigen::MatrixXd most(size, together), found(size, together);
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index j = left[static_cast<std::size_t>(i)];
      for (Eigen::Index s = 0; s < together; ++s) {
        most(i, s) = family_.most_of_next(seen.col(j), bounds[j], before + s);
      }
    }
    over_scenarios(together, size, candidates_together, [&](auto s, auto first, auto there) {
      run(own, before + s, first, there, found.col(s).data() + first, most.col(s).data() + first);
    });
    std::size_t kept = 0;
    for (Eigen::Index i = 0; i < size; ++i) {
      const Eigen::Index j = left[static_cast<std::size_t>(i)];
      for (Eigen::Index s = 0; s < together; ++s) {
        seen(before + s, j) = family_.cap(before + s).seen(found(i, s));
      }
      if (!family_.is_surely_over(seen.col(j), bounds[j])) left[kept++] = j;
    }
    left.resize(kept);
  }
  for (Eigen::Index j = 0; j < count; ++j) costs[j] = family_.of_seen(seen.col(j));
}

// Each list has the same number of numbers a candidate.
NFOPIDN_HOST FamilyObjective::Numbers FamilyObjective::of_candidates(
    const Numbers& numbers, const std::vector<Eigen::Index>& chosen, Eigen::Index count) {
  if (static_cast<Eigen::Index>(chosen.size()) == count) return numbers;
  Numbers some;
  for (const std::vector<double>& list : numbers) {
    const auto width = static_cast<std::ptrdiff_t>(list.size()) / count;
    some.emplace_back();
    for (const Eigen::Index j : chosen) {
      some.back().insert(some.back().end(), list.begin() + j * width,
                         list.begin() + (j + 1) * width);
    }
  }
  return some;
}

NFOPIDN_HOST double FamilyObjective::partials(const Point& point, Eigen::Index first,
                                              Eigen::Index count, double* slopes) {
  const StandardArithmetic arithmetic;
  const Numbers numbers = directions_of(point, first, count);
  const Eigen::Index scenarios = scenario_count();
  Eigen::VectorXd each(scenarios);
  Eigen::MatrixXd each_slopes(count, scenarios);
  constexpr int together = 16;  // directions that take hardly longer than half of them
  over_scenarios(scenarios, count, together, [&](auto scenario, auto from, auto there) {
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

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
