// Sampled trajectories of the named paths: headings, derivatives, laps, the reverse flag.
#include "nfopidn/simulation/trajectory.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

TrajectorySettings settings_of(Curve curve, HeadingChoice heading, Derivatives derivatives) {
  TrajectorySettings settings;
  settings.name = curve;
  settings.heading = heading;
  settings.derivatives = derivatives;
  settings.period = 30;
  settings.dt = 0.05;
  return settings;
}

constexpr HeadingChoice both_headings[] = {HeadingChoice::forward, HeadingChoice::continuous};
constexpr Derivatives both_derivatives[] = {Derivatives::sampled, Derivatives::analytic};
constexpr int curve_count = static_cast<int>(Curve::samples);

double largest(const Eigen::ArrayXd& values) { return values.abs().maxCoeff(); }

// To the nearest whole turn.
Eigen::ArrayXd turned(const Eigen::ArrayXd& angle) {
  return angle - 2 * M_PI * (angle / (2 * M_PI)).round();
}

TEST(Gradient, IsCentralWithOneSidedEnds) {
  Eigen::ArrayXd samples(5);
  samples << 1, 4, 2, 7, 7.5;
  const Eigen::ArrayXd slope = gradient(samples, 0.5);
  Eigen::ArrayXd expected(5);
  expected << 6, 1, 3, 5.5, 1;
  EXPECT_EQ(largest(slope - expected), 0);
  const Eigen::ArrayXd shortest = gradient(samples.head(3), 0.5);
  EXPECT_EQ(shortest(0), 6);
  EXPECT_EQ(shortest(1), 1);
  EXPECT_EQ(shortest(2), -4);
}

TEST(Unwrap, RemovesJumpsOfMoreThanHalfATurn) {
  Eigen::ArrayXd angle(7);
  angle << 3, -3, 3, 2, -2, 0, 1;
  unwrap(angle);
  Eigen::ArrayXd expected(7);
  expected << 3, -3 + 2 * M_PI, 3, 2, -2 + 2 * M_PI, 2 * M_PI, 1 + 2 * M_PI;
  EXPECT_LT(largest(angle - expected), 1e-14);
  angle << 0, 1, 3, 4.5, 6, 6.5, 0.5;
  const Eigen::ArrayXd half = angle;
  unwrap(angle, M_PI);
  Eigen::ArrayXd steps = angle.tail(6) - angle.head(6);
  EXPECT_LE(largest(steps), M_PI / 2);
  EXPECT_LT(largest(((angle - half) / M_PI) - ((angle - half) / M_PI).round()), 1e-14);
}

TEST(Unwrap, RemovesSeveralTurnsAtOnce) {
  Eigen::ArrayXd angle(3);
  angle << 0, 6 * M_PI + 0.5, -4 * M_PI + 1;
  unwrap(angle);
  EXPECT_NEAR(angle(1), 0.5, 1e-14);
  EXPECT_NEAR(angle(2), 1, 1e-14);
}

TEST(NamedTrajectory, SamplesThePathAtItsTimes) {
  for (int curve = 0; curve < curve_count; ++curve) {
    auto settings =
        settings_of(static_cast<Curve>(curve), HeadingChoice::continuous, Derivatives::analytic);
    settings.scale = 0.7;
    settings.laps = 2;
    const Trajectory t = make(settings);
    ASSERT_EQ(t.size(), 1201);
    EXPECT_EQ(t.dt(), 0.05);
    for (const Eigen::Index k : {0, 1, 17, 599, 600, 601, 1200}) {
      const double rate = 2 * M_PI / 30;
      const auto p = path_point(settings.name, 3, rate * 0.05 * static_cast<double>(k), rate);
      EXPECT_NEAR(t.x(k), 0.7 * p.x, 1e-12) << k;
      EXPECT_NEAR(t.y(k), 0.7 * p.y, 1e-12) << k;
      EXPECT_NEAR(std::sin(t.theta(k) - p.theta), 0, 1e-12) << k;
      EXPECT_NEAR(std::cos(t.theta(k) - p.theta), 1, 1e-12) << k;
      EXPECT_NEAR(t.v(k), 0.7 * p.v, 1e-12) << k;
      EXPECT_NEAR(t.omega(k), p.omega, 1e-12) << k;
      EXPECT_NEAR(t.acceleration(k), 0.7 * p.acceleration, 1e-12) << k;
      EXPECT_NEAR(t.turn_acceleration(k), p.turn_acceleration, 1e-12) << k;
    }
    EXPECT_LT(largest(t.theta.tail(1200) - t.theta.head(1200)), 1) << "unwrapped";
  }
}

