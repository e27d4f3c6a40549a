// L4. Tuning: the cost of a controller's parameters as an objective for the searches.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/math/ordered_sums.hpp"
#include "nfopidn/parallel/thread_pool.hpp"
#include "nfopidn/search/method.hpp"
#include "nfopidn/tuning/batch.hpp"
#include "nfopidn/tuning/family_cost.hpp"
#include "nfopidn/tuning/structures.hpp"

namespace nfopidn {

// How finely a search looks at small parameters: see Box::power. Good gains and orders lie near the
// lower end of generous bounds.
NFOPIDN_HOST Point tuning_powers(const Point& low);
// The same for the free parameters of a structure, of which some have a power of their own.
NFOPIDN_HOST Point tuning_powers(const Structure& structure, const FreeParameters& parameters,
                                 const Point& low);

// Cost of a controller over scenarios, of which FamilyCost makes one.
class TuneObjective : public Objective {
 public:
  // The scenarios must outlive this.
  TuneObjective(const std::vector<const Scenario*>& scenarios, const Structure& structure,
                FreeParameters parameters, int dimension, FamilyCost family, int threads);

  bool has_gradient() const override { return true; }
  bool is_cheap() const override { return true; }
  // A moment's worth, so that a time limit is kept and little is lost to it; but enough for the
  // lanes, or for the threads.
  Eigen::Index most_at_once() const override;
  Eigen::Index partials_at_once() const override;

  void costs(const Points& points, double* costs) override;
  void bounded_costs(const Points& points, const double* bounds, double* costs) override;

  // The cost and its gradient.
  double gradient(const Point& point, double* slopes);
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override;

 private:
  // Whether a memory beyond that of the lanes makes each candidate and direction a run of its own.
  bool runs_one_by_one() const { return structure_.settings.memory + 2 > batch_capacity; }

  // The numbers of the law at a point, and how they change with its coordinates first .. first +
  // count - 1.
  void differentiate_law(const Point& point, Eigen::Index first, Eigen::Index count,
                         std::vector<double>& law, std::vector<double>& directions) const;

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
                       Eigen::Index stride, double* costs);

