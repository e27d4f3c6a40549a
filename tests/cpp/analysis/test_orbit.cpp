// Orbits, multipliers and verdicts, against the simulated loop.
#include "nfopidn/analysis/floquet.hpp"
#include "nfopidn/tuning/structures.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

LoopStability analysed(const Scenario& scenario, const ControllerDesign& design) {
  LoopStability result;
  EXPECT_EQ(analyse_loop(scenario, design, result).message, "");
  return result;
}

Scenario published(const TrajectorySettings& settings) {
  Scenario scenario = Scenario::published();
  scenario.trajectory = make(settings);
  return scenario;
}

// The growth a period of a small deviation that is made small again after each sample: the largest
// multiplier's modulus, by differences of the simulated loop alone.
double simulated_log_radius(const Scenario& scenario, const ControllerDesign& design,
                            const LoopStability& found, int periods) {
  const PreparedRun run = prepare(scenario);
  StepMap<double> map(run, design, found.reference);
  Eigen::VectorXd deviation = Eigen::VectorXd::Ones(map.size()).normalized();
  Eigen::VectorXd more(map.size());
  Eigen::VectorXd less(map.size());
  double growth = 0;
  for (int i = 0; i < periods; ++i) {
    if (i == periods / 3) growth = 0;
    for (int k = 0; k < map.period(); ++k) {
      constexpr double small = 1e-6;
      const Eigen::VectorXd up = found.orbit.states.col(k) + small * deviation;
      const Eigen::VectorXd down = found.orbit.states.col(k) - small * deviation;
      map.advance(k, up.data(), more.data());
      map.advance(k, down.data(), less.data());
      deviation = (more - less) / (2 * small);
      growth += std::log(deviation.norm());
      deviation.normalize();
    }
  }
  return growth / (periods - periods / 3);
}

TEST(Orbit, PublishedGainsAreStableOnThePublishedScenario) {
  const LoopStability found = analysed(Scenario::published(), {});
  EXPECT_EQ(found.verdict, Verdict::stable);
  EXPECT_TRUE(near(std::exp(found.log_radius), 0.0911, 1e-4));
  EXPECT_TRUE(
      near(found.log_radius, simulated_log_radius(Scenario::published(), {}, found, 12), 1e-3));
}

TEST(Orbit, PublishedGainsAreUnstableOnTheLapOf25Seconds) {
  TrajectorySettings settings;
  settings.period = 25;
  const Scenario scenario = published(settings);
  const LoopStability found = analysed(scenario, {});
  EXPECT_EQ(found.verdict, Verdict::unstable);
  EXPECT_TRUE(near(found.log_radius, simulated_log_radius(scenario, {}, found, 30), 1e-3));
  EXPECT_TRUE(simulate(scenario, {}).diverged);
}

TEST(Orbit, PublishedGainsAreUnstableInIncrementalForm) {
  ControllerDesign design;
  design.form = Form::incremental;
  const LoopStability found = analysed(Scenario::published(), design);
  EXPECT_EQ(found.verdict, Verdict::unstable);
  EXPECT_TRUE(near(found.log_radius, 170.671, 1e-2));
  // Its largest multipliers are a pair: the growth of one period depends on the phase.
  EXPECT_TRUE(
      near(found.log_radius, simulated_log_radius(Scenario::published(), design, found, 60), 0.05));
  EXPECT_TRUE(simulate(Scenario::published(), design).diverged);
}

TEST(Orbit, TunedGainsAreStable) {
  const LoopStability found = analysed(Scenario::published(), tuned_nominal());
  EXPECT_EQ(found.verdict, Verdict::stable);
  EXPECT_LT(std::exp(found.log_radius), 1e-3);
}

// Too far from the reference for Newton's method, but where a long run settles.
TEST(Orbit, IsFoundWhereARunSettles) {
  ControllerDesign design;
  const double gains[3][3] = {{3.7, 1.5, 0.7}, {0.2, 0.3, 1.4}, {3.3, 2.5, 1.2}};
  for (int channel = 0; channel < channel_count; ++channel) {
    std::copy_n(gains[channel], 3, design.gains[channel]);
    design.alpha[channel] = 0.5;
    design.sigma[channel] = 0.8;
  }
  TrajectorySettings settings;
  settings.period = 40;
  const Scenario scenario = published(settings);
  const LoopStability found = analysed(scenario, design);
  EXPECT_EQ(found.orbit.start, OrbitStart::simulation);
  EXPECT_EQ(found.verdict, Verdict::stable);
  EXPECT_TRUE(near(found.log_radius, simulated_log_radius(scenario, design, found, 12), 1e-2));
}

