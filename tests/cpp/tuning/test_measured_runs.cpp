// Figures of many runs against simulate_as_drawn(), one by one.
#include "nfopidn/tuning/measured_runs.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

Scenario measured_scenario(NoiseSource source) {
  Scenario scenario = Scenario::published();
  scenario.pose_noise = {0.02, 0.02};
  scenario.noise_source = source;
  return scenario;
}

std::vector<double> numbers_of(const RunFigures& figures) {
  std::vector<double> numbers;
  figures.for_each([&](const char* /*name*/, double value) { numbers.push_back(value); });
  return numbers;
}

void expect_same_figures(const RunFigures& found, const SimulationResult& run, const char* what) {
  const std::vector<double> wanted = numbers_of(figures_of(run));
  const std::vector<double> numbers = numbers_of(found);
  const std::vector<const char*> names = RunFigures::names();
  ASSERT_EQ(numbers.size(), names.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const bool both_unknown = std::isnan(numbers[i]) && std::isnan(wanted[i]);
    EXPECT_TRUE(both_unknown || numbers[i] == wanted[i]) << what << ": " << names[i];
  }
}

TEST(MeasuredRuns, DrawsAreRunsOneByOne) {
  const ControllerDesign design;
  for (const NoiseSource source : {NoiseSource::counter, NoiseSource::mersenne}) {
    Scenario scenario = measured_scenario(source);
    const RunDriver driver(design);
    EXPECT_EQ(driver.has_lanes(scenario), source == NoiseSource::counter);
    std::vector<std::uint64_t> seeds = {7, 3, (std::uint64_t{1} << 52) + 1};
    for (std::uint64_t seed = 100; seed < 170; ++seed) seeds.push_back(seed);
    std::vector<RunFigures> figures(seeds.size());
    ThreadPool pool(2);
    measure_draws(scenario, driver, seeds.data(), static_cast<std::ptrdiff_t>(seeds.size()),
                  figures.data(), pool);
    for (std::size_t i = 0; i < seeds.size(); i += 9) {
      scenario.seed = seeds[i];
      expect_same_figures(figures[i], simulate_as_drawn(scenario, design), "draw");
    }
    EXPECT_NE(figures[0].metrics.cost, figures[1].metrics.cost);
  }
}

TEST(MeasuredRuns, ARunThatDivergesEndsAlone) {
  const ControllerDesign design;
  Scenario scenario = measured_scenario(NoiseSource::counter);
  scenario.pose_noise = {0.2, 0.2};
  std::vector<std::uint64_t> seeds;
  for (std::uint64_t seed = 0; seed < 33; ++seed) seeds.push_back(seed);
  const auto count = static_cast<std::ptrdiff_t>(seeds.size());
  std::vector<RunFigures> figures(seeds.size());
  ThreadPool pool(1);
  measure_draws(scenario, RunDriver(design), seeds.data(), count, figures.data(), pool);
  std::vector<double> farthest;
  for (const RunFigures& one : figures) {
    if (std::isnan(one.diverged_at)) farthest.push_back(one.metrics.position_max);
  }
  ASSERT_GT(farthest.size(), 8U);
  std::sort(farthest.begin(), farthest.end());
  scenario.divergence_distance = farthest[farthest.size() / 2];
  measure_draws(scenario, RunDriver(design), seeds.data(), count, figures.data(), pool);
  int lost = 0;
  for (std::size_t i = 0; i < seeds.size(); ++i) {
    lost += std::isnan(figures[i].diverged_at) ? 0 : 1;
    scenario.seed = seeds[i];
    expect_same_figures(figures[i], simulate_as_drawn(scenario, design), "lost");
  }
  EXPECT_GT(lost, 3);
  EXPECT_LT(lost, 30);
}

TEST(MeasuredRuns, NeighboursShareLanesOnlyWhereTheyMay) {
  const Scenario base = measured_scenario(NoiseSource::counter);
  std::vector<Scenario> all(3, base);
  const auto add = [&](const auto& change) {
    Scenario one = base;
    change(one);
    one.seed = all.size();
    all.push_back(one);
    all.push_back(one);
  };
  add([](Scenario& s) {
    s.model = s.robot;
    s.robot.mass = 13;
  });
  add([](Scenario& s) { s.torque_limit = 1; });
  add([](Scenario& s) { s.feedforward = false; });
  add([](Scenario& s) { s.feedforward_limit = 0.05; });
  add([](Scenario& s) { s.integrator = Integrator::exact; });
  add([](Scenario& s) { s.substeps = 2; });
  add([](Scenario& s) { s.delay = 1; });
  add([](Scenario& s) { s.divergence_distance = 2; });
  add([](Scenario& s) { s.cost_weights = {2, 1, 0.5}; });
  add([](Scenario& s) { s.initial_velocity.reference = true; });
  add([](Scenario& s) { s.initial_pose = {3.5, 0.2, 1.0}; });
  add([](Scenario& s) { s.robot.wheel_radius = 0.08; });
  add([](Scenario& s) { s.coulomb_friction = 0.05; });
  add([](Scenario& s) { s.viscous_scrub = 0.05; });
  add([](Scenario& s) { s.coulomb_scrub = 0.05; });
  add([](Scenario& s) { s.disturbance = {{1, 0.1}}; });
  add([](Scenario& s) { s.pose_noise = {0, 0}; });
  add([](Scenario& s) { s.noise_source = NoiseSource::mersenne; });
  add([](Scenario& s) {
    TrajectorySettings settings = s.trajectory.settings;
    settings.scale = 0.9;
    EXPECT_EQ(make_trajectory(settings, s.trajectory), Status::ok);
  });
  std::vector<const Scenario*> scenarios;
  scenarios.reserve(all.size());
  for (const Scenario& one : all) scenarios.push_back(&one);
  ControllerDesign other;
  other.gains[0][0] *= 0.9;
  const std::vector<RunDriver> drivers = {
      RunDriver(ControllerDesign()), RunDriver(other),
      RunDriver([](const Scenario& one) { return simulate_as_drawn(one, ControllerDesign()); })};
  std::vector<RunFigures> figures(drivers.size() * all.size());
  for (const int threads : {1, 2}) {
    ThreadPool pool(threads);
    measure_runs(scenarios, drivers, figures.data(), pool);
    for (std::size_t d = 0; d < drivers.size(); ++d) {
      for (std::size_t i = 0; i < all.size(); ++i) {
        const SimulationResult run = drivers[d].simulate(all[i]);
        expect_same_figures(figures[d * all.size() + i], run, std::to_string(i).c_str());
      }
    }
  }
}