  std::vector<double> laws_of(const Points& points) const;

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

// A tuning for programs; all of its parameters are free within their default bounds.
struct TuningTask {
  std::vector<const Scenario*> scenarios;
  Structure structure;
  std::vector<double> start;  // parameters known to be good; may be empty
  std::int64_t evaluations = 10000;
  std::uint64_t seed = 0;
  double share = 1;
  int threads = 1;
  std::function<bool()> interrupted;  // asked now and then; true ends the search
  MethodOptions method = {};          // bfoa+ with its default options
};

// The share of a search for free taps that looks for gains and orders to start from.
constexpr double start_share = 0.3;

// x is empty where the search was interrupted before it knew a first cost.
struct TuningResult : SearchResult {
  Structure structure;  // what x stands for: the task's, with the lateral channel chosen
};

namespace detail {

inline SearchResult run_stage(const TuningTask& task, const SearchSession::Callback& callback) {
  const std::vector<ParameterBounds> bounds = default_bounds(task.structure);
  const auto size = static_cast<Eigen::Index>(bounds.size());
  Point low(size), high(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    low(i) = bounds[static_cast<std::size_t>(i)].low;
    high(i) = bounds[static_cast<std::size_t>(i)].high;
  }
  TuneObjective objective(task.scenarios, task.structure, FreeParameters::all(bounds.size()),
                          static_cast<int>(size), task.share, task.threads);
  const Point power = tuning_powers(task.structure, FreeParameters::all(bounds.size()), low);
  SearchSession search(objective, {low, high, power}, {task.evaluations}, task.seed);
  if (!task.start.empty()) search.start = Eigen::Map<const Point>(task.start.data(), size);
  search.keeps_record = false;
  search.set_callback(callback);
  search.set_interruption(task.interrupted);
  run_method(search, task.method);
  return search.result;
}

// Gains and orders for free taps to start from: a task of its own, by the default method whatever
// the task's is, and its answer as taps.
inline SearchResult find_start(TuningTask task, const SearchSession::Callback& callback) {
  const ParameterSet wanted = task.structure.parameters;
  task.structure.parameters = ParameterSet::orders_by_channel;
  if (task.evaluations >= unlimited_budget) task.evaluations = default_budget({});
  task.method = {};
  task.evaluations = std::max<std::int64_t>(
      1, static_cast<std::int64_t>(start_share * static_cast<double>(task.evaluations)));
  SearchResult found = run_stage(task, callback);
  if (found.x.size() == 0) return found;
  std::vector<double> taps = parameters_of(
      wanted, design_of(task.structure, std::vector<double>(found.x.begin(), found.x.end())));
  task.structure.parameters = wanted;
  // Within what free taps are searched for: gains and orders may make larger ones.
  const std::vector<ParameterBounds> bounds = default_bounds(task.structure);
  for (std::size_t i = 0; i < taps.size(); ++i) {
    taps[i] = std::min(bounds[i].high, std::max(bounds[i].low, taps[i]));
  }
  const int size = static_cast<int>(taps.size());
  TuneObjective objective(task.scenarios, task.structure, FreeParameters::all(taps.size()), size,
                          task.share, task.threads);
  found.x = Eigen::Map<const Point>(taps.data(), size);
  objective.costs(found.x, &found.cost);
  found.population = found.x;
  found.population_costs = Eigen::VectorXd::Constant(1, found.cost);
  return found;
}

}  // namespace detail

// Called after each chemotactic step with the evaluations and the least cost of all stages so far.
using TuningCallback = std::function<void(std::int64_t evaluations, double cost)>;

NFOPIDN_HOST TuningResult run_tuning(TuningTask task, const TuningCallback& callback = {});

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn {

NFOPIDN_HOST Point tuning_powers(const Point& low) {
  return (low.array() >= 0).select(Point::Constant(low.size(), 2), Point::Ones(low.size()));
}

NFOPIDN_HOST Point tuning_powers(const Structure& structure, const FreeParameters& parameters,
                                 const Point& low) {
  Point power = tuning_powers(low);
  const std::vector<ParameterBounds> bounds = default_bounds(structure);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const double own = bounds[i].power;
    if (own < 0 || parameters.source[i] < 0) continue;
    const Eigen::Index place = parameters.source[i];
    if (own != Box::logarithmic || low(place) > 0) power(place) = own;
  }
  return power;
}

NFOPIDN_HOST TuneObjective::TuneObjective(const std::vector<const Scenario*>& scenarios,
                                          const Structure& structure, FreeParameters parameters,
                                          int dimension, FamilyCost family, int threads)
    : structure_(structure),
      parameters_(std::move(parameters)),
      dimension_(dimension),
      family_(std::move(family)),
      pool_(threads) {
  for (const Scenario* scenario : scenarios) {
    evaluators_.emplace_back(prepare(*scenario), structure.settings);
  }
}

NFOPIDN_HOST Eigen::Index TuneObjective::most_at_once() const {
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

NFOPIDN_HOST Eigen::Index TuneObjective::partials_at_once() const {
  return runs_one_by_one() ? pool_.size() : dimension_;
}

NFOPIDN_HOST void TuneObjective::costs(const Points& points, double* costs) {
  bounded_costs(points, nullptr, costs);
}

NFOPIDN_HOST void TuneObjective::bounded_costs(const Points& points, const double* bounds,
                                               double* costs) {
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

NFOPIDN_HOST double TuneObjective::gradient(const Point& point, double* slopes) {
  return partials(point, 0, dimension_, slopes);
}

NFOPIDN_HOST double TuneObjective::partials(const Point& point, Eigen::Index first,
                                            Eigen::Index count, double* slopes) {
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

NFOPIDN_HOST void TuneObjective::differentiate_law(const Point& point, Eigen::Index first,
                                                   Eigen::Index count, std::vector<double>& law,
                                                   std::vector<double>& directions) const {
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

NFOPIDN_HOST void TuneObjective::share_out_costs(const std::vector<double>& laws,
                                                 Eigen::Index count, const double* bounds,
                                                 Eigen::Index stride, double* costs) {
  constexpr int together = 8;  // candidates, with the widest instructions
  over_scenarios(count, together, [&](auto scenario, auto first, auto there) {
    evaluators_[static_cast<std::size_t>(scenario)].costs_of_laws(
        laws.data() + static_cast<std::size_t>(first) * law_size(), static_cast<int>(there),
        costs + scenario * count + first,
        bounds == nullptr ? nullptr : bounds + scenario * stride + first);
  });
}

NFOPIDN_HOST std::vector<double> TuneObjective::laws_of(const Points& points) const {
  const std::size_t size = law_size();
  std::vector<double> laws(static_cast<std::size_t>(points.cols()) * size);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    parameters_to_law(structure_, parameters_.full(points.col(j).data()),
                      laws.data() + static_cast<std::size_t>(j) * size);
  }
  return laws;
}

NFOPIDN_HOST TuningResult run_tuning(TuningTask task, const TuningCallback& callback) {
  const StandardArithmetic arithmetic;
  TuningResult best;
  best.structure = task.structure;
  std::int64_t spent = 0;
  const auto report = [&](const SearchResult& stage) {
    if (callback) callback(spent + stage.evaluations, std::min(best.cost, stage.cost));
    return true;
  };
  const auto keep = [&](const SearchResult& found, const Structure& structure) {
    spent += found.evaluations;
    task.evaluations -= found.evaluations;
    if (found.cost < best.cost || best.x.size() == 0) {
      static_cast<SearchResult&>(best) = found;
      best.structure = structure;
    }
    best.reason = found.reason;  // the last stage's
  };
  const auto goes_on = [&] {
    return best.reason == StopReason::schedule || best.reason == StopReason::evaluations;
  };
  if (task.structure.parameters == ParameterSet::taps && task.start.empty()) {
    keep(detail::find_start(task, report), task.structure);
    task.start.assign(best.x.begin(), best.x.end());
  }
  if (!task.structure.either_lateral) {
    if (goes_on()) keep(detail::run_stage(task, report), task.structure);
  } else {
    for (const Lateral lateral : free_tap_laterals) {
      TuningTask one = task;
      one.structure.settings.lateral = lateral;
      if (lateral == free_tap_laterals[0]) one.evaluations -= task.evaluations / 2;
      if (one.evaluations > 0 && goes_on()) keep(detail::run_stage(one, report), one.structure);
    }
  }
  best.evaluations = spent;
  return best;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
