// Scenarios: their defaults, what is prepared from them, and what is wrong with some.
#include "nfopidn/simulation/prepared_run.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

TEST(Scenarios, PublishedIsThePapers) {
  const Scenario scenario = Scenario::published();
  const TrajectorySettings& path = scenario.trajectory.settings;
  EXPECT_EQ(path.name, Curve::ranunculoid);
  EXPECT_EQ(path.period, 150);
  EXPECT_EQ(path.dt, 0.2);
  EXPECT_EQ(path.cusps, 3);
  EXPECT_EQ(path.heading, HeadingChoice::forward);
  EXPECT_EQ(path.derivatives, Derivatives::sampled);
  EXPECT_EQ(scenario.trajectory.size(), 751);
  EXPECT_EQ(*scenario.initial_pose, (std::array<double, 3>{4, 0, 1.0472}));
  EXPECT_EQ(scenario.initial_velocity.value, (std::array<double, 2>{0, 0}));
  EXPECT_FALSE(scenario.initial_velocity.reference);
  EXPECT_EQ(scenario.torque_limit, 3.078);
  EXPECT_TRUE(scenario.feedforward);
  EXPECT_EQ(scenario.integrator, Integrator::semi_implicit_euler);
  EXPECT_EQ(scenario.substeps, 1);
  EXPECT_EQ(scenario.delay, 0);
  EXPECT_EQ(scenario.divergence_distance, 10);
  EXPECT_EQ(scenario.robot.mass, 11.5);
  EXPECT_EQ(check_consistency(scenario).status, Status::ok);
}

TEST(Scenarios, StartWhereTheySay) {
  Scenario scenario = short_scenario();
  TrajectorySettings settings = scenario.trajectory.settings;
  settings.name = Curve::circle;
  scenario.trajectory = make(settings);
  const Trajectory& t = scenario.trajectory;
  scenario.initial_pose = {1, 2, 3};
  scenario.initial_velocity.value = {0.1, 0.2};
  const State<double> given = prepare(scenario).start;
  EXPECT_TRUE(same_bits(given, State<double>{1, 2, 3, 0.1, 0.2}));
  scenario.initial_pose.reset();
  scenario.initial_velocity.reference = true;
  const State<double> reference = prepare(scenario).start;
  EXPECT_TRUE(same_bits(reference, State<double>{t.x(0), t.y(0), t.theta(0), t.v(0), t.omega(0)}));
  EXPECT_GT(reference.v, 0.1);
}

TEST(Scenarios, ArePreparedForTheLoop) {
  Scenario scenario = short_scenario();
  scenario.delay = 3;
  scenario.feedforward = false;
  scenario.divergence_distance = 7;
  scenario.torque_limit = 1.5;
  scenario.disturbance = {{1, 2}};
  const PreparedRun run = prepare(scenario);
  const Trajectory& t = scenario.trajectory;
  const LoopInputs<double> inputs = run.inputs();
  EXPECT_EQ(inputs.samples, 151);
  EXPECT_EQ(inputs.noise, nullptr);
  EXPECT_EQ(inputs.delay, 3);
  EXPECT_FALSE(inputs.feedforward);
  EXPECT_FALSE(inputs.disturbance_by_sample);
  EXPECT_EQ(inputs.disturbance[0].force, 1);
  EXPECT_EQ(inputs.disturbance[0].moment, 2);
  EXPECT_EQ(inputs.divergence_distance, 7);
  EXPECT_EQ(run.limits.torque, 1.5);
  EXPECT_EQ(run.limits.speed_scale, t.v.abs().maxCoeff());
  bool both[2] = {};
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const ReferenceSample<double>& sample = inputs.reference[k];
    const auto torque = inverse_dynamics(scenario.robot, t.acceleration(k), t.turn_acceleration(k));
    ASSERT_EQ(sample.x, t.x(k));
    ASSERT_EQ(sample.y, t.y(k));
    ASSERT_EQ(sample.theta, t.theta(k));
    ASSERT_EQ(sample.v, t.v(k));
    ASSERT_EQ(sample.omega, t.omega(k));
    ASSERT_EQ(sample.tau_left, torque.left);
    ASSERT_EQ(sample.tau_right, torque.right);
    ASSERT_EQ(sample.reverse, t.reverse[static_cast<std::size_t>(k)] != 0);
    both[sample.reverse ? 1 : 0] = true;
  }
  EXPECT_TRUE(both[0] && both[1]);
}

