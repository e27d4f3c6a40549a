// Velocities for bases that take no torques, against the plant.
#include "nfopidn/firmware/odometry.hpp"
#include "nfopidn/firmware/velocity_output.hpp"
#include "nfopidn/plant/differential_drive.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class Velocities : public ::testing::Test {
 protected:
  static constexpr Scalar dt = Scalar(0.2);
  Draws draw{11};
  TorquePair<Scalar> torque(double size) {
    return {draw.scalar<Scalar>(-size, size), draw.scalar<Scalar>(-size, size)};
  }
};
TYPED_TEST_SUITE(Velocities, Scalars);

TYPED_TEST(Velocities, AreThePlantsWithoutLimits) {
  const Robot<TypeParam> robot = Robot<TypeParam>::eddie_datasheet();
  const DifferentialDrive<TypeParam> plant(robot, {}, Integrator::semi_implicit_euler, this->dt, 1);
  VelocityOutput<TypeParam> output(robot, this->dt);
  State<TypeParam> state = {0, 0, TypeParam(0.4), 0, 0};
  for (int k = 0; k < 500; ++k) {
    const auto torque = this->torque(3);
    plant.advance(state, math<TypeParam>::heading(state.theta), torque);
    const auto velocity = output.step(torque);
    ASSERT_EQ(velocity.v, state.v) << k;
    ASSERT_EQ(velocity.omega, state.omega) << k;
  }
}

TYPED_TEST(Velocities, KeepEveryLimitAndDoNotWindUp) {
  const VelocityLimits<TypeParam> limits = {TypeParam(0.5), TypeParam(1.5), TypeParam(0.6),
                                            TypeParam(4)};
  VelocityOutput<TypeParam> output(Robot<TypeParam>::eddie(), this->dt, limits);
  Velocity<TypeParam> last = {0, 0};
  TypeParam fastest[4] = {};
  for (int k = 0; k < 2000; ++k) {
    // Long pushes one way, then the other, and turns.
    auto torque = this->torque(k % 3 == 0 ? 3 : 0.5);
    const TypeParam push = TypeParam(k / 100 % 2 == 0 ? 1 : -1);
    torque.left += push;
    torque.right += k % 50 < 25 ? push : -push;
    const auto now = output.step(torque);
    const TypeParam found[4] = {std::fabs(now.v), std::fabs(now.omega),
                                std::fabs(now.v - last.v) / this->dt,
                                std::fabs(now.omega - last.omega) / this->dt};
    for (int i = 0; i < 4; ++i) fastest[i] = std::max(fastest[i], found[i]);
    last = now;
  }
  const TypeParam bounds[4] = {limits.v, limits.omega, limits.acceleration,
                               limits.angular_acceleration};
  for (int i = 0; i < 4; ++i) EXPECT_TRUE(near(fastest[i], bounds[i], 10 * unit<TypeParam>)) << i;
  // However long it pushed: with the first torque that points back, v falls.
  for (int k = 0; k < 100; ++k) output.step({3, 3});
  ASSERT_EQ(output.velocity().v, limits.v);
  EXPECT_LT(output.step({TypeParam(-0.01), TypeParam(-0.01)}).v, limits.v);
}

// A limit of -1 m/s would drive the robot backwards at 1 m/s, and one that is NaN would limit
// nothing.
TYPED_TEST(Velocities, ALimitThatIsNoneIsSaidAndStopsTheBase) {
  using Limits = VelocityLimits<TypeParam>;
  EXPECT_EQ(Limits().validate(), Status::ok);
  EXPECT_EQ((Limits{0, 0, infinite<TypeParam>, 1}.validate()), Status::ok);
  for (const TypeParam bad : {TypeParam(-1), not_a_number<TypeParam>}) {
    const Status expected = bad == bad ? Status::out_of_range : Status::not_finite;
    for (TypeParam Limits::*member :
         {&Limits::v, &Limits::omega, &Limits::acceleration, &Limits::angular_acceleration}) {
      Limits limits = {1, 1, 1, 1};
      limits.*member = bad;
      EXPECT_EQ(limits.validate(), expected);
      VelocityOutput<TypeParam> output(Robot<TypeParam>::eddie(), this->dt, limits);
      const bool drives = member == &Limits::v || member == &Limits::acceleration;
      for (int k = 0; k < 5; ++k) output.step({3, 1});
      EXPECT_EQ(output.velocity().v == 0, drives);
      EXPECT_EQ(output.velocity().omega == 0, !drives);
    }
  }
}

TYPED_TEST(Velocities, GoOnFromWhatIsMeasured) {
  const VelocityLimits<TypeParam> limits = {1, 1, 1, 1};
  VelocityOutput<TypeParam> output(Robot<TypeParam>::eddie(), this->dt, limits);
  output.synchronise({TypeParam(0.25), TypeParam(-0.5)});
  EXPECT_EQ(output.step({0, 0}).v, TypeParam(0.25));
  EXPECT_EQ(output.velocity().omega, TypeParam(-0.5));
  output.synchronise({not_a_number<TypeParam>, 0});
  output.synchronise({0, infinite<TypeParam>});
  EXPECT_EQ(output.velocity().v, TypeParam(0.25));
  // From beyond the limit it comes back as fast as the robot may brake.
  output.synchronise({2, 0});
  EXPECT_TRUE(near(output.step({3, 3}).v, TypeParam(1.8), 4 * unit<TypeParam>));
  for (int k = 0; k < 10; ++k) output.step({3, 3});
  EXPECT_EQ(output.velocity().v, 1);
  output.reset();
  EXPECT_EQ(output.velocity().v, 0);
  EXPECT_EQ(output.velocity().omega, 0);
}

// A robot that turns counter-clockwise on the spot: its right wheel rolls forward.
TYPED_TEST(Velocities, BecomeWheelSpeedsOfARealRobot) {
  const Robot<TypeParam> robot;
  const auto speeds = to_rep103(wheel_speeds(robot, TypeParam(0), TypeParam(1)));
  EXPECT_GT(speeds.right, 0);
  EXPECT_EQ(speeds.left, -speeds.right);
  const TypeParam seconds = TypeParam(0.5);
  const auto moved = odometry(State<TypeParam>{}, speeds.left * robot.wheel_radius * seconds,
                              speeds.right * robot.wheel_radius * seconds, robot.track_width);
  EXPECT_TRUE(near(moved.theta, seconds, 4 * unit<TypeParam>));
}

TYPED_TEST(Velocities, ATorqueThatIsNoNumberChangesNothing) {
  constexpr TypeParam nan = std::numeric_limits<TypeParam>::quiet_NaN();
  VelocityOutput<TypeParam> output(Robot<TypeParam>::eddie(), this->dt);
  const auto before = output.step({1, TypeParam(0.5)});
  for (const TorquePair<TypeParam>& torque : {TorquePair<TypeParam>{nan, 1}, {1, nan}}) {
    const auto after = output.step(torque);
    ASSERT_EQ(after.v, before.v);
    ASSERT_EQ(after.omega, before.omega);
  }
  EXPECT_GT(output.step({1, TypeParam(0.5)}).v, before.v);
}

}  // namespace
}  // namespace nfopidn::test
