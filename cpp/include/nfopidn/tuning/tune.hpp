// L4. Tuning of a controller: the stages of a search, and how they share its budget.
//
// A search for free taps is hard to start: without a start it looks for gains and orders first, and
// goes on from their taps. Where it may also choose what the lateral channel is fed, each choice is
// a stage with its share of the budget. Every other search is one stage.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/search/search_settings.hpp"
#include "nfopidn/tuning/tune_objective.hpp"

namespace nfopidn {

// The share of evaluations and time of a search for free taps that looks for a start.
constexpr double start_share = 0.3;

// The part of a plan that searches one space.
struct PlannedStage {
  std::string name;  // distinguishes its files from those of the other stages
  ParameterSpace space;
};

struct TuningPlan {
  std::vector<const Scenario*> scenarios;  // must outlive the search
  FamilyCost family = 1;
  SearchSettings search;
  int threads = 1;
  Point start;                             // known to be good, for all alternatives; may be empty
  std::optional<PlannedStage> gains;       // gains and orders, whose taps are a start for free taps
  std::vector<PlannedStage> alternatives;  // at least one; the best of their results is the answer
};

// The structures that a search is for, by the names of their stages. The last alternative has the
// empty name: its checkpoint has no suffix. `has_start`: whether there is a point to start from.
using NamedStructure = std::pair<std::string, Structure>;
struct StructureStages {
  std::optional<NamedStructure> gains;
  std::vector<NamedStructure> alternatives;
};
NFOPIDN_HOST StructureStages stages_of(const Structure& structure, bool has_start);

// A plan whose parameters are all free within their default bounds. An empty start is none.
NFOPIDN_HOST TuningPlan plan_tuning(std::vector<const Scenario*> scenarios,
                                    const Structure& structure,
                                    const std::vector<double>& start = {});

// A stage with its share of the search, as it is about to run.
struct SearchStage {
  const PlannedStage& planned;
  SearchSettings search;
  Point start;         // may be empty
  std::int64_t spent;  // evaluations of the stages before
  double best;         // the least cost of the stages before
};

// Runs the stages of a plan. Files, callbacks and requests to stop are its concern.
class StageRunner {
 public:
  virtual ~StageRunner() = default;
  // Whether an earlier process has come to this stage. What comes before it has then ended, and
  // must not go on for longer than it did.
  virtual bool has_begun(const PlannedStage& /*stage*/) const { return false; }
  virtual SearchResult run(const SearchStage& stage, Objective& objective) = 0;
  // Whether no further stage is to run, for a reason that no result tells.
  virtual bool has_failed() const { return false; }
};

// x is empty where the search was interrupted before it knew a first cost. Evaluations, time and
// history are those of all stages; the reason is that of the last one.
struct TuningResult : SearchResult {
  std::size_t alternative = 0;  // whose point x is
  Structure structure;          // what x stands for
};

NFOPIDN_HOST TuningResult run_tuning(const TuningPlan& plan, StageRunner& runner);

// Called after each chemotactic step with the evaluations and the least cost of all stages so far.
using TuningCallback = std::function<void(std::int64_t evaluations, double cost)>;

// Runs stages without files.
class PlainStageRunner : public StageRunner {
 public:
  // `interrupted` is asked now and then; true ends the search. Either may be empty.
  explicit PlainStageRunner(TuningCallback callback, std::function<bool()> interrupted = {})
      : callback_(std::move(callback)), interrupted_(std::move(interrupted)) {}

  SearchResult run(const SearchStage& stage, Objective& objective) override;

