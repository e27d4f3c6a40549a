// Lanes and dual numbers against the scalar loop: the same law, the same plant.
#include "nfopidn/tuning/batch.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

struct Candidates {
  std::vector<ControllerSettings<double>> settings;
  std::vector<double> taps;
};

// Gains around the published ones, so that nearly all runs track.
Candidates make_candidates(const ControllerSettings<double>& structure, int count, double spread) {
  Candidates candidates;
  Random random(7);
  const int tap_count = structure.memory + 2;
  std::vector<double> work(static_cast<std::size_t>(tap_count));
  candidates.taps.resize(static_cast<std::size_t>(count * channel_count * tap_count));
  double* taps = candidates.taps.data();
  for (int i = 0; i < count; ++i) {
    ControllerSettings<double> s = structure;
    for (auto& row : s.gains) {
      for (double& gain : row) gain *= random.uniform(1 - spread, 1 + spread);
    }
    candidates.settings.push_back(s);
    for (int channel = 0; channel < channel_count; ++channel, taps += tap_count) {
      fuse_taps(s.generator, s.gains[channel][0], s.gains[channel][1], s.gains[channel][2],
                s.alpha[channel], s.sigma[channel], s.memory, taps, work.data());
    }
  }
  return candidates;
}

void expect_equal_costs(const Scenario& scenario, const ControllerSettings<double>& structure,
                        int count, double spread, const char* what) {
  const Candidates candidates = make_candidates(structure, count, spread);
  BatchEvaluator evaluator(prepare(scenario), structure);
  std::vector<double> reference;
  for (const auto& settings : candidates.settings) {
    reference.push_back(evaluate(evaluator.run(), settings));
  }
  std::vector<double> first;
  for (int set = 0; set < 4; ++set) {
    const auto instructions = static_cast<InstructionSet>(set);
    if (batch_kernels(instructions).costs == nullptr) continue;
    evaluator.set_instruction_set(instructions);
    std::vector<double> costs(static_cast<std::size_t>(count));
    evaluator.costs_of_laws(candidates.taps.data(), count, costs.data());
    for (std::size_t i = 0; i < costs.size(); ++i) {
      const double tolerance = reference[i] < 0.1 ? 1e-12 : 1e-6;
      EXPECT_NEAR(costs[i], reference[i], tolerance * reference[i]) << what << " " << i;
    }
    if (first.empty()) first = costs;
    EXPECT_EQ(costs, first) << what << ": " << ChoiceNames<InstructionSet>::names[set];
  }
  EXPECT_FALSE(first.empty());
}

TEST(Batch, AgreesWithTheScalarLoopOnEveryInstructionSet) {
  expect_equal_costs(Scenario::published(), {}, 61, 0.1, "published");
}

TEST(Batch, AgreesInEveryStructure) {
  ControllerSettings<double> s;
  s.allocation = Allocation<double>::decoupled();
  s.lateral = Lateral::speed;
  s.memory = 8;
  expect_equal_costs(Scenario::published(), s, 13, 0.1, "decoupled, speed, memory 8");
  s.memory = 20;
  expect_equal_costs(Scenario::published(), s, 13, 0.1, "memory 20");
  // Runs that track: those of the published gains diverge in this form, and there a rounding grows
  // to any size.
  s = steady_settings(Form::incremental);
  s.lateral = Lateral::speed;
  s.memory = 3;
  s.activation = Activation::linear;
  s.anti_windup = AntiWindup::hold;
  expect_equal_costs(Scenario::published(), s, 13, 0.1, "incremental, linear, hold");
  s.anti_windup = AntiWindup::clamp;
  s.frame = Frame::world;
  s.allocation.matrix[0][0] = 0.5;
  expect_equal_costs(Scenario::published(), s, 13, 0.1, "clamp, world, any allocation");
}

TEST(Batch, AgreesInEveryScenario) {
  Scenario scenario = Scenario::published();
  scenario.pose_noise = {0.01, 0.02};
  scenario.delay = 1;
  scenario.substeps = 3;
  scenario.disturbance = {{0.1, 0.02}};
  scenario.viscous_friction = 0.01;
  scenario.coulomb_friction = 0.02;
  expect_equal_costs(scenario, {}, 11, 0.1, "noise, delay, friction");
  scenario.viscous_scrub = 0.05;
  scenario.coulomb_scrub = 0.03;
  expect_equal_costs(scenario, {}, 11, 0.1, "friction and scrub");
}

