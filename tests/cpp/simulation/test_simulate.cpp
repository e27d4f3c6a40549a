// Whole runs: the table, the metrics, and that everything that should agree does to the bit.
#include "nfopidn/simulation/playback.hpp"
#include "nfopidn/tuning/structures.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

// A run that reaches its torque limit and turns both ways, with friction and noise.
Scenario rich_scenario() {
  Scenario scenario = short_scenario();
  scenario.torque_limit = 0.2;
  scenario.viscous_friction = 0.002;
  scenario.pose_noise = {0.002, 0.002};
  scenario.seed = 5;
  return scenario;
}

const ControllerSettings<double> positional = steady_settings(Form::positional);

TEST(Simulate, RecordsTrueErrorsAndTorques) {
  const Scenario scenario = rich_scenario();
  const Trajectory& t = scenario.trajectory;
  const SimulationResult result = simulate(scenario, positional);
  ASSERT_EQ(result.table.rows(), t.size());
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const auto at = [&](Column column) { return Real(result.table(k, column)); };
    ASSERT_EQ(at(column_t), static_cast<double>(k) * 0.2);
    ASSERT_EQ(at(column_x_ref), t.x(k));
    ASSERT_EQ(at(column_y_ref), t.y(k));
    ASSERT_EQ(at(column_theta_ref), t.theta(k));
    const Real x = at(column_x_ref) - at(column_x);
    const Real y = at(column_y_ref) - at(column_y);
    const Real cosine = std::cos(at(column_theta));
    const Real sine = std::sin(at(column_theta));
    ASSERT_TRUE(near(at(column_e_x), cosine * x + sine * y, 1e-14L));
    ASSERT_TRUE(near(at(column_e_y), cosine * y - sine * x, 1e-14L));
    ASSERT_TRUE(near(at(column_e_theta),
                     std::remainder(at(column_theta_ref) - at(column_theta), 2 * pi), 1e-14L));
    const auto reference =
        inverse_dynamics(scenario.robot, t.acceleration(k), t.turn_acceleration(k));
    ASSERT_EQ(at(column_tau_ref_left), reference.left);
    ASSERT_EQ(at(column_tau_ref_right), reference.right);
    const auto limited = [](Real torque) { return std::max(-0.2L, std::min(torque, 0.2L)); };
    ASSERT_TRUE(near(at(column_tau_left), limited(at(column_tau_ref_left) + at(column_tau_fb_left)),
                     1e-15L));
    ASSERT_TRUE(near(at(column_tau_right),
                     limited(at(column_tau_ref_right) + at(column_tau_fb_right)), 1e-15L));
  }
}

TEST(Simulate, EveryMetricIsItsFormula) {
  const Scenario scenario = rich_scenario();
  const SimulationResult result = simulate(scenario, positional);
  const RunTable& table = result.table;
  Real pose = 0, square = 0, heading = 0, distance = 0, timed = 0, energy = 0, variation = 0;
  Real cost = 0, farthest = 0, peak = 0, lateral = 0;
  int limited = 0;
  const Robot<double>& robot = scenario.robot;
  for (Eigen::Index k = 0; k < table.rows(); ++k) {
    const auto at = [&](Column column) { return Real(table(k, column)); };
    const Real e2 = at(column_e_x) * at(column_e_x) + at(column_e_y) * at(column_e_y);
    const Real left = at(column_tau_left);
    const Real right = at(column_tau_right);
    square += e2;
    heading += at(column_e_theta) * at(column_e_theta);
    pose += e2 + at(column_e_theta) * at(column_e_theta);
    cost += e2 + at(column_e_theta) * at(column_e_theta) +
            std::pow(at(column_tau_ref_left) - left, 2) +
            std::pow(at(column_tau_ref_right) - right, 2);
    distance += std::sqrt(e2);
    timed += std::sqrt(e2) * at(column_t);
    farthest = std::max(farthest, std::sqrt(e2));
    peak = std::max({peak, std::fabs(left), std::fabs(right)});
    if (k > 0) {
      variation += std::fabs(left - table(k - 1, column_tau_left)) +
                   std::fabs(right - table(k - 1, column_tau_right));
    }
    const Real turn = at(column_omega) * robot.track_width / 2;
    energy += std::fabs(left * (at(column_v) + turn) / robot.wheel_radius) +
              std::fabs(right * (at(column_v) - turn) / robot.wheel_radius);
    lateral = std::max(lateral, std::fabs(robot.mass * at(column_v) * at(column_omega)));
    limited += std::fabs(left) >= 0.2L || std::fabs(right) >= 0.2L ? 1 : 0;
  }
  const Real n = static_cast<Real>(table.rows());
  const Metrics& m = result.metrics;
  const std::map<std::string, Real> expected = {{"cost", cost / n},
                                                {"pose_mse", pose / n},
                                                {"position_rms", std::sqrt(square / n)},
                                                {"position_max", farthest},
                                                {"heading_rms", std::sqrt(heading / n)},
                                                {"iae", distance * 0.2},
                                                {"ise", square * 0.2},
                                                {"itae", timed * 0.2},
                                                {"torque_peak", peak},
                                                {"torque_variation", variation},
                                                {"share_at_limit", limited / n},
                                                {"energy", energy * 0.2},
                                                {"lateral_force_peak", lateral}};
  std::size_t checked = 0;
  Metrics::fields([&](const auto& field) {
    ASSERT_TRUE(expected.count(field.name)) << "no formula for the metric " << field.name;
    const Real formula = expected.at(field.name);
    EXPECT_TRUE(near(m.*field.member, formula, 1e-13L * (1 + formula))) << field.name;
    EXPECT_GT(formula, 0) << field.name << " is not tested by this run";
    ++checked;
  });
  EXPECT_EQ(checked, expected.size());
  EXPECT_LT(m.share_at_limit, 1);
}

