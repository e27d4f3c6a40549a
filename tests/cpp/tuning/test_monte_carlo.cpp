// Runs with a robot, a start and noise of their own against simulate(), one by one.
#include "nfopidn/tuning/monte_carlo.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

std::vector<std::size_t> places(const std::vector<std::string>& names) {
  std::vector<std::size_t> result;
  for (std::size_t i = 0; i < drawn_parameters().size(); ++i) {
    const char* const name = drawn_parameters()[i].name;
    if (std::find(names.begin(), names.end(), name) != names.end()) result.push_back(i);
  }
  return result;
}

constexpr std::uint64_t first_seed = RunSeeds::count - 3;  // the seeds begin again at 0

// What a test draws: names in the order of drawn_parameters(), and each run's values.
struct Drawn {
  std::vector<std::string> names;
  std::vector<double> values;
  int count;
};

Drawn draw(const std::vector<std::pair<std::string, std::pair<double, double>>>& bounds,
           int count) {
  Drawn drawn;
  drawn.count = count;
  Random random(11);
  for (const auto& one : bounds) drawn.names.push_back(one.first);
  for (int i = 0; i < count; ++i) {
    for (const auto& [name, range] : bounds) {
      const double value = random.uniform(range.first, range.second);
      drawn.values.push_back(name == "delay" ? std::floor(value) : value);
    }
  }
  return drawn;
}

// The scenario of a run, made by hand.
Scenario by_hand(const Scenario& base, const Drawn& drawn, int run) {
  Scenario s = base;
  s.model = base.modelled_robot();
  s.noise_source = NoiseSource::counter;
  s.seed = (first_seed + static_cast<std::uint64_t>(run)) % (std::uint64_t{1} << 53);
  const double* value = drawn.values.data() + static_cast<std::size_t>(run) * drawn.names.size();
  for (const std::string& name : drawn.names) {
    const double x = *value++;
    if (name == "mass") s.robot.mass = x;
    if (name == "inertia") s.robot.inertia = x;
    if (name == "track_width") s.robot.track_width = x;
    if (name == "wheel_radius") s.robot.wheel_radius = x;
    if (name == "viscous_friction") s.viscous_friction = x;
    if (name == "coulomb_friction") s.coulomb_friction = x;
    if (name == "viscous_scrub") s.viscous_scrub = x;
    if (name == "coulomb_scrub") s.coulomb_scrub = x;
    if (name == "disturbance_force") s.disturbance[0][0] = x;
    if (name == "disturbance_moment") s.disturbance[0][1] = x;
    if (name == "position_noise") s.pose_noise[0] = x;
    if (name == "heading_noise") s.pose_noise[1] = x;
    if (name == "delay") s.delay = static_cast<int>(x);
    if (name == "start_x") s.initial_pose = {x, (*s.initial_pose)[1], (*s.initial_pose)[2]};
    if (name == "start_y") s.initial_pose = {(*s.initial_pose)[0], x, (*s.initial_pose)[2]};
    if (name == "start_theta") s.initial_pose = {(*s.initial_pose)[0], (*s.initial_pose)[1], x};
    if (name == "path_scale") {
      TrajectorySettings settings = s.trajectory.settings;
      settings.scale = x;
      EXPECT_EQ(make_trajectory(settings, s.trajectory), Status::ok);
    }
  }
  return s;
}

// On every instruction set; to the bit on all of them, in other company and on other threads.
// At least so many runs must track.
void expect_as_one_by_one(const Scenario& base, const ControllerDesign& design, const Drawn& drawn,
                          const char* what, int tracking = 10) {
  MonteCarloRuns runs(DrawnScenarios(base, places(drawn.names)), design);
  std::vector<double> reference;
  std::vector<SimulationResult> replayed;
  for (int i = 0; i < drawn.count; ++i) {
    const Scenario own = by_hand(base, drawn, i);
    reference.push_back(simulate(own, design).metrics.cost);
    replayed.push_back(simulate_as_drawn(own, design));
  }
  EXPECT_GE(std::count_if(reference.begin(), reference.end(), [](double e) { return e < 0.1; }),
            tracking)
      << what;
  std::vector<double> first;
  ThreadPool one(1), three(3);
  for (int set = 0; set < 4; ++set) {
    const auto instructions = static_cast<InstructionSet>(set);
    if (batch_kernels(instructions).monte_carlo == nullptr) continue;
    runs.set_instruction_set(instructions);
    std::vector<double> costs(reference.size());
    runs.costs(drawn.values.data(), drawn.count, {first_seed, 1}, costs.data(), one);
    for (std::size_t i = 0; i < costs.size(); ++i) {
      // Where a run is lost a rounding grows to any size: there the same arithmetic alone agrees.
      if (reference[i] < 0.1) {
        EXPECT_NEAR(costs[i], reference[i], 1e-12 * reference[i]) << what << " " << i;
      }
      EXPECT_EQ(costs[i], replayed[i].metrics.cost) << what << " " << i;
    }
    if (first.empty()) first = costs;
    EXPECT_EQ(costs, first) << what << ": " << ChoiceNames<InstructionSet>::names[set];
    std::vector<double> again(costs.size());
    runs.costs(drawn.values.data(), drawn.count, {first_seed, 1}, again.data(), three);
    EXPECT_EQ(again, first) << what << ", three threads";
    const double* last =
        drawn.values.data() + static_cast<std::size_t>(drawn.count - 1) * drawn.names.size();
    runs.costs(last, 1, RunSeeds{first_seed, 1}.from(drawn.count - 1), again.data(), one);
    EXPECT_EQ(again[0], first.back()) << what << ", alone";
  }
  EXPECT_FALSE(first.empty());
}

