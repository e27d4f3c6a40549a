// Time of the closed loop: published scenario, 751 samples, one core, scalar double.
#include <benchmark/benchmark.h>

#include "nfopidn/simulation/simulate.hpp"

namespace {

void per_step(benchmark::State& state, const nfopidn::PreparedRun& run) {
  const auto steps = static_cast<double>(run.reference.size());
  state.counters["per_step"] = benchmark::Counter(
      steps, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

void cost_alone(benchmark::State& state) {
  const nfopidn::Scenario scenario = nfopidn::Scenario::published();
  const nfopidn::PreparedRun run = nfopidn::prepare(scenario);
  nfopidn::ControllerSettings<double> settings;
  settings.memory = static_cast<int>(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(nfopidn::evaluate(run, settings));
  per_step(state, run);
}
BENCHMARK(cost_alone)->Arg(5)->Arg(8)->Arg(100);

void recorded(benchmark::State& state) {
  const nfopidn::Scenario scenario = nfopidn::Scenario::published();
  const nfopidn::PreparedRun run = nfopidn::prepare(scenario);
  for (auto _ : state) benchmark::DoNotOptimize(nfopidn::simulate(scenario, {}).metrics.cost);
  per_step(state, run);
}
BENCHMARK(recorded);

}  // namespace

BENCHMARK_MAIN();
