// L3. Runs a scenario under a controller.
#pragma once

#include <algorithm>
#include <limits>
#include <type_traits>
#include <utility>

#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/long_memory/modal.hpp"
#include "nfopidn/simulation/metrics.hpp"
#include "nfopidn/simulation/prepared_run.hpp"

namespace nfopidn {

struct SimulationResult {
  RunTable table;  // a row a sample, up to where the run diverged
  Metrics metrics;
  bool diverged = false;
  double diverged_at = 0;      // [s], when diverged
  Status status = Status::ok;  // why there is no run
};

namespace detail {

template <class Law, class = void>
constexpr bool starts_in_motion = false;
template <class Law>
constexpr bool
    starts_in_motion<Law, std::void_t<decltype(std::declval<Law&>().reset_in_motion())>> = true;

// As after construction, for the start of a run: a law that estimates speeds is told whether the
// robot has the reference's speed already.
template <class Law>
constexpr void restart(Law& law, const Scenario& scenario) {
  if constexpr (starts_in_motion<Law>) {
    if (scenario.initial_velocity.reference) return law.reset_in_motion();
  }
  law.reset();
}

// The run table, sample by sample.
class Recording {
 public:
  explicit Recording(const PreparedRun& run) : run_(run) {
    result_.table.resize(static_cast<Eigen::Index>(run.reference.size()), column_count);
  }

  void add(int k, const State<double>& state, const TorquePair<double>& torque,
           const TorquePair<double>& feedback) {
    const ReferenceSample<double>& r = run_.reference[static_cast<std::size_t>(k)];
    const Measurement<double> exact = {state.x, state.y, state.theta, state.v, state.omega};
    const Channels<double> error =
        rotate_into_robot(world_errors(exact, r), math<double>::heading(state.theta));
    result_.table.row(k) << k * run_.scenario->trajectory.dt(), r.x, r.y, r.theta, state.x, state.y,
        state.theta, state.v, state.omega, error.x, error.y, error.theta, r.tau_left, r.tau_right,
        feedback.left, feedback.right, torque.left, torque.right;
  }

  SimulationResult finish(const LoopResult<double>& loop) {
    if (Interruption::stops_here()) return {{}, {}, false, 0, Status::interrupted};
    const Scenario& scenario = *run_.scenario;
    const Eigen::Index completed = loop.completed;
    result_.diverged = completed < result_.table.rows();
    result_.diverged_at = static_cast<double>(completed) * scenario.trajectory.dt();
    if (result_.diverged) result_.table = RunTable(result_.table.topRows(completed));
    result_.metrics = measure(result_.table, loop.cost, scenario);
    return std::move(result_);
  }