const std::vector<std::pair<std::string, std::pair<double, double>>> robot_bounds = {
    {"mass", {10.5, 12.5}},
    {"inertia", {0.5, 0.65}},
    {"track_width", {0.42, 0.47}},
    {"wheel_radius", {0.072, 0.08}}};

ControllerDesign steady() {
  ControllerSettings<double> settings = steady_settings(Form::incremental);
  settings.lateral = Lateral::speed;
  return settings;
}

TEST(MonteCarlo, LanesHaveARobotEach) {
  // Else all of it would be compared with itself.
  EXPECT_TRUE(runs_in_lanes(Scenario::published(), steady()));
  EXPECT_TRUE(MonteCarloRuns(DrawnScenarios(Scenario::published(), {}), steady()).has_lanes());
  expect_as_one_by_one(Scenario::published(), steady(), draw(robot_bounds, 71), "robots");
}

TEST(MonteCarlo, LanesHaveNoiseAndAStartEach) {
  auto bounds = robot_bounds;
  bounds.insert(bounds.end(), {{"disturbance_force", {-0.5, 0.5}},
                               {"disturbance_moment", {-0.05, 0.05}},
                               {"position_noise", {0, 0.003}},
                               {"heading_noise", {0, 0.003}},
                               {"start_x", {3.95, 4.05}},
                               {"start_y", {-0.05, 0.05}},
                               {"start_theta", {1.0, 1.1}}});
  expect_as_one_by_one(Scenario::published(), steady(), draw(bounds, 71), "noise and start");
}

TEST(MonteCarlo, LanesHaveFrictionAndDelayEach) {
  auto bounds = robot_bounds;
  bounds.insert(
      bounds.end(),
      {{"viscous_friction", {0, 0.002}}, {"coulomb_friction", {0, 0.02}}, {"delay", {0, 2}}});
  Scenario scenario = Scenario::published();
  scenario.substeps = 2;
  expect_as_one_by_one(scenario, steady(), draw(bounds, 40), "friction and delay");
  bounds.insert(bounds.begin() + 6, {{"viscous_scrub", {0, 0.02}}, {"coulomb_scrub", {0, 0.02}}});
  expect_as_one_by_one(scenario, steady(), draw(bounds, 40), "scrub and delay");
}

TEST(MonteCarlo, NoiseOfLargeHeadingsTurnsTheWholeWay) {
  auto bounds = robot_bounds;
  bounds.push_back({"heading_noise", {0.1, 0.2}});
  expect_as_one_by_one(Scenario::published(), steady(), draw(bounds, 33), "large noise", 5);
}

TEST(MonteCarlo, RunsTheTrackingLawFromAStartInMotion) {
  auto bounds = robot_bounds;
  bounds.push_back({"heading_noise", {0, 0.003}});
  Scenario scenario = Scenario::published();
  scenario.initial_velocity.reference = true;
  ControllerDesign design = recommended_tracking();
  expect_as_one_by_one(scenario, design, draw(bounds, 33), "tracking law");
}

TEST(MonteCarlo, RunsTheExactIntegratorInLanesWithoutFriction) {
  auto bounds = robot_bounds;
  bounds.push_back({"disturbance_force", {-0.5, 0.5}});
  Scenario scenario = Scenario::published();
  scenario.integrator = Integrator::exact;
  expect_as_one_by_one(scenario, steady(), draw(bounds, 33), "exact");
  bounds.push_back({"heading_noise", {0, 0.003}});
  expect_as_one_by_one(scenario, steady(), draw(bounds, 33), "exact, noise");
}

TEST(MonteCarlo, RunsTheExactIntegratorInLanesWithFriction) {
  Scenario scenario = Scenario::published();
  scenario.integrator = Integrator::exact;
  auto bounds = robot_bounds;
  bounds.push_back({"coulomb_friction", {0, 0.02}});
  expect_as_one_by_one(scenario, steady(), draw(bounds, 33), "exact, Coulomb friction");
  bounds = robot_bounds;
  bounds.insert(
      bounds.end(),
      {{"viscous_friction", {0, 0.002}}, {"coulomb_friction", {0, 0.02}}, {"delay", {0, 2}}});
  expect_as_one_by_one(scenario, steady(), draw(bounds, 33), "exact, both frictions");
  bounds.insert(bounds.begin() + 6, {"viscous_scrub", {0, 0.02}});
  expect_as_one_by_one(scenario, steady(), draw(bounds, 33), "exact, viscous scrub");
  bounds.insert(bounds.begin() + 7, {"coulomb_scrub", {0, 0.02}});
  expect_as_one_by_one(scenario, steady(), draw(bounds, 33), "exact, Coulomb scrub");
  bounds.erase(bounds.begin() + 6, bounds.begin() + 8);
  // Some with viscous friction and some without, which meet in no lanes.
  Drawn mixed = draw(bounds, 33);
  for (std::size_t i = 0; i < mixed.values.size(); i += 2 * mixed.names.size()) {
    mixed.values[i + mixed.names.size() - 3] = 0;
  }
  expect_as_one_by_one(scenario, steady(), mixed, "exact, mixed");
}

