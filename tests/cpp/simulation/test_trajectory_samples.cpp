// Trajectories through given positions.
#include "support.hpp"

namespace nfopidn::test {
namespace {

// Positions of one lap of the epicycloid, with its three cusps between samples or on them.
TrajectorySettings lap_settings() {
  TrajectorySettings settings;
  settings.period = 30;
  settings.dt = 0.1;
  return settings;
}

Status from_samples(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y,
                    const TrajectorySettings& settings, Trajectory& result) {
  return make_trajectory(x, y, settings, result);
}

// Out along a ray and back, twice as many samples as `half` and one, at rest where it turns round.
void out_and_back(double direction, int half, Eigen::ArrayXd& x, Eigen::ArrayXd& y) {
  x.resize(2 * half + 1);
  y.resize(2 * half + 1);
  for (int k = 0; k <= 2 * half; ++k) {
    const double way = 0.01 * (k <= half ? k : 2 * half - k);
    x(k) = way * std::cos(direction);
    y(k) = way * std::sin(direction);
  }
}

TEST(SampledTrajectory, ForwardEqualsTheNamedPath) {
  const Trajectory named = make(lap_settings());
  Trajectory t;
  ASSERT_EQ(from_samples(named.x, named.y, lap_settings(), t), Status::ok);
  EXPECT_EQ(t.settings.name, Curve::samples);
  EXPECT_EQ(t.settings.dt, 0.1);
  EXPECT_NEAR(t.settings.period, 30, 1e-12);
  EXPECT_TRUE((t.x == named.x).all() && (t.y == named.y).all());
  EXPECT_TRUE((t.theta == named.theta).all());
  EXPECT_TRUE((t.v == named.v).all() && (t.omega == named.omega).all());
  EXPECT_TRUE((t.acceleration == named.acceleration).all());
  EXPECT_TRUE((t.turn_acceleration == named.turn_acceleration).all());
  EXPECT_EQ(t.reverse, named.reverse);
}

void expect_reversing_at_cusps(double dt) {
  auto settings = lap_settings();
  settings.dt = dt;
  const Trajectory named = make(settings);
  settings.heading = HeadingChoice::continuous;
  Trajectory t;
  ASSERT_EQ(from_samples(named.x, named.y, settings, t), Status::ok);
  const Eigen::Index n = t.size();
  EXPECT_LT((t.theta.tail(n - 1) - t.theta.head(n - 1)).abs().maxCoeff(), 0.3);
  for (Eigen::Index k = 1; k + 1 < n; ++k) {
    const double phase = 2 * M_PI * dt * static_cast<double>(k) / 30;
    if (std::fabs(std::sin(1.5 * phase)) < 0.1) continue;  // the differences blur the cusp
    ASSERT_NEAR(t.theta(k), 2.5 * phase, 0.02) << k;
    ASSERT_NEAR(t.v(k), 16 * M_PI / 30 * std::sin(1.5 * phase), 0.02) << k;
    ASSERT_EQ(t.reverse[static_cast<std::size_t>(k)], std::sin(1.5 * phase) < 0 ? 1 : 0) << k;
  }
}

TEST(SampledTrajectory, ContinuousHeadingReversesAtCuspsBetweenSamples) {
  expect_reversing_at_cusps(0.0703);
}

// The difference across a cusp runs square to the path: 50 s is a sample of the published path.
TEST(SampledTrajectory, ContinuousHeadingReversesAtCuspsOnSamples) {
  expect_reversing_at_cusps(0.1);
}

TEST(SampledTrajectory, ForwardHeadingTurnsRoundAtACusp) {
  Eigen::ArrayXd x;
  Eigen::ArrayXd y;
  out_and_back(0, 20, x, y);
  Trajectory t;
  ASSERT_EQ(from_samples(x, y, lap_settings(), t), Status::ok);
  EXPECT_NEAR(t.theta(5), 0, 1e-12);
  EXPECT_NEAR(std::cos(t.theta(35)), -1, 1e-12);
  EXPECT_NEAR(t.v(5), 0.1, 1e-12);
  EXPECT_NEAR(t.v(35), 0.1, 1e-12);
  EXPECT_EQ(t.reverse[35], 0);
}

// At the turning point the difference of the positions is zero and says nothing of the heading.
TEST(SampledTrajectory, ContinuousHeadingHoldsWhereTheSamplesTurnRound) {
  for (const double direction : {0.0, 0.3, M_PI / 4, M_PI / 2, 2.0, -2.5}) {
    Eigen::ArrayXd x;
    Eigen::ArrayXd y;
    out_and_back(direction, 20, x, y);
    auto settings = lap_settings();
    settings.heading = HeadingChoice::continuous;
    Trajectory t;
    ASSERT_EQ(from_samples(x, y, settings, t), Status::ok);
    EXPECT_LT((t.theta - t.theta(0)).abs().maxCoeff(), 1e-9) << direction;
    EXPECT_LT(t.omega.abs().maxCoeff(), 1e-7) << direction;
    EXPECT_NEAR(t.v(5), 0.1, 1e-12) << direction;
    EXPECT_NEAR(t.v(35), -0.1, 1e-12) << direction;
    EXPECT_EQ(t.reverse[5], 0) << direction;
    EXPECT_EQ(t.reverse[35], 1) << direction;
  }
}

// A robot that waits on its way keeps its heading.
TEST(SampledTrajectory, HeadingHoldsWhereTheSamplesStandStill) {
  for (const HeadingChoice heading : {HeadingChoice::forward, HeadingChoice::continuous}) {
    Eigen::ArrayXd x(30);
    for (int k = 0; k < 30; ++k) x(k) = 0.01 * (k < 10 ? k : (k < 20 ? 10 : k - 10));
    auto settings = lap_settings();
    settings.heading = heading;
    Trajectory t;
    ASSERT_EQ(from_samples(x, x, settings, t), Status::ok);
    EXPECT_LT((t.theta - M_PI / 4).abs().maxCoeff(), 1e-9);
    EXPECT_EQ(t.v(15), 0);
  }
}

// At rest for 10 s, then off in one direction and at 0.3 m/s; positions are as `given` has them.
template <class Given>
Samples departure(double dt, const Given& given) {
  const int count = static_cast<int>(40 / dt);
  Samples samples;
  samples.x.resize(count);
  samples.y.resize(count);
  for (int k = 0; k < count; ++k) {
    const double t = std::max(0.0, k * dt - 10);
    const double way = t < 5 ? 0.03 * t * t : 0.75 + 0.3 * (t - 5);
    samples.x(k) = given(way * std::cos(0.7));
    samples.y(k) = given(way * std::sin(0.7));
  }
  return samples;
}

double turned(const Trajectory& t) { return t.theta.maxCoeff() - t.theta.minCoeff(); }

// Noise at rest is no motion: without a threshold these headings span 19 to 96 rad.
TEST(SampledTrajectory, NoiseAtAStandstillDoesNotTurnTheReference) {
  for (const double dt : {0.2, 0.02}) {
    for (const double noise : {1e-9, 1e-7, 1e-5}) {
      Random random(1);
      const Samples samples = departure(dt, [&](double p) { return p + noise * random.normal(); });
      auto settings = lap_settings();
      settings.dt = dt;
      Trajectory t;
      ASSERT_EQ(make_trajectory(samples, settings, t), Status::ok);
      EXPECT_LT(turned(t), 0.3) << dt << " " << noise;
      ASSERT_EQ(t.notes.size(), 1U);
      EXPECT_NE(t.notes[0].find("the heading holds at "), std::string::npos);
      // Held samples move along no heading, so that the speed has no bias.
      EXPECT_LT(std::fabs(t.v.head(static_cast<Eigen::Index>(9 / dt)).mean()), noise / dt);
      settings.standstill_speed = 0;
      ASSERT_EQ(make_trajectory(samples, settings, t), Status::ok);
      EXPECT_GT(turned(t), 6) << dt << " " << noise;
      EXPECT_TRUE(t.notes.empty());
    }
  }
}

// Positions of three digits move off in steps of a millimetre along either axis.
TEST(SampledTrajectory, CreepingOffInWholeDigitsDoesNotTurnTheReference) {
  Samples samples;
  const Eigen::ArrayXd way = 4e-6 * Eigen::ArrayXd::LinSpaced(150, 0, 149).cube();
  samples.x = (1e3 * std::cos(0.7) * way).round() / 1e3;
  samples.y = (1e3 * std::sin(0.7) * way).round() / 1e3;
  auto settings = lap_settings();
  settings.dt = 0.2;
  Trajectory t;
  ASSERT_EQ(make_trajectory(samples, settings, t), Status::ok);
  EXPECT_LT(turned(t), 0.3);
  settings.standstill_speed = 0;
  ASSERT_EQ(make_trajectory(samples, settings, t), Status::ok);
  EXPECT_GT(turned(t), 0.7);
}

// Without noise or rounding nothing is held but what stands still, and nothing is said.
TEST(SampledTrajectory, ExactPositionsHaveNoThreshold) {
  const Samples samples = departure(0.02, [](double p) { return p; });
  EXPECT_EQ(detail::standstill_speed(samples, 0.02), 1e-9);
  for (const double dt : {0.1, 0.0703}) {
    auto settings = lap_settings();
    settings.dt = dt;
    const Trajectory named = make(settings);
    EXPECT_EQ(detail::standstill_speed({named.x, named.y, {}, {}}, dt), 1e-9);
  }
}

// A robot that backs off, and one that goes forwards the same way with its heading given.
TEST(SampledTrajectory, DirectionAndHeadingMayBeGiven) {
  Samples samples;
  samples.x = -0.1 * Eigen::ArrayXd::LinSpaced(9, 0, 8);
  samples.y = Eigen::ArrayXd::Zero(9);
  samples.reverse.assign(9, 1);
  auto settings = lap_settings();
  Trajectory t;
  const auto backs_off = [&] {
    EXPECT_LT((t.theta / (2 * M_PI) - (t.theta / (2 * M_PI)).round()).abs().maxCoeff(), 1e-12);
    EXPECT_LT((t.v + 1).abs().maxCoeff(), 1e-12);
    EXPECT_EQ(t.reverse, std::vector<unsigned char>(9, 1));
  };
  ASSERT_EQ(make_trajectory(samples, settings, t), Status::ok);
  backs_off();
  samples.reverse.clear();
  samples.theta = Eigen::ArrayXd::Zero(9);
  ASSERT_EQ(make_trajectory(samples, settings, t), Status::ok);
  backs_off();
  samples.reverse.assign(9, 0);
  EXPECT_EQ(make_trajectory(samples, settings, t), Status::not_a_choice);
  samples.reverse.assign(8, 1);
  EXPECT_EQ(make_trajectory(samples, settings, t), Status::wrong_size);
  samples.reverse.clear();
  samples.theta.conservativeResize(8);
  EXPECT_EQ(make_trajectory(samples, settings, t), Status::wrong_size);
}

// Turning on the spot is in the headings alone.
TEST(SampledTrajectory, AGivenHeadingTurnsOnTheSpot) {
  Samples samples;
  samples.x = Eigen::ArrayXd::Zero(50);
  samples.y = Eigen::ArrayXd::Zero(50);
  samples.theta = Eigen::ArrayXd::LinSpaced(50, 0, 4.9);
  for (double& angle : samples.theta) angle = math<double>::wrap(angle);
  Trajectory t;
  ASSERT_EQ(make_trajectory(samples, lap_settings(), t), Status::ok);
  EXPECT_LT((t.omega - 1).abs().maxCoeff(), 1e-12);
  EXPECT_EQ(t.v.abs().maxCoeff(), 0);
}

TEST(SampledTrajectory, WhatWasTakenOffThePositionsIsKept) {
  Samples samples;
  samples.x = Eigen::ArrayXd::LinSpaced(5, 0, 4);
  samples.y = Eigen::ArrayXd::Zero(5);
  Trajectory t;
  ASSERT_EQ(make_trajectory(samples, lap_settings(), t), Status::ok);
  EXPECT_EQ(t.origin, (std::array<double, 2>{0, 0}));
  const Eigen::ArrayXd x = t.x;
  samples.origin = {5e6, -1e6};
  ASSERT_EQ(make_trajectory(samples, lap_settings(), t), Status::ok);
  EXPECT_EQ(t.origin, samples.origin);
  EXPECT_TRUE((t.x == x).all());
}

TEST(SampledTrajectory, APathIsClosedOnce) {
  Samples samples;
  samples.x.resize(4);
  samples.y.resize(4);
  samples.x << 0, 1, 1, 0;
  samples.y << 0, 0, 1, 1;
  samples.reverse.assign(4, 0);
  close_path(samples);
  ASSERT_EQ(samples.x.size(), 5);
  EXPECT_EQ(samples.x(4), 0);
  EXPECT_EQ(samples.y(4), 0);
  EXPECT_EQ(samples.reverse.size(), 5U);
  EXPECT_EQ(samples.theta.size(), 0);
  close_path(samples);
  EXPECT_EQ(samples.x.size(), 5);
}

TEST(SampledTrajectory, LapsOfAClosedPathContinue) {
  auto settings = lap_settings();
  const Trajectory lap = make(settings);
  settings.laps = 3;
  const Trajectory named = make(settings);
  Trajectory t;
  ASSERT_EQ(from_samples(lap.x, lap.y, settings, t), Status::ok);
  ASSERT_EQ(t.size(), 3 * 300 + 1);
  EXPECT_EQ(t.settings.laps, 3);
  EXPECT_NEAR(t.settings.period, 30, 1e-12);
  EXPECT_LT((t.x - named.x).abs().maxCoeff(), 1e-12);
  EXPECT_LT((t.y - named.y).abs().maxCoeff(), 1e-12);
  EXPECT_LT((t.v - named.v).abs().maxCoeff(), 1e-10);
  // The seam between laps is like any other place: the same differences a lap later.
  for (Eigen::Index k = 290; k < 310; ++k) EXPECT_NEAR(t.v(k), t.v(k + 300), 1e-10) << k;
}

TEST(SampledTrajectory, RefusesBadSamplesAndLeavesTheResult) {
  const Trajectory lap = make(lap_settings());
  Trajectory result = lap;
  const auto refuse = [&](Status status, const Eigen::ArrayXd& x, const Eigen::ArrayXd& y,
                          const TrajectorySettings& settings) {
    EXPECT_EQ(from_samples(x, y, settings, result), status);
    EXPECT_EQ(result.size(), lap.size());
    EXPECT_EQ(result.settings.name, Curve::ranunculoid);
  };
  auto settings = lap_settings();
  refuse(Status::wrong_size, lap.x.head(2), lap.y.head(2), settings);
  refuse(Status::wrong_size, lap.x, lap.y.head(9), settings);
  refuse(Status::wrong_size, {}, {}, settings);
  for (const double bad : {not_a_number<double>, infinite<double>}) {
    Eigen::ArrayXd broken = lap.x;
    broken(7) = bad;
    refuse(Status::not_finite, broken, lap.y, settings);
    refuse(Status::not_finite, lap.x, broken, settings);
  }
  settings.laps = 2;  // twice along half a lap does not join
  refuse(Status::inconsistent, lap.x.head(150), lap.y.head(150), settings);
  settings.laps = 0;
  refuse(Status::out_of_range, lap.x, lap.y, settings);
  settings.laps = 40'000;  // 12 million samples
  refuse(Status::wrong_size, lap.x, lap.y, settings);
  settings = lap_settings();
  for (const double dt : {0.0, -0.1}) {
    settings.dt = dt;
    refuse(Status::out_of_range, lap.x, lap.y, settings);
  }
  settings.dt = not_a_number<double>;
  refuse(Status::not_finite, lap.x, lap.y, settings);
}

TEST(SampledTrajectory, ThreeSamplesAreEnough) {
  Eigen::ArrayXd x(3);
  x << 0, 1, 3;
  Trajectory t;
  ASSERT_EQ(from_samples(x, Eigen::ArrayXd::Zero(3), lap_settings(), t), Status::ok);
  EXPECT_NEAR(t.v(0), 10, 1e-12);
  EXPECT_NEAR(t.v(1), 15, 1e-12);
  EXPECT_NEAR(t.v(2), 20, 1e-12);
  EXPECT_NEAR(t.acceleration(1), 50, 1e-11);
}

TEST(SampledTrajectory, EndsMayLieAHairApart) {
  auto settings = lap_settings();
  Trajectory lap = make(settings);
  settings.laps = 2;
  Trajectory result;
  lap.x(lap.size() - 1) += 0.5e-6;
  EXPECT_EQ(from_samples(lap.x, lap.y, settings, result), Status::ok);
  lap.x(lap.size() - 1) += 2e-6;
  EXPECT_EQ(from_samples(lap.x, lap.y, settings, result), Status::inconsistent);
}

}  // namespace
}  // namespace nfopidn::test
