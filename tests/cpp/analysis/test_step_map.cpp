// The loop as a map: against the simulation, its Jacobian against finite differences, its periods.
#include "nfopidn/analysis/floquet.hpp"
#include "nfopidn/tuning/structures.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

// Everything that the map's state has: delay, incremental form, reversing, two laps a period.
Scenario delayed_scenario() {
  Scenario scenario = short_scenario();
  scenario.delay = 2;
  scenario.viscous_friction = 0.01;
  scenario.disturbance = {{0.3, -0.02}};
  return scenario;
}

PeriodicReference period_of(const Scenario& scenario, bool in_world_frame = false) {
  PeriodicReference reference;
  EXPECT_EQ(find_period(scenario, in_world_frame, reference).message, "");
  return reference;
}

std::string refusal(const Scenario& scenario) {
  PeriodicReference reference;
  return find_period(scenario, false, reference).message;
}

Scenario on(const TrajectorySettings& settings) {
  Scenario scenario;
  scenario.trajectory = make(settings);
  return scenario;
}

TEST(StepMap, RunsAsTheSimulationDoes) {
  for (const Form form : {Form::positional, Form::incremental}) {
    const Scenario scenario = delayed_scenario();
    const ControllerDesign design = steady_settings(form);
    const SimulationResult simulated = simulate(scenario, design);
    const RunTable& table = simulated.table;
    ASSERT_GT(table.rows(), 100);

    const PreparedRun run = prepare(scenario);
    const PeriodicReference reference = {run.reference, 100, 1};
    StepMap<double> map(run, design, reference);
    Eigen::VectorXd z = Eigen::VectorXd::Zero(map.size());
    Eigen::VectorXd next(map.size());
    for (int k = 0; k < reference.period; ++k) {
      // The table's errors are in the robot's frame, the map's in the reference's.
      const double c = std::cos(table(k, column_e_theta));
      const double s = std::sin(table(k, column_e_theta));
      const double expected[] = {c * table(k, column_e_x) + s * table(k, column_e_y),
                                 c * table(k, column_e_y) - s * table(k, column_e_x),
                                 table(k, column_e_theta), table(k, column_v),
                                 table(k, column_omega)};
      for (int i = 0; i < 5; ++i) {
        if (k == 0) z(i) = expected[i];
        ASSERT_TRUE(near(z(i), expected[i], 1e-9)) << k << ", " << i;
      }
      map.advance(k, z.data(), next.data());
      z = next;
    }
  }
}

TEST(StepMap, JacobianIsThatOfFiniteDifferences) {
  for (const Form form : {Form::positional, Form::incremental}) {
    const Scenario scenario = delayed_scenario();
    const ControllerDesign design = steady_settings(form);
    const PeriodicReference reference = period_of(scenario);
    const PreparedRun run = prepare(scenario);
    StepMap<double> map(run, design, reference);
    StepMap<Dual<double>> dual(run, design, reference);
    Draws draw(7);
    for (const int k : {0, 50, 120, 299}) {
      Eigen::VectorXd z(map.size());
      for (double& number : z) number = draw.between(-0.5, 0.5);
      Eigen::MatrixXd jacobian;
      step_jacobian(dual, k, z.data(), jacobian);
      constexpr double step = 1e-6;
      Eigen::VectorXd more(map.size());
      Eigen::VectorXd less(map.size());
      for (Eigen::Index j = 0; j < z.size(); ++j) {
        Eigen::VectorXd moved = z;
        moved(j) += step;
        map.advance(k, moved.data(), more.data());
        moved(j) -= 2 * step;
        map.advance(k, moved.data(), less.data());
        const Eigen::VectorXd slope = (more - less) / (2 * step);
        ASSERT_LT((jacobian.col(j) - slope).cwiseAbs().maxCoeff(), 1e-8) << k << ", " << j;
      }
    }
  }
}

TEST(StepMap, RunsLongMemoryAsModesAsTheSimulationDoes) {
  const Scenario scenario = delayed_scenario();
  for (const Generator generator : {Generator::tustin, Generator::gl}) {
    ControllerDesign design = steady_settings(Form::positional);
    design.generator = generator;
    design.memory = infinite_memory;
    const RunTable table = simulate(scenario, design).table;
    const PreparedRun run = prepare(scenario);
    ASSERT_GT(table.rows(), 100);
    const PeriodicReference reference = {run.reference, static_cast<int>(table.rows()) - 1, 1};
    StepMap<double> map(run, design, reference);
    EXPECT_LE(map.size(), most_loop_states);
    Eigen::VectorXd z = Eigen::VectorXd::Zero(map.size());
    Eigen::VectorXd next(map.size());
    for (int k = 0; k < reference.period; ++k) {
      if (k == 0) {
        const double c = std::cos(table(0, column_e_theta));
        const double s = std::sin(table(0, column_e_theta));
        z.head(5) << c * table(0, column_e_x) + s * table(0, column_e_y),
            c * table(0, column_e_y) - s * table(0, column_e_x), table(0, column_e_theta),
            table(0, column_v), table(0, column_omega);
      }
      ASSERT_NEAR(z(3), table(k, column_v), 1e-4) << k;
      ASSERT_NEAR(z(4), table(k, column_omega), 1e-4) << k;
      map.advance(k, z.data(), next.data());
      z = next;
    }
  }
}