TEST(MeasuredRuns, EveryInstructionSetRecordsTheSameSamples) {
  const ControllerDesign design;
  const Scenario scenario = measured_scenario(NoiseSource::counter);
  const LaneSetting setting(scenario, design);
  std::vector<LaneRun> runs;
  for (std::uint64_t seed = 0; seed < 19; ++seed) {
    runs.push_back(LaneSetting::own(scenario));
    runs.back().seed = seed;
    runs.back().robot.mass += 0.1 * static_cast<double>(seed);
  }
  int sets = 0;
  for (const InstructionSet set : {InstructionSet::sse2, InstructionSet::avx2,
                                   InstructionSet::avx512, InstructionSet::generic}) {
    const auto kernel = batch_kernels(set).record;
    if (kernel == nullptr) continue;
    ++sets;
    int seen = 0;
    LaneRecording(setting).run(runs.data(), static_cast<int>(runs.size()), scenario.delay, kernel,
                               [&](int run, const SimulationResult& result) {
                                 EXPECT_EQ(run, seen++);
                                 if (run % 6 != 0) return;
                                 Scenario own = scenario;
                                 own.model = scenario.robot;
                                 own.robot = runs[static_cast<std::size_t>(run)].robot;
                                 own.seed = runs[static_cast<std::size_t>(run)].seed;
                                 const SimulationResult alone = simulate_as_drawn(own, design);
                                 ASSERT_EQ(result.table.rows(), alone.table.rows());
                                 EXPECT_TRUE((result.table == alone.table).all()) << run;
                                 EXPECT_EQ(result.metrics.energy, alone.metrics.energy);
                               });
    EXPECT_EQ(seen, 19);
  }
  EXPECT_GT(sets, 0);
}

TEST(MeasuredRuns, DrawnRunsAreRunsOneByOne) {
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < drawn_parameters().size(); ++i) {
    const std::string name = drawn_parameters()[i].name;
    if (name == "mass" || name == "coulomb_friction" || name == "delay") drawn.push_back(i);
  }
  ASSERT_EQ(drawn.size(), 3U);
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::exact}) {
    Scenario base = measured_scenario(NoiseSource::mersenne);  // drawn runs have their own
    base.integrator = integrator;
    const DrawnScenarios scenarios(base, drawn);
    constexpr int count = 80;
    std::vector<double> values;
    Random random(5);
    for (int i = 0; i < count; ++i) {
      values.push_back(random.uniform(9, 14));
      values.push_back(i % 3 == 0 ? 0.05 : 0.0);  // exactly integrated it goes alone
      values.push_back(i % 4);
    }
    const ControllerDesign design;
    const RunDriver lanes(design);
    const RunDriver alone(
        [&](const Scenario& one) { return simulate_as_drawn(one, ControllerDesign()); });
    for (const RunDriver* driver : {&lanes, &alone}) {
      std::vector<RunFigures> figures(count);
      ThreadPool pool(2);
      measure_drawn(scenarios, *driver, values.data(), count, {9, 2}, figures.data(), pool);
      Scenario own = scenarios.base();
      for (int i = 0; i < count; i += 7) {
        scenarios.apply(values.data() + std::ptrdiff_t{3} * i, RunSeeds{9, 2}[i], own);
        expect_same_figures(figures[static_cast<std::size_t>(i)], simulate_as_drawn(own, design),
                            std::to_string(i).c_str());
      }
    }
  }
}

TEST(RunFigures, SettlingIsTheLastTimeOutside) {
  SimulationResult run;
  run.table = RunTable::Zero(4, column_count);
  run.table.col(column_t) << 0, 0.5, 1, 1.5;
  EXPECT_EQ(settling_time(run), 0);
  run.table(1, column_e_x) = 0.03;
  run.table(1, column_e_y) = -0.041;  // hypotenuse 0.0508
  EXPECT_EQ(settling_time(run), 0.5);
  run.table(3, column_e_y) = -0.051;
  EXPECT_TRUE(std::isinf(settling_time(run)));
  run.table(3, column_e_y) = 0;
  run.diverged = true;
  EXPECT_TRUE(std::isinf(settling_time(run)));
}

TEST(RunFigures, TorqueDeviationIsARootMeanSquare) {
  SimulationResult run;
  EXPECT_TRUE(std::isnan(torque_deviation(run)));
  run.table = RunTable::Zero(2, column_count);
  run.table(0, column_tau_ref_left) = 3;
  run.table(0, column_tau_left) = 1;
  run.table(1, column_tau_right) = 2;
  EXPECT_DOUBLE_EQ(torque_deviation(run), 2);
}

}  // namespace
}  // namespace nfopidn::test