// Every reading of a path is a motion along it: dx = v cos(theta) dt, whatever heading and signs.
TEST(NamedTrajectory, EveryReadingMovesAlongThePath) {
  for (int curve = 0; curve < curve_count; ++curve) {
    for (const HeadingChoice heading : both_headings) {
      for (const Derivatives derivatives : both_derivatives) {
        auto settings = settings_of(static_cast<Curve>(curve), heading, derivatives);
        settings.dt = 0.01;
        const Trajectory t = make(settings);
        const Eigen::ArrayXd dx = gradient(t.x, 0.01) - t.v * t.theta.cos();
        const Eigen::ArrayXd dy = gradient(t.y, 0.01) - t.v * t.theta.sin();
        const Eigen::Index inside = t.size() - 2;
        EXPECT_LT(largest(dx.segment(1, inside)), 1e-3) << curve;
        EXPECT_LT(largest(dy.segment(1, inside)), 1e-3) << curve;
        EXPECT_LT(largest(gradient(t.v, 0.01) - t.acceleration),
                  derivatives == Derivatives::sampled ? 1e-12 : 1.2)
            << curve;
      }
    }
  }
}

TEST(NamedTrajectory, SampledDerivativesAreDifferencesOfTheSamples) {
  const Trajectory t =
      make(settings_of(Curve::eight, HeadingChoice::forward, Derivatives::sampled));
  const Eigen::ArrayXd dx = gradient(t.x, 0.05);
  const Eigen::ArrayXd dy = gradient(t.y, 0.05);
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    ASSERT_NEAR(t.v(k), std::hypot(dx(k), dy(k)), 1e-15);
    ASSERT_NEAR(std::remainder(t.theta(k) - std::atan2(dy(k), dx(k)), 2 * M_PI), 0, 1e-13);
  }
  EXPECT_EQ(largest(t.omega - gradient(t.theta, 0.05)), 0);
  EXPECT_EQ(largest(t.acceleration - gradient(t.v, 0.05)), 0);
  EXPECT_EQ(largest(t.turn_acceleration - gradient(t.omega, 0.05)), 0);
  EXPECT_LT(largest(t.theta.tail(600) - t.theta.head(600)), 0.5);
}

// With continuous heading V_r and W_r are closed forms; `derivatives` decides their rates only.
TEST(NamedTrajectory, ContinuousHeadingKeepsTheClosedForms) {
  const Trajectory sampled =
      make(settings_of(Curve::ranunculoid, HeadingChoice::continuous, Derivatives::sampled));
  const Trajectory analytic =
      make(settings_of(Curve::ranunculoid, HeadingChoice::continuous, Derivatives::analytic));
  const double rate = 2 * M_PI / 30;
  for (Eigen::Index k = 0; k < sampled.size(); ++k) {
    const double phase = rate * 0.05 * static_cast<double>(k);
    ASSERT_NEAR(sampled.theta(k), 2.5 * phase, 1e-12);
    ASSERT_NEAR(sampled.v(k), 8 * rate * std::sin(1.5 * phase), 1e-12);
    ASSERT_NEAR(sampled.omega(k), 2.5 * rate, 1e-12);
    ASSERT_NEAR(analytic.acceleration(k), 12 * rate * rate * std::cos(1.5 * phase), 1e-12);
  }
  EXPECT_EQ(largest(sampled.v - analytic.v), 0);
  EXPECT_EQ(largest(sampled.theta - analytic.theta), 0);
  EXPECT_EQ(largest(sampled.acceleration - gradient(sampled.v, 0.05)), 0);
  EXPECT_GT(largest(sampled.acceleration - analytic.acceleration), 1e-6);
  const Trajectory eight =
      make(settings_of(Curve::eight, HeadingChoice::continuous, Derivatives::sampled));
  EXPECT_EQ(largest(eight.turn_acceleration - gradient(eight.omega, 0.05)), 0);
}

// eq. 44
TEST(NamedTrajectory, ForwardHeadingIsTheDirectionOfMotion) {
  for (const int laps : {1, 2}) {
    auto settings =
        settings_of(Curve::ranunculoid, HeadingChoice::continuous, Derivatives::analytic);
    settings.laps = laps;
    const Trajectory continuous = make(settings);
    settings.heading = HeadingChoice::forward;
    const Trajectory forward = make(settings);
    int half_turns = 0;
    for (Eigen::Index k = 0; k < forward.size(); ++k) {
      ASSERT_GE(forward.v(k), 0);
      ASSERT_NEAR(forward.v(k), std::fabs(continuous.v(k)), 1e-15);
      const double sign = continuous.v(k) < 0 ? -1 : 1;
      if (std::fabs(continuous.v(k)) > 1e-9) {
        ASSERT_NEAR(forward.acceleration(k), sign * continuous.acceleration(k), 1e-14) << k;
        ASSERT_NEAR(std::cos(forward.theta(k) - continuous.theta(k)), sign, 1e-12) << k;
      }
      ASSERT_EQ(forward.reverse[static_cast<std::size_t>(k)], 0);
      if (k > 0) {
        const double step = forward.theta(k) - forward.theta(k - 1);
        half_turns += std::fabs(step) > 3 ? 1 : 0;
        ASSERT_LT(step, 0.1) << "each cusp takes half a turn back";
      }
    }
    EXPECT_EQ(half_turns, 3 * laps - 1);
    EXPECT_EQ(largest(forward.omega - continuous.omega), 0);
  }
}

