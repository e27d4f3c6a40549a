// The reference torques with the friction of the wheels, in both precisions.
#include <gtest/gtest.h>

#include <cmath>

#include "nfopidn/plant/differential_drive.hpp"
#include "nfopidn/plant/feedforward.hpp"

namespace {

using namespace nfopidn;

template <class Base>
class Feedforward : public ::testing::Test {
 protected:
  static constexpr Base tolerance = Base(8) * (sizeof(Base) == 4 ? Base(6e-8) : Base(1.2e-16));
};
using Precisions = ::testing::Types<float, double>;
TYPED_TEST_SUITE(Feedforward, Precisions);

TYPED_TEST(Feedforward, WithoutFrictionItIsTheInverseDynamics) {
  const auto robot = Robot<TypeParam>::eddie();
  const FrictionFeedforward<TypeParam> none = {};
  const auto plain = inverse_dynamics(robot, TypeParam(0.3), TypeParam(-0.7));
  const auto torque = reference_torques(robot, none, TypeParam(0.2), TypeParam(0.1), TypeParam(0.3),
                                        TypeParam(-0.7));
  EXPECT_EQ(torque.left, plain.left);
  EXPECT_EQ(torque.right, plain.right);
}

TYPED_TEST(Feedforward, FrictionOpposesEachWheelAndIsSmoothAtStandstill) {
  constexpr FrictionFeedforward<TypeParam> friction = {TypeParam(0.02), TypeParam(0.15),
                                                       TypeParam(0.4)};
  for (const double speed : {0.0, 1e-3, 0.4, 2.0, 50.0}) {
    const double expected = 0.02 * speed + 0.15 * std::tanh(speed / 0.4);
    const auto given = static_cast<TypeParam>(speed);
    EXPECT_NEAR(friction.torque(given), expected, this->tolerance);
    EXPECT_EQ(friction.torque(-given), -friction.torque(given));
  }
  static_assert(friction.torque(TypeParam(0)) == TypeParam(0));
}

// The plant under these torques moves as the reference asks.
TYPED_TEST(Feedforward, ThePlantThenHasTheAccelerationsThatWereAskedFor) {
  const auto robot = Robot<TypeParam>::eddie();
  const TypeParam viscous = TypeParam(0.02);
  const TypeParam coulomb = TypeParam(0.15);
  const TypeParam step = TypeParam(1) / TypeParam(1024);
  const DifferentialDrive<TypeParam> plant(robot, {viscous, coulomb},
                                           Integrator::semi_implicit_euler, step, 1);
  State<TypeParam> state = {0, 0, 0, TypeParam(0.8), TypeParam(-0.9)};
  const auto torque = reference_torques(robot, {viscous, coulomb, TypeParam(0.05)}, state.v,
                                        state.omega, TypeParam(0.3), TypeParam(-0.7));
  const State<TypeParam> before = state;
  plant.advance(state, math<TypeParam>::heading(state.theta), torque);
  // The viscous part is that of the step's end.
  EXPECT_NEAR((state.v - before.v) / step, 0.3, 1e-3);
  EXPECT_NEAR((state.omega - before.omega) / step, -0.7, 1e-3);
}

}  // namespace
