// What stands between the law and a real robot.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "nfopidn/hardware.hpp"
#include "nfopidn/plant.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class Hardware : public ::testing::Test {};
using Scalars = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Hardware, Scalars);

template <class Scalar>
constexpr Scalar close = sizeof(Scalar) == 8 ? Scalar(1e-12) : Scalar(2e-5);

TYPED_TEST(Hardware, OdometryClosesACircleInAnyNumberOfSteps) {
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

TYPED_TEST(Hardware, OdometryDrivesStraightAndTurnsOnTheSpot) {
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

TYPED_TEST(Hardware, CountersMayWrapAround) {
  const TypeParam metres = rolled<TypeParam, std::uint16_t>(65530, 4, 100, TypeParam(0.05));
  EXPECT_NEAR(metres, 10 * 2 * math<TypeParam>::pi * TypeParam(0.05) / 100, close<TypeParam>);
  const TypeParam back = rolled<TypeParam, std::uint16_t>(4, 65530, 100, TypeParam(0.05));
  EXPECT_EQ(back, -metres);
}

// In the paper's sign a greater left torque turns counter-clockwise; a real robot's right wheel
// does.
TYPED_TEST(Hardware, TheWheelsChangePlaces) {
  const auto real = to_rep103(TorquePair<TypeParam>{2, 1});
  EXPECT_EQ(real.left, 1);
  EXPECT_EQ(real.right, 2);
  const Acceleration<TypeParam> acceleration((Robot<TypeParam>()));
  EXPECT_GT(acceleration.angular(TorquePair<TypeParam>{2, 1}, {0, 0}), 0);
}

template <class Scalar>
struct Rig {
  Controller<Scalar, Fir<Scalar, 7>> law;
  Controller<Scalar, Fir<Scalar, 7>> plain;
  ReferenceSample<Scalar> reference = {};

  Rig() {
    reference.tau_left = Scalar(0.1);
    EXPECT_EQ(law.configure({}), Status::ok);
    EXPECT_EQ(plain.configure({}), Status::ok);
  }
};

TYPED_TEST(Hardware, BadMeasurementsAreHeldThenStoppedAndNeverRemembered) {
  const TypeParam nan = std::numeric_limits<TypeParam>::quiet_NaN();
  const TypeParam infinite = std::numeric_limits<TypeParam>::infinity();
  Rig<TypeParam> rig;
  Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 2);
  const Measurement<TypeParam> good = {TypeParam(0.2), TypeParam(-0.1), TypeParam(0.05), 0, 0};
  const auto first = guarded.step(good, rig.reference);
  EXPECT_EQ(first.left, rig.plain.step(good, rig.reference).left);
  EXPECT_EQ(guarded.fault(), Fault::none);
  for (Measurement<TypeParam> bad :
       {Measurement<TypeParam>{nan, 0, 0, 0, 0}, Measurement<TypeParam>{0, 0, -infinite, 0, 0}}) {
    EXPECT_EQ(guarded.step(bad, rig.reference).left, first.left);
    EXPECT_EQ(guarded.fault(), Fault::held);
  }
  // A good one within the time goes on where the law was.
  EXPECT_EQ(guarded.step(good, rig.reference).left, rig.plain.step(good, rig.reference).left);
  const Measurement<TypeParam> bad = {0, infinite, 0, 0, 0};
  guarded.step(bad, rig.reference);
  guarded.step(bad, rig.reference);
  const auto none = guarded.step(bad, rig.reference);
  EXPECT_EQ(none.left, 0);
  EXPECT_EQ(none.right, 0);
  EXPECT_EQ(guarded.fault(), Fault::stopped);
  // Afresh.
  rig.plain.reset();
  EXPECT_EQ(guarded.step(good, rig.reference).left, rig.plain.step(good, rig.reference).left);
  EXPECT_EQ(guarded.fault(), Fault::none);
  EXPECT_TRUE(std::isfinite(guarded.step(good, rig.reference).right));
}

// Finite, and yet their errors are beyond every float, in the law's memory as well.
TYPED_TEST(Hardware, NumbersBeyondAllMeasureAreBadInTheReferenceToo) {
  const Measurement<TypeParam> good = {TypeParam(0.2), TypeParam(-0.1), TypeParam(0.05), 0, 0};
  using M = Measurement<TypeParam>;
  using R = ReferenceSample<TypeParam>;
  Rig<TypeParam> rig;
  Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 1);
  const auto try_bad = [&](const M& measured, const R& reference, const char* what) {
    guarded.step(measured, reference);
    EXPECT_EQ(guarded.fault(), Fault::held) << what;
    EXPECT_EQ(guarded.step(good, rig.reference).left, rig.plain.step(good, rig.reference).left)
        << what;
    EXPECT_EQ(guarded.fault(), Fault::none) << what;
  };
  for (const TypeParam bad : {std::numeric_limits<TypeParam>::quiet_NaN(),
                              std::numeric_limits<TypeParam>::max(), TypeParam(-1.001e6)}) {
    for (const auto& [member, what] :
         {std::pair{&M::x, "measured x"}, {&M::y, "measured y"}, {&M::theta, "measured theta"}}) {
      M measured = good;
      measured.*member = bad;
      try_bad(measured, rig.reference, what);
    }
    for (const auto& [member, what] : {std::pair{&R::x, "x"},
                                       {&R::y, "y"},
                                       {&R::theta, "theta"},
                                       {&R::v, "v"},
                                       {&R::tau_left, "tau_left"},
                                       {&R::tau_right, "tau_right"}}) {
      R reference = rig.reference;
      reference.*member = bad;
      try_bad(good, reference, what);
    }
  }
  guarded.step({TypeParam(1e6), TypeParam(-1e6), TypeParam(1e6), 0, 0}, rig.reference);
  EXPECT_EQ(guarded.fault(), Fault::none);
}

}  // namespace
}  // namespace nfopidn::test
