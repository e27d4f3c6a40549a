// The named paths: their shapes, and their closed forms against differences of high order.
#include "nfopidn/simulation/curves.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

constexpr Curve named_curves[] = {Curve::ranunculoid,   Curve::circle, Curve::lemniscate,
                                  Curve::eight,         Curve::line,   Curve::sine,
                                  Curve::rounded_square};

std::string name_of(Curve curve) {
  return ChoiceNames<Curve>::names[static_cast<std::size_t>(curve)];
}

// Eighth-order central difference of a member of the path point.
double difference(Curve curve, int cusps, double phase, double rate, double PathPoint::*member) {
  constexpr double weights[] = {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280};
  const double step = 4e-3;  // of phase
  const auto at = [&](double p) { return path_point(curve, cusps, p, rate).*member; };
  double sum = 0;
  for (int i = 1; i <= 4; ++i) {
    double change = at(phase + i * step) - at(phase - i * step);
    if (member == &PathPoint::theta) change -= 2 * M_PI * std::round(change / (2 * M_PI));
    sum += weights[i - 1] * change;
  }
  return sum * rate / step;
}

// Where the rounded square's turning rate jumps no difference is worth anything.
bool near_a_corner(Curve curve, double phase) {
  if (curve != Curve::rounded_square) return false;
  const double length = 8 + 2 * M_PI;
  const double along = std::fmod(phase / (2 * M_PI) * length + 1, length / 4);
  const double margin = 0.04;
  return std::min({along, std::fabs(along - 2), length / 4 - along}) < margin;
}

// eqs. 7 and 8
TEST(Curves, ClosedFormsAreTheDerivativesOfThePositions) {
  for (const Curve curve : named_curves) {
    for (const int cusps : {1, 3, 5}) {
      if (cusps != 3 && curve != Curve::ranunculoid) continue;
      const double rate = 0.7;
      int tried = 0;
      for (double phase = -0.013; phase < 4 * M_PI; phase += 0.0611) {
        if (near_a_corner(curve, phase)) continue;
        ++tried;
        const PathPoint p = path_point(curve, cusps, phase, rate);
        const auto slope = [&](double PathPoint::*member) {
          return difference(curve, cusps, phase, rate, member);
        };
        const std::string what = name_of(curve) + " at " + std::to_string(phase);
        ASSERT_NEAR(slope(&PathPoint::x), p.v * std::cos(p.theta), 1e-11) << what;
        ASSERT_NEAR(slope(&PathPoint::y), p.v * std::sin(p.theta), 1e-11) << what;
        ASSERT_NEAR(slope(&PathPoint::theta), p.omega, 1e-11) << what;
        ASSERT_NEAR(slope(&PathPoint::v), p.acceleration, 1e-11) << what;
        ASSERT_NEAR(slope(&PathPoint::omega), p.turn_acceleration, 1e-11) << what;
      }
      EXPECT_GT(tried, 100);
    }
  }
}

TEST(Curves, HaveTheirShapes) {
  for (double phase = 0; phase < 2 * M_PI; phase += 0.013) {
    const auto at = [&](Curve curve) { return path_point(curve, 3, phase, 1); };
    const PathPoint epicycloid = at(Curve::ranunculoid);
    ASSERT_NEAR(epicycloid.x, 4 * std::cos(phase) - std::cos(4 * phase), 1e-14);
    ASSERT_NEAR(epicycloid.y, 4 * std::sin(phase) - std::sin(4 * phase), 1e-14);
    const PathPoint five = path_point(Curve::ranunculoid, 5, phase, 1);
    ASSERT_NEAR(five.x, 6 * std::cos(phase) - std::cos(6 * phase), 1e-14);
    ASSERT_NEAR(five.y, 6 * std::sin(phase) - std::sin(6 * phase), 1e-14);
    const PathPoint circle = at(Curve::circle);
    ASSERT_NEAR(std::hypot(circle.x, circle.y), 2, 1e-14);
    ASSERT_NEAR(std::atan2(circle.y, circle.x), std::remainder(phase, 2 * M_PI), 1e-14);
    const PathPoint bernoulli = at(Curve::lemniscate);
    const double square = bernoulli.x * bernoulli.x + bernoulli.y * bernoulli.y;
    ASSERT_NEAR(square * square, 4 * (bernoulli.x * bernoulli.x - bernoulli.y * bernoulli.y),
                1e-13);
    const PathPoint gerono = at(Curve::eight);
    ASSERT_NEAR(4 * gerono.y * gerono.y, gerono.x * gerono.x * (4 - gerono.x * gerono.x), 1e-13);
    const PathPoint line = at(Curve::line);
    ASSERT_NEAR(line.x, 6 * phase / (2 * M_PI), 1e-14);
    ASSERT_EQ(line.y, 0);
    const PathPoint sine = at(Curve::sine);
    ASSERT_NEAR(sine.x, 6 * phase / (2 * M_PI), 1e-14);
    ASSERT_NEAR(sine.y, std::sin(phase), 1e-14);
    const PathPoint square_path = at(Curve::rounded_square);
    const double outside_x = std::max(std::fabs(square_path.x) - 1, 0.0);
    const double outside_y = std::max(std::fabs(square_path.y) - 1, 0.0);
    ASSERT_NEAR(std::hypot(outside_x, outside_y), 1, 1e-14);
  }
}