TEST(Simulate, EvaluateIsTheCostToTheBit) {
  for (const Form form : {Form::positional, Form::incremental}) {
    for (const int memory : {0, 3, 5, 6, 8, 9, 40, maximum_memory}) {
      auto settings = steady_settings(form);
      settings.memory = memory;
      const Scenario scenario = rich_scenario();
      EXPECT_EQ(evaluate(prepare(scenario), settings), simulate(scenario, settings).metrics.cost)
          << "memory " << memory;
    }
  }
  const Scenario diverging = Scenario::published();
  ControllerSettings<double> settings;
  settings.form = Form::incremental;
  EXPECT_EQ(evaluate(prepare(diverging), settings), simulate(diverging, settings).metrics.cost);
}

// A controller of free taps is that of the gains and orders which give them.
TEST(Simulate, FreeTapsAreThoseOfGainsAndOrders) {
  ControllerDesign design = steady_settings(Form::positional);
  ControllerDesign free = design;
  free.taps = parameters_of(ParameterSet::taps, design);
  const Scenario scenario = rich_scenario();
  EXPECT_TRUE(same_bits(simulate(scenario, free).table, simulate(scenario, design).table));
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    ControllerDesign other = free;
    other.taps[channel * (other.taps.size() / channel_count)] *= 1.01;
    EXPECT_FALSE(same_bits(simulate(scenario, other).table, simulate(scenario, free).table));
  }
}

// The filter that fits a memory best changes nothing of the result but the speed.
TEST(Simulate, LongMemoryWithoutWeightIsShortMemory) {
  auto settings = positional;
  settings.generator = Generator::gl;
  for (int channel = 0; channel < channel_count; ++channel) {
    settings.alpha[channel] = settings.sigma[channel] = 1;  // the series end by themselves
  }
  const Scenario scenario = short_scenario();
  settings.memory = 2;
  const double cost = simulate(scenario, settings).metrics.cost;
  for (const int memory : {5, 6, 8, 9, 300}) {
    settings.memory = memory;
    EXPECT_NEAR(simulate(scenario, settings).metrics.cost, cost, 1e-13) << memory;
  }
}

TEST(Simulate, RepeatsToTheBit) {
  const Scenario scenario = rich_scenario();
  const auto first = simulate(scenario, positional);
  EXPECT_TRUE(same_bits(simulate(scenario, positional).table, first.table));
  Scenario other = scenario;
  other.seed = 6;
  EXPECT_FALSE(same_bits(simulate(other, positional).table, first.table));
  EXPECT_EQ(prepare(scenario).noise.size(), 151U);
  other.pose_noise = {0, 0};
  EXPECT_TRUE(prepare(other).noise.empty());
}

TEST(Simulate, NoiseHasItsDeviations) {
  Scenario scenario = Scenario::published();
  scenario.pose_noise = {0.02, 0.3};
  Real sums[3] = {};
  const PreparedRun run = prepare(scenario);
  for (const Measurement<double>& sample : run.noise) {
    sums[0] += sample.x * sample.x;
    sums[1] += sample.y * sample.y;
    sums[2] += sample.theta * sample.theta;
    EXPECT_NE(sample.x, sample.y);
    EXPECT_EQ(sample.v, 0);
    EXPECT_EQ(sample.omega, 0);
  }
  EXPECT_NEAR(std::sqrt(static_cast<double>(sums[0]) / 751), 0.02, 0.0025);
  EXPECT_NEAR(std::sqrt(static_cast<double>(sums[1]) / 751), 0.02, 0.0025);
  EXPECT_NEAR(std::sqrt(static_cast<double>(sums[2]) / 751), 0.3, 0.04);
}

TEST(Simulate, AConstantDisturbanceIsTheSameOneEverySample) {
  Scenario constant = short_scenario();
  constant.disturbance = {{0.4, -0.05}};
  Scenario by_sample = constant;
  by_sample.disturbance.assign(151, {0.4, -0.05});
  const auto a = simulate(constant, positional);
  EXPECT_TRUE(same_bits(simulate(by_sample, positional).table, a.table));
  EXPECT_FALSE(same_bits(simulate(short_scenario(), positional).table, a.table));
}