TEST(Orbit, WithoutAnOrbitSaysSo) {
  ControllerDesign design;
  design.frame = Frame::world;
  TrajectorySettings settings;
  settings.period = 60;
  settings.dt = 1;
  Scenario scenario;
  scenario.trajectory = make(settings);
  const LoopStability found = analysed(scenario, design);
  EXPECT_EQ(found.verdict, Verdict::no_orbit);
  EXPECT_EQ(found.multipliers.size(), 0);
  EXPECT_TRUE(simulate(scenario, design).diverged);
}

// The map takes every state of the orbit to the next, and the last to the first.
TEST(Orbit, ClosesInOnePeriod) {
  Scenario scenario = short_scenario();
  scenario.delay = 1;
  const ControllerDesign design = steady_settings(Form::positional);
  const LoopStability found = analysed(scenario, design);
  ASSERT_TRUE(found.orbit.found);
  const PreparedRun run = prepare(scenario);
  StepMap<double> map(run, design, found.reference);
  Eigen::VectorXd z = found.orbit.states.col(0);
  Eigen::VectorXd next(z.size());
  for (int k = 0; k < map.period(); ++k) {
    ASSERT_LT((z - found.orbit.states.col(k)).cwiseAbs().maxCoeff(), 1e-8) << k;
    map.advance(k, z.data(), next.data());
    z = next;
  }
  EXPECT_LT((z - found.orbit.states.col(0)).cwiseAbs().maxCoeff(), 1e-8);
}

// On a line with its error at zero: the robot's masses are two integrators a direction, and the
// loop of the drive is known in closed form.
TEST(Orbit, EigenvaluesOnALineAreThoseOfTheDriveAndSteeringLoops) {
  TrajectorySettings settings;
  settings.name = Curve::line;
  const Scenario scenario = published(settings);
  ControllerDesign design;
  design.memory = 0;
  design.allocation = Allocation<double>::decoupled();
  const LoopStability found = analysed(scenario, design);
  ASSERT_EQ(found.reference.period, 1);
  // With a slope of 1/2 and both wheels a channel's net is the sum, or difference, of the torques.
  const auto law = [&](int channel, std::complex<double> z) {
    double taps[2] = {};
    double work[2] = {};
    const double* const g = design.gains[channel];
    fuse_taps(design.generator, g[0], g[1], g[2], design.alpha[channel], design.sigma[channel], 0,
              taps, work);
    return taps[0] * z + taps[1];
  };
  const double sample = 0.2;
  const double drive = sample * sample / (11.5 * 0.076);
  const double steer = sample * sample * 0.452 / (2 * 0.5873 * 0.076);
  const double speed = 6.0 / 150;
  for (const auto& z : found.multipliers) {
    const std::complex<double> square = (z - 1.0) * (z - 1.0);
    const std::complex<double> driving = z * (square + drive * law(0, z));
    const std::complex<double> turning =
        z * (square * (z - 1.0) + steer * (law(2, z) * (z - 1.0) + sample * speed * law(1, z)));
    EXPECT_LT(std::min(std::abs(driving), std::abs(turning)), 1e-9) << z;
  }
}

TEST(Orbit, TellsHowNearItsSwitchesItPasses) {
  Scenario scenario = Scenario::published();
  LoopStability found = analysed(scenario, {});
  const Switches free = found.switches;
  // At a cusp the reference turns by pi within two samples, and the feedforward the robot with it.
  EXPECT_TRUE(near(free.heading_wrap.distance, 2.57, 1e-3));
  const double error = std::fabs(found.orbit.states(2, free.heading_wrap.sample));
  EXPECT_TRUE(near(free.heading_wrap.distance, math<double>::pi - error, 1e-12));
  EXPECT_EQ(free.limited_samples, 0);
  const double peak = scenario.torque_limit - free.torque_right.distance;
  scenario.torque_limit = peak - 0.2;
  found = analysed(scenario, {});
  EXPECT_GT(found.switches.limited_samples, 0);
  EXPECT_LT(found.switches.torque_right.distance, 0.2);
}

TEST(Orbit, MultipliersBeyondEveryDoubleKeepTheirLogarithm) {
  TrajectorySettings settings;
  settings.period = 330;
  settings.heading = HeadingChoice::continuous;
  ControllerDesign design;
  design.form = Form::incremental;
  const LoopStability found = analysed(published(settings), design);
  ASSERT_EQ(found.verdict, Verdict::unstable);
  EXPECT_GT(found.log_radius, std::log(std::numeric_limits<double>::max()));
  EXPECT_TRUE(std::isfinite(found.log_radius));
}

}  // namespace
}  // namespace nfopidn::test
