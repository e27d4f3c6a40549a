// L4. Costs of many runs that each have their own robot, start and noise, on wide instructions and
// several threads.
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/parallel/thread_pool.hpp"
#include "nfopidn/simulation/drawn_parameters.hpp"
#include "nfopidn/tuning/lane_recording.hpp"

namespace nfopidn {

// The seeds of runs: whole numbers that a double holds, `step` apart.
struct RunSeeds {
  static constexpr std::uint64_t count = std::uint64_t{1} << 53;

  std::uint64_t first = 0;
  std::uint64_t step = 1;

  constexpr std::uint64_t operator[](std::ptrdiff_t run) const {
    return (first + step * static_cast<std::uint64_t>(run)) % count;
  }
  constexpr RunSeeds from(std::ptrdiff_t run) const { return {(*this)[run], step}; }
};

// As simulate(). A scenario whose noise is by counter runs in the arithmetic of the lanes, where
// they can run it: a run of MonteCarloRuns to the same bits, with its samples.
NFOPIDN_HOST SimulationResult simulate_as_drawn(const Scenario& scenario,
                                                const ControllerDesign& design);

// Runs of one controller, or of a rival, which has no lanes: on wide instructions and several
// threads what runs_in_lanes(), unless each has a path of its own; all else one by one. Costs are
// those of simulate_as_drawn() to the last bit, on every instruction set, on any number of threads
// and in any company.
class MonteCarloRuns {
 public:
  // A run's cost, one by one.
  using Evaluate = std::function<double(const Scenario&)>;

  MonteCarloRuns(DrawnScenarios scenarios, Evaluate evaluate)
      : scenarios_(std::move(scenarios)), evaluate_(std::move(evaluate)) {}
  MonteCarloRuns(DrawnScenarios scenarios, const ControllerDesign& design)
      : scenarios_(std::move(scenarios)), design_(design), evaluate_([design](const Scenario& one) {
          if (runs_in_lanes(one, design)) return simulate_as_drawn(one, design).metrics.cost;
          return nfopidn::evaluate(prepare(one), design);
        }) {
    set_instruction_set(best_instruction_set());
  }

  void set_instruction_set(InstructionSet set) {
    const bool shares_path = design_.has_value() && !scenarios_.draws("path_scale");
    kernel_ = shares_path ? batch_kernels(set).monte_carlo : nullptr;
  }

  bool has_lanes() const { return kernel_ != nullptr; }

  // values: [count][drawn_count()]; costs: [count]. When an Interruption has happened, these are no
  // costs.
  void costs(const double* values, std::ptrdiff_t count, const RunSeeds& seeds, double* costs,
             ThreadPool& pool) const;

 private:
  static constexpr std::ptrdiff_t piece = 512;

  // A thread's work: as many runs as fit the cache.
  class Piece {
   public:
    Piece(const MonteCarloRuns& owner, const LaneSetting* setting)
        : owner_(owner), setting_(setting), scenario_(owner.scenarios_.base()) {}

    void run(const double* values, std::ptrdiff_t count, const RunSeeds& seeds, double* costs) {
      const auto width = static_cast<std::ptrdiff_t>(owner_.scenarios_.drawn_count());
      waiting_.clear();
      for (std::ptrdiff_t i = 0; i < count; ++i) {
        owner_.scenarios_.apply(values + i * width, seeds[i], scenario_);
        if (setting_ != nullptr && runs_in_lanes(scenario_, *owner_.design_)) {
          waiting_.push_back({scenario_.delay, costs + i, LaneSetting::own(scenario_)});
        } else {
          costs[i] = owner_.evaluate_(scenario_);
        }
      }
      for_each_kind(waiting_, [&](const Waiting* first, const std::vector<LaneRun>& runs) {
        results_.resize(runs.size());
        setting_->with_job(runs.data(), static_cast<int>(runs.size()), first->delay,
                           results_.data(), owner_.kernel_);
        for (std::size_t i = 0; i < runs.size(); ++i) *first[i].result = results_[i];
      });
    }

   private:
    using Waiting = WaitingRun<double>;

    const MonteCarloRuns& owner_;
    const LaneSetting* setting_;  // null: one by one
    Scenario scenario_;
    std::vector<Waiting> waiting_;
    std::vector<double> results_;
  };

  DrawnScenarios scenarios_;
  std::optional<ControllerDesign> design_;  // of a rival none
  Evaluate evaluate_;
  void (*kernel_)(const MonteCarloJob&) = nullptr;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn {

NFOPIDN_HOST SimulationResult simulate_as_drawn(const Scenario& scenario,
                                                const ControllerDesign& design) {
  if (!runs_as_drawn(scenario, design)) return simulate(scenario, design);
  const StandardArithmetic arithmetic;
  const LaneSetting setting(scenario, design);
  const LaneRun own = LaneSetting::own(scenario);
  SimulationResult result;
  LaneRecording(setting).run(&own, 1, scenario.delay,
                             batch_kernels(narrowest_instruction_set()).record,
                             [&](int, const SimulationResult& found) { result = found; });
  return result;
}

NFOPIDN_HOST void MonteCarloRuns::costs(const double* values, std::ptrdiff_t count,
                                        const RunSeeds& seeds, double* costs,
                                        ThreadPool& pool) const {
  const StandardArithmetic arithmetic;
  std::unique_ptr<LaneSetting> setting;
  if (kernel_ != nullptr) setting = std::make_unique<LaneSetting>(scenarios_.base(), *design_);
  pool.for_each_share(count, piece, [&](std::ptrdiff_t first, std::ptrdiff_t share) {
    const StandardArithmetic own_arithmetic;
    const auto width = static_cast<std::ptrdiff_t>(scenarios_.drawn_count());
    Piece runs(*this, setting.get());
    for (std::ptrdiff_t done = 0; done < share && !Interruption::stops_here(); done += piece) {
      const std::ptrdiff_t at = first + done;
      runs.run(values + at * width, std::min(piece, share - done), seeds.from(at), costs + at);
    }
  });
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