TEST(Simulate, ADelayedRobotStaysForItsFirstSamples) {
  Scenario scenario = short_scenario();
  scenario.delay = 4;
  const RunTable table = simulate(scenario, positional).table;
  for (Eigen::Index k = 0; k <= 4; ++k) {
    EXPECT_EQ(table(k, column_x), 1.6);
    EXPECT_EQ(table(k, column_v), 0);
    EXPECT_NE(table(k, column_tau_left), 0);
  }
  EXPECT_NE(table(5, column_v), 0);
}

TEST(Simulate, ADivergedRunEndsThere) {
  Scenario scenario = Scenario::published();
  ControllerSettings<double> settings;
  settings.form = Form::incremental;
  const SimulationResult result = simulate(scenario, settings);
  ASSERT_TRUE(result.diverged);
  const Eigen::Index rows = result.table.rows();
  EXPECT_GT(rows, 5);
  EXPECT_LT(rows, 751);
  EXPECT_NEAR(result.diverged_at, 0.2 * static_cast<double>(rows), 1e-12);
  Real sum = 0;
  for (Eigen::Index k = 0; k < rows; ++k) {
    const auto square = [&](int a, int b) {
      return std::pow(Real(result.table(k, a)) - result.table(k, b), 2);
    };
    sum += square(column_x_ref, column_x) + square(column_y_ref, column_y) +
           std::pow(Real(result.table(k, column_e_theta)), 2) +
           square(column_tau_ref_left, column_tau_left) +
           square(column_tau_ref_right, column_tau_right);
  }
  sum += (751 - Real(rows)) * 10 * 10;
  EXPECT_TRUE(near(result.metrics.cost, sum / 751, 1e-12L));
  EXPECT_LE(result.metrics.position_max, 10);
  scenario.divergence_distance = 1e5;  // nothing gets so far
  EXPECT_FALSE(simulate(scenario, settings).diverged);
}

TEST(Simulate, ARunThatDivergesAtOnceHasNoRows) {
  Scenario scenario = short_scenario();
  scenario.initial_pose = {50, 0, 0};
  const SimulationResult result = simulate(scenario, positional);
  EXPECT_TRUE(result.diverged);
  EXPECT_EQ(result.table.rows(), 0);
  EXPECT_EQ(result.diverged_at, 0);
  EXPECT_EQ(result.metrics.cost, 100);
  EXPECT_EQ(result.metrics.position_max, 0);
  EXPECT_EQ(result.metrics.torque_variation, 0);
}

TEST(Playback, GivesTheRunThatItsTorquesCameFrom) {
  const Scenario scenario = Scenario::published();
  const SimulationResult run = simulate(scenario, ControllerDesign{});
  std::vector<TorquePair<double>> torques;
  for (Eigen::Index k = 0; k < run.table.rows(); ++k) {
    torques.push_back({run.table(k, column_tau_left), run.table(k, column_tau_right)});
  }
  const SimulationResult again = play(scenario, torques);
  EXPECT_EQ(again.metrics.cost, run.metrics.cost);
  EXPECT_TRUE(
      (again.table.leftCols<column_tau_fb_left>() == run.table.leftCols<column_tau_fb_left>())
          .all());
}

// What would run over the loop's arrays is refused.
TEST(Simulate, RefusesWhatIsOutOfRange) {
  const Scenario good = Scenario::published();
  const ControllerDesign design;
  EXPECT_EQ(simulate(good, design).status, Status::ok);
  const auto expect = [&](Status status, const Scenario& scenario, const ControllerDesign& given) {
    const SimulationResult result = simulate(scenario, given);
    EXPECT_EQ(result.status, status);
    EXPECT_EQ(result.table.rows(), 0);
    EXPECT_TRUE(std::isinf(result.metrics.cost));
  };
  Scenario scenario = good;
  scenario.delay = maximum_delay + 1;
  expect(Status::out_of_range, scenario, design);
  scenario = good;
  scenario.disturbance.resize(2);
  expect(Status::wrong_size, scenario, design);
  scenario = good;
  scenario.torque_limit = -1;
  expect(Status::out_of_range, scenario, design);
  scenario = good;
  scenario.robot.mass = 0;
  expect(Status::out_of_range, scenario, design);
  ControllerDesign other;
  other.gains[1][1] = std::nan("");
  EXPECT_NE(simulate(good, other).status, Status::ok);
  other = design;
  other.taps = {1, 2, 3};
  expect(Status::wrong_size, good, other);
  other.memory = 5000;
  other.taps.clear();
  other.alpha[0] = 1.5;
  expect(Status::inconsistent, good, other);
  other = design;
  other.taps.assign(21, std::numeric_limits<double>::infinity());
  expect(Status::not_finite, good, other);
}

}  // namespace
}  // namespace nfopidn::test