// The published gains in incremental form leave the path: the cost is that of the missing samples.
TEST(Batch, AgreesWhenRunsDiverge) {
  ControllerSettings<double> s;
  s.form = Form::incremental;
  expect_equal_costs(Scenario::published(), s, 27, 0.01, "diverging");
}

// Limits that neurons cannot reach, that they reach with some feedforwards, and with all.
TEST(Batch, AgreesAtTheTorqueLimit) {
  const Trajectory& path = Scenario::published().trajectory;
  ControllerSettings<double> decoupled;
  decoupled.allocation = Allocation<double>::decoupled();
  for (const double limit : {1.0, 2.1, 3.05, 4.0}) {
    Scenario scenario = Scenario::published();
    scenario.torque_limit = limit;
    scenario.initial_pose = {path.x(0) + 0.5, path.y(0) - 0.5, path.theta(0) + 2};
    const std::string what = "limit " + std::to_string(limit);
    expect_equal_costs(scenario, {}, 9, 0.1, what.c_str());
    expect_equal_costs(scenario, decoupled, 9, 0.1, what.c_str());
  }
}

// The published gains leave the path where the motion is exact, and there a rounding grows to any
// size.
ControllerSettings<double> gentle_settings() {
  ControllerSettings<double> settings = steady_settings(Form::incremental);
  settings.lateral = Lateral::speed;
  return settings;
}

TEST(Batch, AgreesWithTheExactIntegrator) {
  Scenario scenario = Scenario::published();
  scenario.integrator = Integrator::exact;
  expect_equal_costs(scenario, gentle_settings(), 37, 0.1, "exact");
  scenario.substeps = 2;
  scenario.viscous_friction = 0.01;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, viscous");
  scenario.viscous_friction = 0;
  scenario.coulomb_friction = 0.03;
  scenario.disturbance = {{0.1, 0.02}};
  scenario.pose_noise = {0.001, 0.002};
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, friction, noise");
}

TEST(Batch, AgreesWithBothKindsOfFrictionWhereTheMotionIsExact) {
  Scenario scenario = Scenario::published();
  scenario.integrator = Integrator::exact;
  scenario.viscous_friction = 0.01;
  scenario.coulomb_friction = 0.02;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, both frictions");
  scenario.viscous_scrub = 0.05;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, both frictions, scrub");
  scenario.viscous_friction = 0;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, Coulomb friction, scrub");
  scenario.coulomb_friction = 0;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, viscous scrub");
}

TEST(Batch, AgreesWithCoulombScrub) {
  Scenario scenario = Scenario::published();
  scenario.coulomb_scrub = 0.03;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "Coulomb scrub");
  scenario.integrator = Integrator::exact;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, Coulomb scrub");
  scenario.coulomb_friction = 0.02;
  scenario.viscous_scrub = 0.05;
  expect_equal_costs(scenario, gentle_settings(), 11, 0.1, "exact, Coulomb friction, scrub");
}

void expect_gradient(const Scenario& scenario, const ControllerSettings<double>& structure,
                     const char* what) {
  const Candidates candidates = make_candidates(structure, 1, 0.1);
  const BatchEvaluator evaluator(prepare(scenario), structure);
  constexpr int size = 21;
  std::vector<double> directions(size * size, 0.0);
  for (int i = 0; i < size; ++i) directions[static_cast<std::size_t>(i * size + i)] = 1;
  double slopes[size];
  const double cost = evaluator.gradient(candidates.taps.data(), directions.data(), size, slopes);
  double alone = 0;
  evaluator.costs_of_laws(candidates.taps.data(), 1, &alone);
  EXPECT_NEAR(cost, alone, 1e-12 * alone) << what;
  for (const int few : {1, 4, 6, 8, 12, 16, 17}) {
    double again[size];
    EXPECT_EQ(evaluator.gradient(candidates.taps.data(), directions.data(), few, again), cost);
    EXPECT_TRUE(std::equal(again, again + few, slopes)) << what << few;
  }
  for (int i = 0; i < size; ++i) {
    constexpr double width = 1e-6;
    std::vector<double> around = candidates.taps;
    double ends[2];
    for (int side = 0; side < 2; ++side) {
      around[static_cast<std::size_t>(i)] =
          candidates.taps[static_cast<std::size_t>(i)] + (side == 0 ? width : -width);
      evaluator.costs_of_laws(around.data(), 1, &ends[side]);
    }
    const double difference = (ends[0] - ends[1]) / (2 * width);
    EXPECT_NEAR(slopes[i], difference, 1e-6 * std::max(1.0, std::fabs(difference))) << what << i;
  }
}