// Where no cusp is near, differences and closed forms of the forward heading agree.
TEST(NamedTrajectory, SampledAndAnalyticForwardHeadingsAgree) {
  for (int curve = 0; curve < curve_count; ++curve) {
    auto settings =
        settings_of(static_cast<Curve>(curve), HeadingChoice::forward, Derivatives::sampled);
    const Trajectory sampled = make(settings);
    settings.derivatives = Derivatives::analytic;
    const Trajectory analytic = make(settings);
    const Eigen::ArrayXd apart = turned(sampled.theta - analytic.theta);
    int compared = 0;
    for (Eigen::Index k = 1; k + 1 < sampled.size(); ++k) {
      if (analytic.v(k) < 0.1) continue;
      ++compared;
      ASSERT_NEAR(apart(k), 0, 0.02) << curve << " at " << k;
      ASSERT_NEAR(sampled.v(k), analytic.v(k), 0.01) << curve << " at " << k;
    }
    EXPECT_GT(compared, 400) << curve;
  }
}

TEST(NamedTrajectory, ReverseFlagFollowsTheSpeedsSignAndKeepsItAtRest) {
  Trajectory t;
  t.x.resize(8);
  t.v.resize(8);
  t.v << 0, 0.5, -0.9e-9, -1e-9, 0.9e-9, 0, -0.5, 1e-9;
  detail::mark_reverse(t);
  EXPECT_EQ(t.reverse, (std::vector<unsigned char>{0, 0, 0, 1, 1, 1, 1, 0}));

  const Trajectory continuous =
      make(settings_of(Curve::ranunculoid, HeadingChoice::continuous, Derivatives::sampled));
  for (Eigen::Index k = 0; k < continuous.size(); ++k) {
    if (std::fabs(continuous.v(k)) < 1e-9) continue;
    ASSERT_EQ(continuous.reverse[static_cast<std::size_t>(k)], continuous.v(k) < 0 ? 1 : 0) << k;
  }
}

TEST(NamedTrajectory, CountsItsSamples) {
  TrajectorySettings settings;
  EXPECT_EQ(sample_count(settings), 751);
  EXPECT_EQ(make(settings).size(), 751);
  EXPECT_NEAR(make(settings).peak_speed(), 0.335, 5e-4);
  settings.period = 0.3;
  settings.dt = 0.1;  // a hair less than three of them
  EXPECT_EQ(sample_count(settings), 4);
  settings.period = 1;
  settings.laps = 3;
  EXPECT_EQ(sample_count(settings), 31);
  settings.dt = 0.3;
  EXPECT_EQ(sample_count(settings), 11);
  settings.dt = 0.29;
  EXPECT_EQ(sample_count(settings), 11);
}

TEST(NamedTrajectory, RefusesBadSettingsAndLeavesTheResult) {
  Trajectory result = make(TrajectorySettings{});
  const auto refuse = [&](Status status, auto change) {
    TrajectorySettings settings;
    change(settings);
    EXPECT_EQ(make_trajectory(settings, result), status);
    EXPECT_EQ(result.size(), 751);
  };
  using S = TrajectorySettings;
  refuse(Status::out_of_range, [](S& s) { s.dt = 0; });
  refuse(Status::out_of_range, [](S& s) { s.dt = -0.2; });
  refuse(Status::not_finite, [](S& s) { s.dt = not_a_number<double>; });
  refuse(Status::not_finite, [](S& s) { s.period = infinite<double>; });
  refuse(Status::out_of_range, [](S& s) { s.period = 0; });
  refuse(Status::out_of_range, [](S& s) { s.scale = 0; });
  refuse(Status::out_of_range, [](S& s) { s.laps = 0; });
  refuse(Status::out_of_range, [](S& s) { s.cusps = 0; });
  refuse(Status::not_a_choice, [](S& s) { s.name = Curve::samples; });
  refuse(Status::wrong_size, [](S& s) { s.dt = 100; });
  refuse(Status::wrong_size, [](S& s) { s.dt = 1.4e-5; });  // 10.7 million samples
}

}  // namespace
}  // namespace nfopidn::test