TEST(StepMap, HasTheStatesThatItsDocumentationNames) {
  const Scenario scenario = delayed_scenario();
  for (const Form form : {Form::positional, Form::incremental}) {
    const PreparedRun run = prepare(scenario);
    const PeriodicReference reference = period_of(scenario);
    StepMap<double> map(run, steady_settings(form), reference);
    EXPECT_EQ(map.size(), 5 + 3 * 6 + (form == Form::incremental ? 2 : 0) + 2 * 2);
  }
  ControllerDesign design;
  design.memory = 64;
  EXPECT_TRUE(check_loop(Scenario::published(), design));
  design.memory = 65;
  EXPECT_TRUE(check_loop(Scenario::published(), design));  // as modes
  design.alpha[1] = 1.5;                                   // which has none
  EXPECT_EQ(check_loop(Scenario::published(), design).message,
            "number of states (memory 65, delay 0) is 203; must be in [1, 200]");
  Scenario pushed = Scenario::published();
  pushed.disturbance.assign(751, {0.1, 0});
  EXPECT_EQ(check_loop(pushed, ControllerDesign{}).message,
            "disturbance is one pair a sample; must be constant");
}

TEST(PeriodicReference, IsTheLapOrTwoOrOneSample) {
  TrajectorySettings settings;
  PeriodicReference lap = period_of(on(settings));
  EXPECT_EQ(lap.period, 750);
  EXPECT_EQ(lap.laps, 1);
  settings.heading = HeadingChoice::continuous;
  EXPECT_EQ(period_of(on(settings)).laps, 2);
  settings.cusps = 2;  // turns 4 pi a lap
  EXPECT_EQ(period_of(on(settings)).laps, 1);
  for (const Curve curve : {Curve::line, Curve::circle}) {
    TrajectorySettings steady;
    steady.name = curve;
    steady.period = 150.1;  // no whole number of samples, and none is needed
    EXPECT_EQ(period_of(on(steady)).period, 1);
    EXPECT_EQ(period_of(on(steady)).laps, 0);
  }
  TrajectorySettings circle;
  circle.name = Curve::circle;
  EXPECT_EQ(period_of(on(circle), true).period, 750) << "in the world's frame it is not steady";
  circle.name = Curve::line;
  EXPECT_EQ(period_of(on(circle), true).period, 1);
}

// Central differences everywhere: the first sample of the period is like those of the second lap.
TEST(PeriodicReference, HasNoOneSidedDifferences) {
  TrajectorySettings settings;
  settings.laps = 3;
  const Scenario scenario = on(settings);
  const PreparedRun run = prepare(scenario);
  const PeriodicReference reference = period_of(scenario);
  for (std::size_t k = 0; k <= 750; ++k) {
    const ReferenceSample<double>& own = reference.samples[k];
    const ReferenceSample<double>& middle = run.reference[k + 750];
    ASSERT_TRUE(near(own.v, middle.v, 1e-12)) << k;
    ASSERT_TRUE(near(own.omega, middle.omega, 1e-9)) << k;
    ASSERT_TRUE(near(own.tau_left, middle.tau_left, 1e-9)) << k;
    ASSERT_TRUE(near(std::remainder(own.theta - middle.theta, 2 * math<double>::pi), 0, 1e-9)) << k;
  }
}

TEST(PeriodicReference, OfSamplesNeedsAClosedPath) {
  const int count = 200;
  Eigen::ArrayXd x(count + 1);
  Eigen::ArrayXd y(count + 1);
  for (int k = 0; k <= count; ++k) {
    x(k) = std::cos(2 * M_PI * k / count);
    y(k) = 0.5 * std::sin(2 * M_PI * k / count);
  }
  TrajectorySettings settings;
  settings.dt = 0.1;
  Scenario scenario;
  ASSERT_EQ(make_trajectory(x, y, settings, scenario.trajectory), Status::ok);
  EXPECT_EQ(period_of(scenario).period, count);
  settings.laps = 3;
  ASSERT_EQ(make_trajectory(x, y, settings, scenario.trajectory), Status::ok);
  EXPECT_EQ(period_of(scenario).period, count);
  settings.laps = 1;
  ASSERT_EQ(make_trajectory(x.head(count), y.head(count), settings, scenario.trajectory),
            Status::ok);
  EXPECT_NE(refusal(scenario).find("distance of the trajectory's ends is 0.0"), std::string::npos);
  EXPECT_NE(refusal(scenario).find("must be in [0, 1e-06] m: a periodic path"), std::string::npos);
}

TEST(PeriodicReference, NeedsAWholeNumberOfSamples) {
  TrajectorySettings settings;
  settings.period = 150.1;
  EXPECT_NE(refusal(on(settings)).find("trajectory.period is 150.1 s, 750."), std::string::npos);
  EXPECT_NE(refusal(on(settings)).find("must be a whole number of samples"), std::string::npos);
  settings.period = 2000.2;
  EXPECT_EQ(refusal(on(settings)),
            "trajectory.period / dt is 10001; must be in [1, 10000] samples");
}

}  // namespace
}  // namespace nfopidn::test