 private:
  const PreparedRun& run_;
  SimulationResult result_;
};

template <class Law>
SimulationResult record(const PreparedRun& run, Law& law) {
  Recording recording(run);
  const auto observe = [&](int k, const State<double>& state, const TorquePair<double>& torque,
                           const TorquePair<double>&) {
    recording.add(k, state, torque, law.feedback());
  };
  restart(law, *run.scenario);
  return recording.finish(
      run_closed_loop<double>(run.plant, law, run.start, run.inputs(), observe, run.poll()));
}

constexpr int host_slack = 57;  // spare history of a host-side filter: its shift becomes rare

}  // namespace detail

using LongController = Controller<double, Modal>;

// For a memory beyond that of a plain filter.
NFOPIDN_HOST LongController long_controller(const ControllerSettings<double>& settings,
                                            const ControlLimits<double>& limits);

// Calls `use` with a controller of taps that fits the settings' memory, at most maximum_memory:
// short ones are unrolled.
template <class Use>
decltype(auto) with_tap_controller(const ControllerDesign& settings,
                                   const ControlLimits<double>& limits, Use&& use) {
  const auto apply = [&](auto&& law) {
    law.configure(settings, limits);
    if (!settings.taps.empty()) {
      law.set_taps(settings.channel_taps(0), settings.channel_taps(1), settings.channel_taps(2),
                   settings.memory + 2);
    }
    return use(law);
  };
  if (settings.needs_tracking_law()) {
    using Variant = TrackingVariant<double>;
    if (settings.memory <= 5) {
      return apply(Controller<double, Fir<double, 7, detail::host_slack>, Variant>());
    }
    return apply(Controller<double, Fir<double, maximum_memory + 2, maximum_memory>, Variant>());
  }
  if (settings.memory <= 5) return apply(Controller<double, Fir<double, 7, detail::host_slack>>());
  if (settings.memory <= 8) return apply(Controller<double, Fir<double, 10, detail::host_slack>>());
  return apply(Controller<double, Fir<double, maximum_memory + 2, maximum_memory>>());
}

// The same for any memory.
template <class Use>
decltype(auto) with_controller(const ControllerDesign& settings,
                               const ControlLimits<double>& limits, Use&& use) {
  if (!settings.memory.is_long()) return with_tap_controller(settings, limits, use);
  LongController law = long_controller(settings, limits);
  return use(law);
}

// What is wrong with a scenario or a controller's settings, if anything.
NFOPIDN_HOST Status check_run(const Scenario& scenario, const ControllerDesign& settings);

// The whole run, recorded. With `status` other than ok there is none: the settings were refused,
// and the cost is infinite, or the run was interrupted.
NFOPIDN_HOST SimulationResult simulate(const Scenario& scenario, const ControllerDesign& settings);

// The cost alone (eq. 41), without recording. What check_run() refuses must not be given. When an
// Interruption has happened, this is no cost.
NFOPIDN_HOST double evaluate(const PreparedRun& run, const ControllerDesign& settings);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST LongController long_controller(const ControllerSettings<double>& settings,
                                            const ControlLimits<double>& limits) {
  LongController law;
  law.configure_structure(settings, limits);
  law.set_filter(Modal(settings));
  return law;
}

NFOPIDN_HOST Status check_run(const Scenario& scenario, const ControllerDesign& settings) {
  const Status whole = check_consistency(scenario).status;
  // A start beyond the divergence distance is a run that diverges at once.
  const Status consistency = whole == Status::inconsistent ? Status::ok : whole;
  for (const Status status : {check_ranges(scenario).status, scenario.robot.validate(), consistency,
                              settings.validate(), check_consistency(settings).status,
                              check_sample_time(settings, scenario.trajectory.dt()).status}) {
    if (status != Status::ok) return status;
  }
  if (settings.taps.empty()) return Status::ok;
  if (settings.memory.is_long()) return Status::inconsistent;
  const int count = channel_count * (settings.memory + 2);
  if (static_cast<int>(settings.taps.size()) != count) return Status::wrong_size;
  const bool finite = std::all_of(settings.taps.begin(), settings.taps.end(),
                                  [](double tap) { return std::isfinite(tap); });
  return finite ? Status::ok : Status::not_finite;
}

NFOPIDN_HOST SimulationResult simulate(const Scenario& scenario, const ControllerDesign& settings) {
  if (const Status status = check_run(scenario, settings); status != Status::ok) {
    SimulationResult refused;
    refused.status = status;
    refused.diverged = true;
    refused.metrics.cost = std::numeric_limits<double>::infinity();
    return refused;
  }
  const StandardArithmetic arithmetic;
  const PreparedRun run = prepare(scenario);
  return with_controller(settings, run.limits, [&](auto& law) { return detail::record(run, law); });
}

NFOPIDN_HOST double evaluate(const PreparedRun& run, const ControllerDesign& settings) {
  const StandardArithmetic arithmetic;
  return with_controller(settings, run.limits, [&](auto& law) {
    detail::restart(law, *run.scenario);
    const auto ignore = [](int, auto&&...) {};
    return run_closed_loop<double>(run.plant, law, run.start, run.inputs(), ignore, run.poll())
        .cost;
  });
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