// Longer memories and other paths.
TEST(MonteCarlo, RunsTheRestOneByOne) {
  Scenario sampled = Scenario::published();
  sampled.disturbance.assign(static_cast<std::size_t>(sampled.trajectory.size()), {0.1, 0.01});
  ControllerDesign longer = steady();
  longer.memory = 6;
  Scenario free_start = Scenario::published();
  free_start.initial_pose.reset();
  const auto with = [&](const char* name, double low, double high) {
    auto bounds = robot_bounds;
    bounds.insert(name == std::string("path_scale") ? bounds.begin() : bounds.end(),
                  {name, {low, high}});
    return draw(bounds, 5);
  };
  const auto expect_equal = [](const Scenario& base, const ControllerDesign& design,
                               const Drawn& drawn, const char* what) {
    const MonteCarloRuns runs(DrawnScenarios(base, places(drawn.names)), design);
    std::vector<double> costs(static_cast<std::size_t>(drawn.count));
    ThreadPool pool(2);
    runs.costs(drawn.values.data(), drawn.count, {first_seed, 1}, costs.data(), pool);
    for (int i = 0; i < drawn.count; ++i) {
      EXPECT_EQ(costs[static_cast<std::size_t>(i)],
                simulate_as_drawn(by_hand(base, drawn, i), design).metrics.cost)
          << what;
    }
  };
  expect_equal(sampled, steady(), with("heading_noise", 0, 0.003), "disturbance by the sample");
  expect_equal(Scenario::published(), longer, with("heading_noise", 0, 0.003), "memory 6");
  expect_equal(free_start, steady(), with("path_scale", 0.9, 1.1), "scale");
}

TEST(MonteCarlo, WhatHasNoLanesIsAskedForEachRun) {
  const Drawn drawn = draw(robot_bounds, 600);
  const MonteCarloRuns runs(
      DrawnScenarios(Scenario::published(), places(drawn.names)),
      [](const Scenario& one) { return one.robot.mass + static_cast<double>(one.seed % 1000); });
  std::vector<double> costs(600);
  ThreadPool pool(2);
  runs.costs(drawn.values.data(), drawn.count, {first_seed, 2}, costs.data(), pool);
  for (int i = 0; i < drawn.count; ++i) {
    const std::uint64_t seed =
        (first_seed + 2 * static_cast<std::uint64_t>(i)) % (std::uint64_t{1} << 53);
    EXPECT_EQ(costs[static_cast<std::size_t>(i)],
              drawn.values[static_cast<std::size_t>(4 * i)] + static_cast<double>(seed % 1000));
  }
}

TEST(MonteCarlo, DrawsThatAreLostCostWhatMissingSamplesDo) {
  auto bounds = robot_bounds;
  bounds.push_back({"start_y", {-9, 9}});
  expect_as_one_by_one(Scenario::published(), steady(), draw(bounds, 33), "far starts", 1);
}

// Each sample is that of simulate(), which is the scalar loop.
TEST(MonteCarlo, ARunInTheLanesArithmeticHasTheSameSamples) {
  auto bounds = robot_bounds;
  bounds.push_back({"heading_noise", {0, 0.003}});
  const Drawn drawn = draw(bounds, 1);
  const Scenario own = by_hand(Scenario::published(), drawn, 0);
  const SimulationResult scalar = simulate(own, steady());
  const SimulationResult lanes = simulate_as_drawn(own, steady());
  ASSERT_EQ(lanes.table.rows(), scalar.table.rows());
  EXPECT_LT((lanes.table - scalar.table).abs().maxCoeff(), 1e-11);
  EXPECT_NEAR(lanes.metrics.energy, scalar.metrics.energy, 1e-11 * scalar.metrics.energy);
  EXPECT_FALSE(lanes.diverged);
}

TEST(MonteCarlo, ARunInTheLanesArithmeticEndsWhereItDiverges) {
  Scenario scenario = Scenario::published();
  scenario.noise_source = NoiseSource::counter;
  scenario.initial_pose = {4, 9.5, -2};
  const SimulationResult scalar = simulate(scenario, ControllerDesign{});
  const SimulationResult lanes = simulate_as_drawn(scenario, ControllerDesign{});
  EXPECT_TRUE(scalar.diverged);
  EXPECT_EQ(lanes.diverged_at, scalar.diverged_at);
  EXPECT_EQ(lanes.table.rows(), scalar.table.rows());
}

}  // namespace
}  // namespace nfopidn::test