TEST(Scenarios, ReferenceTorquesAreClippedAtTheirLimit) {
  Scenario scenario = Scenario::published();
  const PreparedRun whole = prepare(scenario);
  scenario.feedforward_limit = 0.25;
  const PreparedRun limited = prepare(scenario);
  int clipped[2] = {};
  for (std::size_t k = 0; k < whole.reference.size(); ++k) {
    const ReferenceSample<double>& before = whole.reference[k];
    const ReferenceSample<double>& after = limited.reference[k];
    ASSERT_EQ(after.tau_left, std::min(std::max(before.tau_left, -0.25), 0.25));
    ASSERT_EQ(after.tau_right, std::min(std::max(before.tau_right, -0.25), 0.25));
    ASSERT_EQ(after.omega, before.omega);
    clipped[0] += after.tau_left == 0.25 || after.tau_right == 0.25 ? 1 : 0;
    clipped[1] += after.tau_left == -0.25 || after.tau_right == -0.25 ? 1 : 0;
  }
  EXPECT_GT(clipped[0], 0);
  EXPECT_GT(clipped[1], 0);
}

// A reference that stands still has no speed to scale by, and the law still takes its settings.
TEST(Scenarios, ARestingReferenceCanBeRun) {
  Scenario scenario;
  TrajectorySettings settings;
  ASSERT_EQ(make_trajectory(Eigen::ArrayXd::Ones(20), Eigen::ArrayXd::Ones(20), settings,
                            scenario.trajectory),
            Status::ok);
  scenario.initial_pose = {0.9, 1, 0};
  auto controller = steady_settings(Form::positional);
  controller.lateral = Lateral::speed;
  const SimulationResult result = simulate(scenario, controller);
  EXPECT_FALSE(result.diverged);
  EXPECT_GT(result.table.col(column_tau_left).abs().maxCoeff(), 0.01);
}

TEST(Consistency, ATrajectoryMustBeThere) {
  const Finding finding = check_consistency(Scenario{});
  EXPECT_EQ(finding.status, Status::wrong_size);
  EXPECT_STREQ(finding.field, "trajectory");
  EXPECT_EQ(finding.value, 0);
  EXPECT_EQ(finding.range.low, minimum_samples);
}

TEST(Consistency, DisturbancesAreOneOrOneASample) {
  Scenario scenario = short_scenario();
  for (const std::size_t count : {0U, 2U, 150U, 152U}) {
    scenario.disturbance.assign(count, {0, 0});
    const Finding finding = check_consistency(scenario);
    EXPECT_EQ(finding.status, Status::wrong_size) << count;
    EXPECT_STREQ(finding.field, "disturbance");
    EXPECT_EQ(finding.value, static_cast<double>(count));
    EXPECT_EQ(finding.range.low, 151);
    EXPECT_EQ(finding.range.high, 151);
  }
  for (const std::size_t count : {1U, 151U}) {
    scenario.disturbance.assign(count, {0, 0});
    EXPECT_EQ(check_consistency(scenario).status, Status::ok) << count;
  }
}

// Paths may lie 1e9 m off, as those in coordinates of a map do, and so may the start.
TEST(Consistency, AStartMayLieAsFarAsPathsMay) {
  Scenario scenario = Scenario::published();
  scenario.trajectory.x += 5e6;
  (*scenario.initial_pose)[0] += 5e6;
  EXPECT_EQ(check_ranges(scenario).status, Status::ok);
  EXPECT_EQ(check_consistency(scenario).status, Status::ok);
  (*scenario.initial_pose)[2] = 1.001e6;
  const Finding finding = check_consistency(scenario);
  EXPECT_EQ(finding.status, Status::out_of_range);
  EXPECT_STREQ(finding.field, "initial_pose");
  EXPECT_EQ(finding.value, 1.001e6);
  (*scenario.initial_pose)[1] = 1.001e9;
  EXPECT_EQ(check_ranges(scenario).status, Status::out_of_range);
}

TEST(Consistency, TheStartIsWithinTheDivergenceDistance) {
  Scenario scenario = short_scenario();
  const Trajectory& t = scenario.trajectory;
  scenario.divergence_distance = 5;
  scenario.initial_pose = {t.x(0) + 3, t.y(0) - 4.001, 0};
  const Finding finding = check_consistency(scenario);
  EXPECT_EQ(finding.status, Status::inconsistent);
  EXPECT_STREQ(finding.field, "initial_pose");
  EXPECT_NEAR(finding.value, std::hypot(3, 4.001), 1e-12);
  EXPECT_EQ(finding.range.high, 5);
  scenario.initial_pose = {t.x(0) + 3, t.y(0) - 3.999, 0};
  EXPECT_EQ(check_consistency(scenario).status, Status::ok);
  scenario.initial_pose.reset();
  scenario.divergence_distance = 1e-3;
  EXPECT_EQ(check_consistency(scenario).status, Status::ok);
}

}  // namespace
}  // namespace nfopidn::test
