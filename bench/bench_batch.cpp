// Time of many candidates at once, a step and lane, for each instruction set; of a gradient; and of
// whole tunings. On one core unless said otherwise.
#include <benchmark/benchmark.h>

#include <string>

#include "nfopidn/tuning/monte_carlo.hpp"
#include "nfopidn/tuning/tune.hpp"

namespace {

using namespace nfopidn;

constexpr int candidates = 1024;

// The published controller leaves the path where the motion is exact, so that a short tuning finds
// another.
std::vector<double> tracking_parameters(const Structure& structure, const Scenario& scenario) {
  if (scenario.integrator != Integrator::exact) {
    return parameters_of(structure.parameters, ControllerSettings<double>{});
  }
  TuningPlan plan = plan_tuning({&scenario}, structure);
  plan.search.limits.evaluations = 2000;
  const TuningResult found = run_tuning(plan);
  return {found.x.begin(), found.x.end()};
}

// Candidates around a tuned controller: all of them track.
std::vector<double> tracking_taps(const Structure& structure, const Scenario& scenario) {
  const std::vector<double> x = tracking_parameters(structure, scenario);
  // Gains found for one path alone are near the edge.
  const double spread = scenario.integrator == Integrator::exact ? 0.02 : 0.1;
  const std::size_t size =
      static_cast<std::size_t>(channel_count * (structure.settings.memory + 2));
  std::vector<double> taps(candidates * size);
  Random random(1);
  for (std::size_t i = 0; i < candidates; ++i) {
    std::vector<double> own = x;
    for (double& number : own) number *= 1 + spread * (2 * random.uniform() - 1);
    parameters_to_law(structure, own, taps.data() + i * size);
  }
  return taps;
}

void per_step(benchmark::State& state, double steps) {
  state.counters["per_step"] = benchmark::Counter(
      steps, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

// With the exact integrator, and with Coulomb [N m] and viscous friction [N m s/rad] at each wheel.
Scenario exact_scenario(double coulomb, double viscous = 0) {
  Scenario scenario = Scenario::published();
  scenario.integrator = Integrator::exact;
  scenario.coulomb_friction = coulomb;
  scenario.viscous_friction = viscous;
  return scenario;
}

void lanes(benchmark::State& state, InstructionSet set,
           const Scenario& scenario = Scenario::published()) {
  if (batch_kernels(set).costs == nullptr) {
    state.SkipWithError("not on this processor");
    return;
  }
  const Structure structure = named_structure(StructureName::paper);
  BatchEvaluator evaluator(prepare(scenario), structure.settings);
  evaluator.set_instruction_set(set);
  const std::vector<double> taps = tracking_taps(structure, scenario);
  std::vector<double> costs(candidates);
  for (auto _ : state) {
    evaluator.costs_of_laws(taps.data(), candidates, costs.data());
    benchmark::DoNotOptimize(costs.data());
  }
  per_step(state, static_cast<double>(scenario.trajectory.size()) * candidates);
}
BENCHMARK_CAPTURE(lanes, avx512, InstructionSet::avx512);
BENCHMARK_CAPTURE(lanes, avx2, InstructionSet::avx2);
BENCHMARK_CAPTURE(lanes, sse2, InstructionSet::sse2);
BENCHMARK_CAPTURE(lanes, generic, InstructionSet::generic);
BENCHMARK_CAPTURE(lanes, avx512_exact, InstructionSet::avx512, exact_scenario(0));
BENCHMARK_CAPTURE(lanes, avx2_exact, InstructionSet::avx2, exact_scenario(0));
BENCHMARK_CAPTURE(lanes, sse2_exact, InstructionSet::sse2, exact_scenario(0));
BENCHMARK_CAPTURE(lanes, avx512_exact_friction, InstructionSet::avx512, exact_scenario(0.1));
BENCHMARK_CAPTURE(lanes, avx2_exact_friction, InstructionSet::avx2, exact_scenario(0.1));
BENCHMARK_CAPTURE(lanes, sse2_exact_friction, InstructionSet::sse2, exact_scenario(0.1));
BENCHMARK_CAPTURE(lanes, avx512_exact_both, InstructionSet::avx512, exact_scenario(0.1, 0.01));
BENCHMARK_CAPTURE(lanes, avx2_exact_both, InstructionSet::avx2, exact_scenario(0.1, 0.01));
BENCHMARK_CAPTURE(lanes, sse2_exact_both, InstructionSet::sse2, exact_scenario(0.1, 0.01));

// Monte Carlo runs, each with a mass of its own.
void own_robots(benchmark::State& state, const Scenario& scenario) {
  const Structure structure = named_structure(StructureName::paper);
  const ControllerDesign design = design_of(structure, tracking_parameters(structure, scenario));
  std::vector<std::size_t> mass;
  for (std::size_t i = 0; i < drawn_parameters().size(); ++i) {
    if (drawn_parameters()[i].name == std::string("mass")) mass.push_back(i);
  }
  const MonteCarloRuns runs(DrawnScenarios(scenario, mass), design);
  std::vector<double> masses(candidates), costs(candidates);
  Random random(1);
  for (double& one : masses) one = scenario.robot.mass * (1 + 0.02 * (2 * random.uniform() - 1));
  ThreadPool pool(1);
  for (auto _ : state) {
    runs.costs(masses.data(), candidates, {}, costs.data(), pool);
    benchmark::DoNotOptimize(costs.data());
  }
  per_step(state, static_cast<double>(scenario.trajectory.size()) * candidates);
}
BENCHMARK_CAPTURE(own_robots, euler, Scenario::published());
BENCHMARK_CAPTURE(own_robots, exact, exact_scenario(0));
BENCHMARK_CAPTURE(own_robots, exact_friction, exact_scenario(0.1));
BENCHMARK_CAPTURE(own_robots, exact_both, exact_scenario(0.1, 0.01));

void gradient(benchmark::State& state, const Scenario& scenario) {
  const Structure structure = named_structure(StructureName::paper);
  TuneObjective objective({&scenario}, ParameterSpace::whole(structure), 1, 1);
  const std::vector<double> x = parameters_of(structure.parameters, ControllerSettings<double>{});
  const Point point = Eigen::Map<const Point>(x.data(), 11);
  double slopes[11];
  for (auto _ : state) benchmark::DoNotOptimize(objective.gradient(point, slopes));
}
BENCHMARK_CAPTURE(gradient, euler, Scenario::published())->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(gradient, exact, exact_scenario(0))->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(gradient, exact_friction, exact_scenario(0.1))->Unit(benchmark::kMicrosecond);

void tuning(benchmark::State& state) {
  const Scenario scenario = Scenario::published();
  TuningPlan plan = plan_tuning({&scenario}, Structure{});
  for (auto _ : state) {
    ++plan.search.seed;
    benchmark::DoNotOptimize(run_tuning(plan).cost);
  }
}
BENCHMARK(tuning)->Unit(benchmark::kMillisecond);

// Over eight scenarios, on one thread and on two.
void tuning_over_eight(benchmark::State& state) {
  std::vector<Scenario> scenarios(8, Scenario::published());
  std::vector<const Scenario*> all;
  for (Scenario& scenario : scenarios) {
    scenario.robot.mass *= 1 + 0.05 * static_cast<double>(all.size());
    all.push_back(&scenario);
  }
  TuningPlan plan = plan_tuning(all, Structure{});
  plan.threads = static_cast<int>(state.range(0));
  for (auto _ : state) {
    ++plan.search.seed;
    benchmark::DoNotOptimize(run_tuning(plan).cost);
  }
}
BENCHMARK(tuning_over_eight)->Arg(1)->Arg(2)->UseRealTime()->Unit(benchmark::kMillisecond);

// The published scenario and eleven that differ in one thing each; and one sample of delay twice,
// with friction the second time.
std::vector<Scenario> variations(Integrator integrator) {
  std::vector<Scenario> all(12, Scenario::published());
  for (Scenario& scenario : all) scenario.integrator = integrator;
  all[1].robot.mass *= 1.2;
  all[2].robot.mass *= 0.8;
  all[3].robot.inertia *= 0.5;
  all[4].robot.track_width *= 0.863;
  all[5].coulomb_friction = 0.03 * all[5].torque_limit;
  all[6].coulomb_friction = 0.06 * all[6].torque_limit;
  all[7].disturbance = {{2, 0.2}};
  all[8].pose_noise = {0.005, 0.005};
  all[9].delay = 1;
  all[10].delay = 1;
  all[10].robot.inertia *= 0.5;
  all[10].robot.track_width *= 0.863;
  all[11].delay = 1;
  all[11].coulomb_friction = all[6].coulomb_friction;
  return all;
}

void tuning_over_variations(benchmark::State& state, StructureName name, Integrator integrator) {
  const std::vector<Scenario> scenarios = variations(integrator);
  std::vector<const Scenario*> all;
  for (const Scenario& scenario : scenarios) all.push_back(&scenario);
  TuningPlan plan = plan_tuning(all, named_structure(name));
  for (auto _ : state) {
    ++plan.search.seed;
    benchmark::DoNotOptimize(run_tuning(plan).cost);
  }
}
BENCHMARK_CAPTURE(tuning_over_variations, extended, StructureName::extended,
                  Integrator::semi_implicit_euler)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tuning_over_variations, tracking, StructureName::tracking,
                  Integrator::semi_implicit_euler)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(tuning_over_variations, tracking_exact, StructureName::tracking,
                  Integrator::exact)
    ->Unit(benchmark::kMillisecond);

// One schedule of the paper, about 4,000 evaluations.
void paper_schedule(benchmark::State& state) {
  const Scenario scenario = Scenario::published();
  const Structure structure = named_structure(StructureName::paper);
  const std::vector<ParameterBounds> bounds = default_bounds(structure);
  Point low(11), high(11);
  for (Eigen::Index i = 0; i < 11; ++i) {
    low(i) = bounds[static_cast<std::size_t>(i)].low;
    high(i) = bounds[static_cast<std::size_t>(i)].high;
  }
  TuneObjective objective({&scenario}, ParameterSpace::whole(structure), 1, 1);
  double evaluations = 0;
  std::uint64_t seed = 0;
  for (auto _ : state) {
    SearchSession search(objective, {low, high, Point::Ones(11)}, {}, ++seed);
    Bfoa(search, {}).run();
    evaluations += static_cast<double>(search.result.evaluations);
  }
  state.counters["evaluations"] =
      benchmark::Counter(evaluations, benchmark::Counter::kAvgIterations);
}
BENCHMARK(paper_schedule)->Unit(benchmark::kMillisecond);

class Sphere : public Objective {
 public:
  bool is_cheap() const override { return true; }
  void costs(const Points& points, double* costs) override {
    for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = points.col(j).squaredNorm();
  }
};

// What the search itself costs an evaluation.
template <class Run>
void bookkeeping(benchmark::State& state, const Run& run) {
  Sphere objective;
  const Point low = Point::Constant(11, -1), high = Point::Constant(11, 0.7);
  double evaluations = 0;
  std::uint64_t seed = 0;
  for (auto _ : state) {
    SearchSession search(objective, {low, high, Point::Ones(11)}, {10000}, ++seed);
    run(search);
    evaluations += static_cast<double>(search.result.evaluations);
  }
  state.counters["per_evaluation"] =
      benchmark::Counter(evaluations, benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
void bookkeeping_bfoa(benchmark::State& state) {
  bookkeeping(state, [&](SearchSession& search) {
    BfoaOptions options;
    if (state.range(0) == 0) options.attractant_depth = options.repellent_height = 0;
    Bfoa(search, options).run();
  });
}
void bookkeeping_bfoa_plus(benchmark::State& state) {
  bookkeeping(state, [](SearchSession& search) { BfoaPlus(search, {}, 10000).run(); });
}
BENCHMARK(bookkeeping_bfoa)->ArgName("swarming")->Arg(0)->Arg(1);
BENCHMARK(bookkeeping_bfoa_plus);

}  // namespace

BENCHMARK_MAIN();