 private:
  TuningCallback callback_;
  std::function<bool()> interrupted_;
};

inline TuningResult run_tuning(const TuningPlan& plan, const TuningCallback& callback = {},
                               std::function<bool()> interrupted = {}) {
  PlainStageRunner runner(callback, std::move(interrupted));
  return run_tuning(plan, runner);
}

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn {

NFOPIDN_HOST StructureStages stages_of(const Structure& structure, bool has_start) {
  StructureStages stages;
  if (structure.parameters == ParameterSet::taps && !has_start) {
    Structure gains = structure;
    gains.parameters = ParameterSet::orders_by_channel;
    gains.either_lateral = false;
    stages.gains = NamedStructure("gains", gains);
  }
  if (!structure.either_lateral) {
    stages.alternatives.emplace_back("", structure);
    return stages;
  }
  for (const Lateral lateral : free_tap_laterals) {
    Structure one = structure;
    one.either_lateral = false;
    one.settings.lateral = lateral;
    const std::string name = ChoiceNames<Lateral>::names[static_cast<std::size_t>(lateral)];
    const bool is_last = lateral == *(std::end(free_tap_laterals) - 1);
    stages.alternatives.emplace_back(is_last ? "" : name, one);
  }
  return stages;
}

NFOPIDN_HOST TuningPlan plan_tuning(std::vector<const Scenario*> scenarios,
                                    const Structure& structure, const std::vector<double>& start) {
  TuningPlan plan;
  plan.scenarios = std::move(scenarios);
  plan.start = Eigen::Map<const Point>(start.data(), static_cast<Eigen::Index>(start.size()));
  const StructureStages stages = stages_of(structure, !start.empty());
  if (stages.gains) {
    plan.gains = PlannedStage{stages.gains->first, ParameterSpace::whole(stages.gains->second)};
  }
  for (const auto& [name, own] : stages.alternatives) {
    plan.alternatives.push_back({name, ParameterSpace::whole(own)});
  }
  return plan;
}

namespace detail {

class TuningRun {
 public:
  TuningRun(const TuningPlan& plan, StageRunner& runner) : plan_(plan), runner_(runner) {}

  TuningResult run() {
    Point start = plan_.start;
    std::int64_t rest = plan_.search.limits.evaluations;
    if (plan_.gains) {
      const std::int64_t share = share_for_gains();
      const SearchResult found = find_start(share);
      add(found, 0);
      start = found.x;
      // What a stage could not use because its time was up is not for the others: a search that
      // goes on from its checkpoints has the same stages.
      if (rest < unlimited_budget) {
        rest -= found.reason == StopReason::time ? share : found.evaluations;
      }
      if (start.size() == 0) return std::move(result_);
    }
    const std::size_t count = plan_.alternatives.size();
    for (std::size_t place = 0; place < count && goes_on(); ++place) {
      const auto remaining = static_cast<std::int64_t>(count - place);
      SearchSettings search = plan_.search;
      if (rest < unlimited_budget) {
        search.limits.evaluations = (rest + remaining - 1) / remaining;
        rest -= search.limits.evaluations;
      }
      if (search.limits.evaluations < 1) break;
      search.limits.seconds = seconds_left() / static_cast<double>(remaining);
      add(run_stage(plan_.alternatives[place], search, start), place);
    }
    return std::move(result_);
  }

 private:
  std::int64_t evaluations_left() const {
    return plan_.search.limits.evaluations - result_.evaluations;
  }
  double seconds_left() const { return plan_.search.limits.seconds - result_.seconds; }

  bool goes_on() const {
    if (!has_run_) return true;
    const StopReason reason = result_.reason;
    const bool came_to_its_end = reason == StopReason::schedule ||
                                 reason == StopReason::evaluations || reason == StopReason::time;
    return came_to_its_end && evaluations_left() > 0 && seconds_left() > 0 && !runner_.has_failed();
  }

  SearchResult run_stage(const PlannedStage& planned, const SearchSettings& search,
                         const Point& start) {
    TuneObjective objective(plan_.scenarios, planned.space, plan_.family, plan_.threads);
    return runner_.run({planned, search, start, result_.evaluations, result_.cost}, objective);
  }

  std::int64_t share_for_gains() const {
    const std::int64_t given = plan_.search.limits.evaluations;
    const std::int64_t budget = given < unlimited_budget ? given : default_budget({});
    return std::max<std::int64_t>(
        1, static_cast<std::int64_t>(start_share * static_cast<double>(budget)));
  }

  // Gains and orders for free taps to start from, by the default method whatever the plan's is.
  SearchResult find_start(std::int64_t share) {
    SearchSettings search = plan_.search;
    search.method = {};
    search.limits.evaluations = share;
    search.limits.seconds *= start_share;
    for (const PlannedStage& later : plan_.alternatives) {
      if (runner_.has_begun(later)) search.limits.seconds = 0;
    }
    SearchResult found = run_stage(*plan_.gains, search, {});
    return found.x.size() == 0 ? found : as_taps(std::move(found), plan_.gains->space);
  }

  // The answer of a search for gains as one for taps, which may be frozen or tied and then do not
  // make what was found: the costs are those of the taps.
  SearchResult as_taps(SearchResult found, const ParameterSpace& gains) {
    const ParameterSpace& taps = plan_.alternatives.front().space;
    found.x = taps.within(taps.free_parameters(gains.design(found.x)));
    TuneObjective(plan_.scenarios, taps, plan_.family, 1).costs(found.x, &found.cost);
    found.population = found.x;
    found.population_costs = Eigen::VectorXd::Constant(1, found.cost);
    for (HistoryRow& row : found.history) row.best = std::max(row.best, found.cost);
    if (found.reason == StopReason::target && found.cost > plan_.search.limits.target) {
      found.reason = StopReason::evaluations;
    }
    return found;
  }

  // Of equal costs the later one counts: it comes from the search that the plan is for.
  void add(const SearchResult& found, std::size_t alternative) {
    has_run_ = true;
    const double before = result_.cost;
    std::vector<HistoryRow> history = std::move(result_.history);
    for (HistoryRow row : found.history) {
      row.evaluations += result_.evaluations;
      row.best = std::min(row.best, before);
      history.push_back(row);
    }
    const std::int64_t evaluations = result_.evaluations + found.evaluations;
    const double seconds = result_.seconds + found.seconds;
    if (found.x.size() != 0 && (result_.x.size() == 0 || found.cost <= result_.cost)) {
      static_cast<SearchResult&>(result_) = found;
      result_.alternative = alternative;
      result_.structure = plan_.alternatives[alternative].space.structure;
    }
    result_.history = std::move(history);
    result_.evaluations = evaluations;
    result_.seconds = seconds;
    result_.reason = found.reason;
  }

  const TuningPlan& plan_;
  StageRunner& runner_;
  TuningResult result_;
  bool has_run_ = false;
};

}  // namespace detail

NFOPIDN_HOST TuningResult run_tuning(const TuningPlan& plan, StageRunner& runner) {
  const StandardArithmetic arithmetic;
  return detail::TuningRun(plan, runner).run();
}

NFOPIDN_HOST SearchResult PlainStageRunner::run(const SearchStage& stage, Objective& objective) {
  const SearchSettings& settings = stage.search;
  SearchSession search(objective, stage.planned.space.box(), settings.limits, settings.seed);
  search.start = stage.start;
  search.keeps_record = false;
  search.set_interruption(interrupted_);
  search.set_callback([&](const SearchResult& so_far) {
    if (callback_) {
      callback_(stage.spent + so_far.evaluations, std::min(stage.best, so_far.cost));
    }
    return true;
  });
  run_method(search, settings.method);
  search.result.seconds = search.elapsed();
  return search.result;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
