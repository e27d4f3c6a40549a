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