TEST(Gradient, IsThatOfDifferences) {
  expect_gradient(Scenario::published(), {}, "lanes ");
  Scenario scenario = Scenario::published();
  scenario.integrator = Integrator::exact;
  scenario.viscous_friction = 0.01;
  expect_gradient(scenario, {}, "exact integrator ");
  scenario.viscous_friction = 0;
  scenario.coulomb_friction = 0.02;
  expect_gradient(scenario, gentle_settings(), "exact integrator with friction ");
  scenario.viscous_friction = 0.01;
  expect_gradient(scenario, gentle_settings(), "exact integrator with both ");
  scenario.viscous_scrub = 0.05;
  expect_gradient(scenario, gentle_settings(), "exact integrator with viscous scrub ");
  scenario.coulomb_scrub = 0.01;
  expect_gradient(scenario, gentle_settings(), "exact integrator with scrub ");
}

// With a torque limit that is met. The rule hold jumps there, and has no slope.
TEST(Gradient, PassesTheTorqueLimit) {
  ControllerSettings<double> structure = steady_settings(Form::incremental);
  structure.anti_windup = AntiWindup::clamp;
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::exact}) {
    Scenario scenario = short_scenario();
    scenario.integrator = integrator;
    const double free = evaluate(prepare(scenario), structure);
    scenario.torque_limit = 0.1;
    EXPECT_NE(evaluate(prepare(scenario), structure), free);
    expect_gradient(scenario, structure, "clamp ");
  }
}

// Bounds at or over every second candidate's cost, and under the others', hardly or by far.
void expect_bounds_kept(const Scenario& scenario, const ControllerSettings<double>& structure,
                        int count, const char* what) {
  const Candidates candidates = make_candidates(structure, count, 0.3);
  BatchEvaluator evaluator(prepare(scenario), structure);
  std::vector<double> exact(static_cast<std::size_t>(count)), bounds = exact;
  evaluator.costs_of_laws(candidates.taps.data(), count, exact.data());
  for (std::size_t i = 0; i < exact.size(); ++i) {
    constexpr double shares[] = {1.0, 0.99, 1.01, 0.01};
    bounds[i] = shares[i % 4] * exact[i];
  }
  std::vector<double> first;
  for (int set = 0; set < 4; ++set) {
    const auto instructions = static_cast<InstructionSet>(set);
    if (batch_kernels(instructions).costs == nullptr) continue;
    evaluator.set_instruction_set(instructions);
    std::vector<double> costs(exact.size());
    evaluator.costs_of_laws(candidates.taps.data(), count, costs.data(), bounds.data());
    int given_up = 0;
    for (std::size_t i = 0; i < costs.size(); ++i) {
      if (i % 2 == 0) {
        EXPECT_EQ(costs[i], exact[i]) << what << ' ' << i;
      } else {
        EXPECT_GT(costs[i], bounds[i]) << what << ' ' << i;
      }
      given_up += costs[i] > 1.001 * exact[i] ? 1 : 0;
    }
    EXPECT_GT(given_up, 0) << what;
    if (first.empty()) first = costs;
    EXPECT_EQ(costs, first) << what << ": " << ChoiceNames<InstructionSet>::names[set];
  }
}

TEST(Batch, GivesUpNoCandidateThatKeepsItsBound) {
  expect_bounds_kept(Scenario::published(), {}, 61, "published");
  ControllerSettings<double> settings;
  settings.memory = 8;
  expect_bounds_kept(Scenario::published(), settings, 13, "memory 8");
  Scenario scenario = Scenario::published();
  scenario.pose_noise = {0.01, 0.01};
  expect_bounds_kept(scenario, {}, 13, "noise");
  scenario.integrator = Integrator::exact;
  expect_bounds_kept(scenario, {}, 9, "one by one");
}

}  // namespace
}  // namespace nfopidn::test
