// Wheels and encoders of a real robot.
#include <gtest/gtest.h>

#include <cstdint>
#include <limits>

#include "nfopidn/firmware/odometry.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class Odometry : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Odometry, Scalars);

template <class Scalar>
constexpr Scalar close = sizeof(Scalar) == 8 ? Scalar(1e-12) : Scalar(2e-5);

TYPED_TEST(Odometry, ClosesACircleInAnyNumberOfSteps) {
  const TypeParam pi = math<TypeParam>::pi;
  for (const int steps : {1, 3, 7, 100, 5000}) {
    const TypeParam radius = 2, track = TypeParam(0.4);
    State<TypeParam> state = {1, -2, TypeParam(0.3), 0, 0};
    for (int i = 0; i < steps; ++i) {
      const TypeParam angle = 2 * pi / static_cast<TypeParam>(steps);
      state = odometry(state, angle * (radius - track / 2), angle * (radius + track / 2), track);
    }
    const TypeParam slack = close<TypeParam> * static_cast<TypeParam>(steps);
    EXPECT_NEAR(state.x, 1, slack) << steps;
    EXPECT_NEAR(state.y, -2, slack) << steps;
    EXPECT_NEAR(state.theta, TypeParam(0.3), slack) << steps;
  }
}

TYPED_TEST(Odometry, DrivesStraightAndTurnsOnTheSpot) {
  const State<TypeParam> start = {0, 0, 0, 0, 0};
  EXPECT_EQ(odometry(start, TypeParam(3), TypeParam(3), TypeParam(0.5)).x, TypeParam(3));
  const auto turned = odometry(start, TypeParam(-0.25), TypeParam(0.25), TypeParam(0.5));
  EXPECT_EQ(turned.x, 0);
  EXPECT_NEAR(turned.theta, 1, close<TypeParam>);
  // A quarter of a circle to the left, radius 1: to (1, 1).
  const TypeParam quarter = math<TypeParam>::pi / 2;
  const auto arc =
      odometry(start, quarter * TypeParam(0.75), quarter * TypeParam(1.25), TypeParam(0.5));
  EXPECT_NEAR(arc.x, 1, close<TypeParam>);
  EXPECT_NEAR(arc.y, 1, close<TypeParam>);
}

// A counter that jumps would move the robot by a hundred metres.
TYPED_TEST(Odometry, AStepThatNoWheelCanMakeIsRefused) {
  constexpr TypeParam longest = TypeParam(0.25);
  const State<TypeParam> start = {1, 2, TypeParam(0.5), 0, 0};
  const TypeParam jump = rolled<TypeParam, std::uint16_t>(0, 32767, 144, TypeParam(0.076));
  const TypeParam nan = std::numeric_limits<TypeParam>::quiet_NaN();
  for (const TypeParam bad : {jump, -jump, longest * TypeParam(1.001), nan}) {
    for (const bool right : {false, true}) {
      State<TypeParam> state = start;
      const TypeParam good = TypeParam(0.1);
      EXPECT_FALSE(
          try_odometry(state, right ? good : bad, right ? bad : good, TypeParam(0.4), longest));
      EXPECT_EQ(state.x, start.x);
      EXPECT_EQ(state.y, start.y);
      EXPECT_EQ(state.theta, start.theta);
    }
  }
  State<TypeParam> state = start;
  // No step is too long then, but one without end leads nowhere.
  const TypeParam endless = std::numeric_limits<TypeParam>::infinity();
  EXPECT_FALSE(try_odometry(state, endless, TypeParam(0.1), TypeParam(0.4), endless));
  EXPECT_FALSE(try_odometry(state, TypeParam(0.1), -endless, TypeParam(0.4), endless));
  EXPECT_FALSE(try_odometry(state, TypeParam(0.1), TypeParam(0.1), TypeParam(0.4), nan));
  EXPECT_EQ(state.x, start.x);
  EXPECT_TRUE(try_odometry(state, longest, -longest, TypeParam(0.4), longest));
  EXPECT_EQ(state.theta, odometry(start, longest, -longest, TypeParam(0.4)).theta);
  EXPECT_NE(state.theta, start.theta);
}

TYPED_TEST(Odometry, CountersMayWrapAround) {
  const TypeParam metres = rolled<TypeParam, std::uint16_t>(65530, 4, 100, TypeParam(0.05));
  EXPECT_NEAR(metres, 10 * 2 * math<TypeParam>::pi * TypeParam(0.05) / 100, close<TypeParam>);
  const TypeParam back = rolled<TypeParam, std::uint16_t>(4, 65530, 100, TypeParam(0.05));
  EXPECT_EQ(back, -metres);
}

// In the paper's sign a greater left torque turns counter-clockwise; a real robot's right wheel
// does.
TYPED_TEST(Odometry, TheWheelsChangePlaces) {
  const auto real = to_rep103(TorquePair<TypeParam>{2, 1});
  EXPECT_EQ(real.left, 1);
  EXPECT_EQ(real.right, 2);
  const Acceleration<TypeParam> acceleration((Robot<TypeParam>()));
  EXPECT_GT(acceleration.angular(TorquePair<TypeParam>{2, 1}, {0, 0}), 0);
}

}  // namespace
}  // namespace nfopidn::test