TEST(Curves, ReachTheirExtents) {
  const auto extent = [](Curve curve) {
    std::array<double, 2> most = {0, 0};
    for (double phase = 0; phase < 2 * M_PI; phase += 0.001) {
      const PathPoint p = path_point(curve, 3, phase, 1);
      most = {std::max(most[0], std::fabs(p.x)), std::max(most[1], std::fabs(p.y))};
    }
    return most;
  };
  EXPECT_NEAR(extent(Curve::lemniscate)[0], 2, 1e-5);
  EXPECT_NEAR(extent(Curve::lemniscate)[1], std::sqrt(0.5), 1e-5);
  EXPECT_NEAR(extent(Curve::eight)[0], 2, 1e-5);
  EXPECT_NEAR(extent(Curve::eight)[1], 1, 1e-5);
  EXPECT_NEAR(extent(Curve::rounded_square)[0], 2, 1e-14);
  EXPECT_NEAR(extent(Curve::rounded_square)[1], 2, 1e-14);
}

TEST(Curves, ClosedPathsCloseAndTheOthersGoOn) {
  for (const Curve curve : named_curves) {
    for (const double phase : {0.0, 0.3, 2.0}) {
      const PathPoint first = path_point(curve, 3, phase, 1);
      const PathPoint next_lap = path_point(curve, 3, phase + 4 * M_PI, 1);
      const bool open = curve == Curve::line || curve == Curve::sine;
      EXPECT_NEAR(next_lap.x - first.x, open ? 12 : 0, 1e-13) << name_of(curve);
      EXPECT_NEAR(next_lap.y - first.y, 0, 1e-13) << name_of(curve);
      // Whole or half turns: after an odd number of cusps the robot drives the other way round.
      EXPECT_NEAR(std::sin(next_lap.theta - first.theta), 0, 1e-13) << name_of(curve);
      EXPECT_NEAR(next_lap.omega, first.omega, 1e-13) << name_of(curve);
    }
  }
}

// eqs. 42-43
TEST(Curves, TheRanunculoidsSpeedAndTurning) {
  const double rate = 2 * M_PI / 150;
  for (double phase = 0; phase < 7; phase += 0.1) {
    const PathPoint p = path_point(Curve::ranunculoid, 3, phase, rate);
    EXPECT_NEAR(std::fabs(p.v), 8 * rate * std::fabs(std::sin(1.5 * phase)), 1e-15);
    EXPECT_NEAR(p.theta, 2.5 * phase, 1e-14);
    EXPECT_NEAR(p.omega, 2.5 * rate, 1e-15);
  }
}

TEST(Curves, TheRoundedSquareHasConstantSpeedAlongItsLength) {
  for (double phase = 0; phase < 7; phase += 0.01) {
    const PathPoint p = path_point(Curve::rounded_square, 3, phase, 0.5);
    ASSERT_NEAR(p.v, 0.5 * (8 + 2 * M_PI) / (2 * M_PI), 1e-14);
    ASSERT_TRUE(p.omega == 0 || std::fabs(p.omega - p.v) < 1e-14);  // corners of radius 1
  }
  const PathPoint start = path_point(Curve::rounded_square, 3, 0, 1);
  EXPECT_NEAR(start.x, 0, 1e-14);
  EXPECT_NEAR(start.y, -2, 1e-14);
  EXPECT_NEAR(start.theta, 0, 1e-14);
}

}  // namespace
}  // namespace nfopidn::test
