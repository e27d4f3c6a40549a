// The published scenario against an independent implementation's figures.
#include <nlohmann/json.hpp>

#include "support.hpp"

namespace nfopidn::test {
namespace {

nlohmann::json golden_costs() {
  std::ifstream in(NFOPIDN_GOLDEN "/costs.json");
  return nlohmann::json::parse(in);
}

TEST(PublishedRun, EqualsTheGoldenTable) {
  const CsvTable golden = read_golden_csv("published_run.csv");
  const SimulationResult result = simulate(Scenario::published(), {});
  ASSERT_EQ(golden.names.size(), static_cast<std::size_t>(column_count));
  ASSERT_EQ(golden.rows.size(), 751U);
  ASSERT_EQ(result.table.rows(), 751);
  for (int column = 0; column < column_count; ++column) {
    EXPECT_EQ(golden.names[static_cast<std::size_t>(column)], column_names[column]);
    for (Eigen::Index k = 0; k < 751; ++k) {
      ASSERT_NEAR(result.table(k, column),
                  golden.rows[static_cast<std::size_t>(k)][static_cast<std::size_t>(column)], 1e-9)
          << column_names[column] << ", sample " << k;
    }
  }
  EXPECT_FALSE(result.diverged);
}

TEST(PublishedRun, CostsOfEveryMemory) {
  const auto costs = golden_costs().at("E_by_memory");
  ASSERT_EQ(costs.size(), 8U);
  for (int memory = 1; memory <= 8; ++memory) {
    ControllerSettings<double> settings;
    settings.memory = memory;
    EXPECT_NEAR(simulate(Scenario::published(), settings).metrics.cost,
                costs.at(std::to_string(memory)).get<double>(), 1e-9)
        << "memory " << memory;
  }
}

TEST(PublishedRun, PeaksAndPoseError) {
  const auto golden = golden_costs();
  const SimulationResult result = simulate(Scenario::published(), {});
  const auto peak = [&](int column) { return result.table.col(column).abs().maxCoeff(); };
  EXPECT_NEAR(result.metrics.cost, golden.at("E_published_M5").get<double>(), 1e-9);
  EXPECT_NEAR(result.metrics.pose_mse, golden.at("pose_mse_published_M5").get<double>(), 1e-9);
  EXPECT_NEAR(peak(column_v), golden.at("peak").at("abs_v").get<double>(), 1e-9);
  EXPECT_NEAR(peak(column_omega), golden.at("peak").at("abs_omega").get<double>(), 1e-9);
  EXPECT_NEAR(result.metrics.torque_peak, golden.at("peak").at("abs_tau").get<double>(), 1e-9);
  EXPECT_NEAR(Scenario::published().trajectory.peak_speed(),
              golden.at("peak").at("v_ref").get<double>(), 1e-9);
}

TEST(PublishedRun, ContinuousHeadingNeedsTheDirectionOfTheReference) {
  Scenario scenario = Scenario::published();
  TrajectorySettings settings;
  settings.heading = HeadingChoice::continuous;
  scenario.trajectory = make(settings);
  ControllerSettings<double> controller;
  EXPECT_NEAR(simulate(scenario, controller).metrics.cost, 0.082229, 5e-7);
  controller.lateral = Lateral::plain;
  EXPECT_TRUE(simulate(scenario, controller).diverged);
}

TEST(PublishedRun, DivergesWhereTheDesignSaysSo) {
  ControllerSettings<double> world;
  world.frame = Frame::world;
  EXPECT_TRUE(simulate(Scenario::published(), world).diverged);
  ControllerSettings<double> incremental;
  incremental.form = Form::incremental;
  EXPECT_TRUE(simulate(Scenario::published(), incremental).diverged);
  Scenario short_lap = Scenario::published();
  TrajectorySettings settings;
  settings.period = 25;
  short_lap.trajectory = make(settings);
  EXPECT_TRUE(simulate(short_lap, {}).diverged);
}

// Without feedback a reference that the robot can follow exactly is followed exactly.
TEST(FeedforwardAlone, HoldsALineAndACircle) {
  for (const Curve curve : {Curve::line, Curve::circle}) {
    for (const HeadingChoice heading : {HeadingChoice::forward, HeadingChoice::continuous}) {
      TrajectorySettings settings;
      settings.name = curve;
      settings.period = 40;
      settings.heading = heading;
      settings.derivatives = Derivatives::analytic;
      Scenario scenario;
      scenario.trajectory = make(settings);
      scenario.initial_velocity.reference = true;
      scenario.integrator = Integrator::exact;
      ControllerSettings<double> silent;
      for (auto& gains : silent.gains) gains[0] = gains[1] = gains[2] = 0;
      const SimulationResult result = simulate(scenario, silent);
      EXPECT_LT(result.metrics.position_max, 1e-10);
      EXPECT_LT(result.metrics.heading_rms, 1e-10);
      EXPECT_GT(result.table.col(column_v).minCoeff(), 0.1);
    }
  }
}

// Where the path accelerates, torques held over a sample follow it ever more closely.
TEST(FeedforwardAlone, FollowsAnEightBetterWithShorterSamples) {
  const auto error = [](double dt) {
    TrajectorySettings settings;
    settings.name = Curve::eight;
    settings.period = 40;
    settings.dt = dt;
    settings.derivatives = Derivatives::analytic;
    Scenario scenario;
    scenario.trajectory = make(settings);
    scenario.initial_velocity.reference = true;
    scenario.integrator = Integrator::exact;
    ControllerSettings<double> silent;
    for (auto& gains : silent.gains) gains[0] = gains[1] = gains[2] = 0;
    return simulate(scenario, silent).metrics.position_max;
  };
  const double coarse = error(0.1);
  EXPECT_LT(coarse, 0.3);
  EXPECT_LT(error(0.05), 0.6 * coarse);
}

}  // namespace
}  // namespace nfopidn::test
