// L4. Figures of many runs, of which nothing else is kept: in lanes where simulate_as_drawn() has
// them so, else one by one; to its bits either way, on any number of threads.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "nfopidn/simulation/run_figures.hpp"
#include "nfopidn/tuning/monte_carlo.hpp"

namespace nfopidn {

// What drives the robot: a controller, or a rival, which has no design and no lanes.
struct RunDriver {
  std::optional<ControllerDesign> design;
  std::function<SimulationResult(const Scenario&)> simulate;

  explicit RunDriver(const ControllerDesign& own)
      : design(own), simulate([own](const Scenario& one) { return simulate_as_drawn(one, own); }) {}
  explicit RunDriver(std::function<SimulationResult(const Scenario&)> own)
      : simulate(std::move(own)) {}

  bool has_lanes(const Scenario& scenario) const {
    return design.has_value() && runs_as_drawn(scenario, *design);
  }
};

// Each driver on each scenario; figures: [drivers][scenarios]. When an Interruption has happened,
// these are no figures.
NFOPIDN_HOST void measure_runs(const std::vector<const Scenario*>& scenarios,
                               const std::vector<RunDriver>& drivers, RunFigures* figures,
                               ThreadPool& pool);

// One driver on one scenario with several seeds of its noise; figures: [count].
NFOPIDN_HOST void measure_draws(const Scenario& scenario, const RunDriver& driver,
                                const std::uint64_t* seeds, std::ptrdiff_t count,
                                RunFigures* figures, ThreadPool& pool);

// The runs of a Monte Carlo analysis, as MonteCarloRuns has them; values: [count][drawn_count()],
// figures: [count].
NFOPIDN_HOST void measure_drawn(const DrawnScenarios& scenarios, const RunDriver& driver,
                                const double* values, std::ptrdiff_t count, const RunSeeds& seeds,
                                RunFigures* figures, ThreadPool& pool);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn {

namespace detail {

inline bool same_numbers(const Eigen::ArrayXd& a, const Eigen::ArrayXd& b) {
  return a.size() == b.size() && (a == b).all();
}

inline bool same_path(const Trajectory& a, const Trajectory& b) {
  return a.dt() == b.dt() && same_numbers(a.x, b.x) && same_numbers(a.y, b.y) &&
         same_numbers(a.theta, b.theta) && same_numbers(a.v, b.v) &&
         same_numbers(a.omega, b.omega) && same_numbers(a.acceleration, b.acceleration) &&
         same_numbers(a.turn_acceleration, b.turn_acceleration) && a.reverse == b.reverse;
}

// Of a robot or a motor.
template <class Settings>
bool same_settings(const Settings& a, const Settings& b) {
  bool same = true;
  Settings::fields([&](const auto& field) { same = same && a.*field.member == b.*field.member; });
  return same;
}

inline bool same_motor(const Scenario& a, const Scenario& b) {
  if (a.motor.has_value() != b.motor.has_value()) return false;
  return !a.motor || same_settings(*a.motor, *b.motor);
}

// Whether two scenarios may be lanes of one block: they differ in what LaneRun has at most.
inline bool share_setting(const Scenario& a, const Scenario& b) {
  return a.torque_limit == b.torque_limit && a.feedforward == b.feedforward &&
         a.feedforward_limit == b.feedforward_limit &&
         a.friction_feedforward == b.friction_feedforward &&
         a.friction_feedforward_speed == b.friction_feedforward_speed && same_motor(a, b) &&
         detail::friction_of(a).is_braked() == detail::friction_of(b).is_braked() &&
         a.integrator == b.integrator && a.substeps == b.substeps && a.delay == b.delay &&
         a.divergence_distance == b.divergence_distance && a.cost_weights == b.cost_weights &&
         a.initial_velocity.reference == b.initial_velocity.reference &&
         same_settings(a.modelled_robot(), b.modelled_robot()) &&
         same_path(a.trajectory, b.trajectory);
}

// Runs that are neighbours in a list and are measured by one thread.
struct MeasuredPiece {
  const RunDriver* driver;
  const LaneSetting* setting;  // null: one by one
  std::ptrdiff_t first, count;
  RunFigures* figures;
};

constexpr std::ptrdiff_t measured_together = 64;

template <class Pieces>
void add_pieces(const MeasuredPiece& whole, Pieces& pieces) {
  for (std::ptrdiff_t done = 0; done < whole.count; done += measured_together) {
    pieces.push_back({whole.driver, whole.setting, whole.first + done,
                      std::min(measured_together, whole.count - done), whole.figures + done});
  }
}

// Of one thread, which keeps what it records from for as long as the setting stays the same.
class LaneMeasurement {
 public:
  template <class RunOf>
  void measure(const MeasuredPiece& piece, const RunOf& run_of) {
    if (setting_ != piece.setting) recording_.emplace(*piece.setting);
    setting_ = piece.setting;
    runs_.clear();
    for (std::ptrdiff_t i = 0; i < piece.count; ++i) runs_.push_back(run_of(piece.first + i));
    recording_->run(
        runs_.data(), static_cast<int>(piece.count), setting_->run().scenario->delay, kernel_,
        [&](int run, const SimulationResult& result) { piece.figures[run] = figures_of(result); });
  }

 private:
  LaneRecording::Kernel kernel_ = batch_kernels(best_instruction_set()).record;
  const LaneSetting* setting_ = nullptr;
  std::optional<LaneRecording> recording_;
  std::vector<LaneRun> runs_;
};

// A thread's share of drawn runs, which are measured piece by piece.
class DrawnMeasurement {
 public:
  // Without a setting all go one by one.
  DrawnMeasurement(const DrawnScenarios& scenarios, const RunDriver& driver,
                   const LaneSetting* setting)
      : scenarios_(scenarios), driver_(driver), scenario_(scenarios.base()) {
    if (setting != nullptr) recording_.emplace(*setting);
  }

  void run(const double* values, std::ptrdiff_t count, const RunSeeds& seeds, RunFigures* figures) {
    const auto width = static_cast<std::ptrdiff_t>(scenarios_.drawn_count());
    waiting_.clear();
    for (std::ptrdiff_t i = 0; i < count; ++i) {
      scenarios_.apply(values + i * width, seeds[i], scenario_);
      if (recording_ && runs_in_lanes(scenario_, *driver_.design)) {
        waiting_.push_back({scenario_.delay, figures + i, LaneSetting::own(scenario_)});
      } else {
        figures[i] = figures_of(driver_.simulate(scenario_));
      }
    }
    for_each_kind(waiting_, [&](const Waiting* first, const std::vector<LaneRun>& runs) {
      recording_->run(runs.data(), static_cast<int>(runs.size()), first->delay, kernel_,
                      [&](int run, const SimulationResult& result) {
                        *first[run].result = figures_of(result);
                      });
    });
  }

 private:
  using Waiting = WaitingRun<RunFigures>;

  const DrawnScenarios& scenarios_;
  const RunDriver& driver_;
  Scenario scenario_;
  std::optional<LaneRecording> recording_;
  LaneRecording::Kernel kernel_ = batch_kernels(best_instruction_set()).record;
  std::vector<Waiting> waiting_;
};

// run_of(i) and simulate(driver, i) give the run i of the list, as a lane and alone.
template <class RunOf, class Simulate>
void measure_pieces(const std::vector<MeasuredPiece>& pieces, const RunOf& run_of,
                    const Simulate& simulate, ThreadPool& pool) {
  pool.for_each_share(
      static_cast<std::ptrdiff_t>(pieces.size()), 1,
      [&](std::ptrdiff_t from, std::ptrdiff_t share) {
        const StandardArithmetic arithmetic;
        LaneMeasurement lanes;
        for (std::ptrdiff_t i = from; i < from + share && !Interruption::stops_here(); ++i) {
          const MeasuredPiece& piece = pieces[static_cast<std::size_t>(i)];
          if (piece.setting != nullptr) {
            lanes.measure(piece, run_of);
            continue;
          }
          for (std::ptrdiff_t run = 0; run < piece.count; ++run) {
            piece.figures[run] = figures_of(simulate(*piece.driver, piece.first + run));
          }
        }
      });
}

}  // namespace detail

NFOPIDN_HOST void measure_runs(const std::vector<const Scenario*>& scenarios,
                               const std::vector<RunDriver>& drivers, RunFigures* figures,
                               ThreadPool& pool) {
  const StandardArithmetic arithmetic;
  const auto count = static_cast<std::ptrdiff_t>(scenarios.size());
  const auto at = [&](std::ptrdiff_t place) -> const Scenario& {
    return *scenarios[static_cast<std::size_t>(place)];
  };
  std::vector<std::unique_ptr<LaneSetting>> settings;
  std::vector<detail::MeasuredPiece> pieces;
  for (const RunDriver& driver : drivers) {
    for (std::ptrdiff_t first = 0; first < count;) {
      std::ptrdiff_t last = first + 1;
      const bool lanes = driver.has_lanes(at(first));
      while (lanes && last < count && driver.has_lanes(at(last)) &&
             detail::share_setting(at(first), at(last))) {
        ++last;
      }
      const LaneSetting* setting = nullptr;
      if (last - first > 1) {
        settings.push_back(std::make_unique<LaneSetting>(at(first), *driver.design));
        setting = settings.back().get();
      }
      detail::add_pieces({&driver, setting, first, last - first, figures + first}, pieces);
      first = last;
    }
    figures += count;
  }
  detail::measure_pieces(
      pieces, [&](std::ptrdiff_t run) { return LaneSetting::own(at(run)); },
      [&](const RunDriver& driver, std::ptrdiff_t run) { return driver.simulate(at(run)); }, pool);
}

NFOPIDN_HOST void measure_draws(const Scenario& scenario, const RunDriver& driver,
                                const std::uint64_t* seeds, std::ptrdiff_t count,
                                RunFigures* figures, ThreadPool& pool) {
  const StandardArithmetic arithmetic;
  std::unique_ptr<LaneSetting> setting;
  if (count > 1 && driver.has_lanes(scenario)) {
    setting = std::make_unique<LaneSetting>(scenario, *driver.design);
  }
  std::vector<detail::MeasuredPiece> pieces;
  detail::add_pieces({&driver, setting.get(), 0, count, figures}, pieces);
  const LaneRun calm = LaneSetting::own(scenario);
  detail::measure_pieces(
      pieces,
      [&](std::ptrdiff_t run) {
        LaneRun own = calm;
        own.seed = seeds[run];
        return own;
      },
      [&](const RunDriver& own, std::ptrdiff_t run) {
        Scenario drawn = scenario;
        drawn.seed = seeds[run];
        return own.simulate(drawn);
      },
      pool);
}

NFOPIDN_HOST void measure_drawn(const DrawnScenarios& scenarios, const RunDriver& driver,
                                const double* values, std::ptrdiff_t count, const RunSeeds& seeds,
                                RunFigures* figures, ThreadPool& pool) {
  const StandardArithmetic arithmetic;
  std::unique_ptr<LaneSetting> setting;
  if (driver.design.has_value() && !scenarios.draws("path_scale") &&
      runs_in_lanes(scenarios.base(), *driver.design)) {
    setting = std::make_unique<LaneSetting>(scenarios.base(), *driver.design);
  }
  const auto width = static_cast<std::ptrdiff_t>(scenarios.drawn_count());
  constexpr std::ptrdiff_t piece = detail::measured_together;
  pool.for_each_share(count, piece, [&](std::ptrdiff_t first, std::ptrdiff_t share) {
    const StandardArithmetic own_arithmetic;
    detail::DrawnMeasurement runs(scenarios, driver, setting.get());
    for (std::ptrdiff_t done = 0; done < share && !Interruption::stops_here(); done += piece) {
      const std::ptrdiff_t at = first + done;
      runs.run(values + at * width, std::min(piece, share - done), seeds.from(at), figures + at);
    }
  });
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
