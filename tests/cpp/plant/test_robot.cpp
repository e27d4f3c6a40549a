// The robot's dynamics: forward, inverse, wheels, signs.
#include "nfopidn/plant/robot.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class RobotDynamics : public ::testing::Test {
 protected:
  Robot<Scalar> random_robot() {
    return {draw.scalar<Scalar>(1, 20), draw.scalar<Scalar>(0.05, 2), draw.scalar<Scalar>(0.1, 1),
            draw.scalar<Scalar>(0.02, 0.2)};
  }
  Draws draw{61};
};
TYPED_TEST_SUITE(RobotDynamics, Scalars);

TYPED_TEST(RobotDynamics, EddieIsThePapersAndTheDatasheets) {
  const auto paper = Robot<TypeParam>::eddie();
  EXPECT_EQ(paper.mass, TypeParam(11.5));
  EXPECT_EQ(paper.inertia, TypeParam(0.5873));
  EXPECT_EQ(paper.track_width, TypeParam(0.452));
  EXPECT_EQ(paper.wheel_radius, TypeParam(0.076));
  const auto datasheet = Robot<TypeParam>::eddie_datasheet();
  EXPECT_EQ(datasheet.mass, TypeParam(11.5));
  EXPECT_EQ(datasheet.inertia, TypeParam(0.294));
  EXPECT_EQ(datasheet.track_width, TypeParam(0.390));
  EXPECT_EQ(datasheet.wheel_radius, TypeParam(0.076));
  EXPECT_EQ(paper.validate(), Status::ok);
  EXPECT_EQ(datasheet.validate(), Status::ok);
}

// eq. 4
TYPED_TEST(RobotDynamics, AccelerationsAreThoseOfEquation4) {
  for (int i = 0; i < 200; ++i) {
    const auto robot = this->random_robot();
    const Acceleration<TypeParam> acceleration(robot);
    const TorquePair<TypeParam> torque = {this->draw.template scalar<TypeParam>(-3, 3),
                                          this->draw.template scalar<TypeParam>(-3, 3)};
    const Disturbance<TypeParam> outside = {this->draw.template scalar<TypeParam>(-9, 9),
                                            this->draw.template scalar<TypeParam>(-3, 3)};
    const Real sum = Real(torque.left) + torque.right;
    const Real difference = Real(torque.left) - torque.right;
    const Real linear = sum / (Real(robot.mass) * robot.wheel_radius) + outside.force / robot.mass;
    const Real angular =
        robot.track_width * difference / (2 * Real(robot.inertia) * robot.wheel_radius) +
        outside.moment / robot.inertia;
    const Real allowed = 8 * unit<TypeParam>;
    ASSERT_TRUE(near(acceleration.linear(torque, outside), linear,
                     allowed * (6 / (Real(robot.mass) * robot.wheel_radius) + 9)));
    ASSERT_TRUE(near(acceleration.angular(torque, outside), angular,
                     allowed * (6 * robot.track_width / (Real(robot.inertia) * robot.wheel_radius) +
                                3 / robot.inertia)));
  }
}

// eqs. 5, 6, 9, 10
TYPED_TEST(RobotDynamics, InverseDynamicsUndoesTheAccelerations) {
  for (int i = 0; i < 200; ++i) {
    const auto robot = this->random_robot();
    const auto linear = this->draw.template scalar<TypeParam>(-2, 2);
    const auto angular = this->draw.template scalar<TypeParam>(-2, 2);
    const TorquePair<TypeParam> torque = inverse_dynamics(robot, linear, angular);
    const Acceleration<TypeParam> acceleration(robot);
    // The wheels' torques may be far larger than their sum or difference.
    const Real size = std::fabs(torque.left) + std::fabs(torque.right);
    ASSERT_TRUE(near(acceleration.linear(torque, {0, 0}), linear,
                     8 * unit<TypeParam> * (size * acceleration.drive + 1)));
    ASSERT_TRUE(near(acceleration.angular(torque, {0, 0}), angular,
                     8 * unit<TypeParam> * (size * acceleration.steer + 1)));
  }
}

TYPED_TEST(RobotDynamics, WheelPowerIsThePowerOfForceAndMoment) {
  for (int i = 0; i < 200; ++i) {
    const auto robot = this->random_robot();
    const auto v = this->draw.template scalar<TypeParam>(-1, 1);
    const auto omega = this->draw.template scalar<TypeParam>(-3, 3);
    const TorquePair<TypeParam> torque = {this->draw.template scalar<TypeParam>(-3, 3),
                                          this->draw.template scalar<TypeParam>(-3, 3)};
    const Acceleration<TypeParam> acceleration(robot);
    const TorquePair<TypeParam> speed = wheel_speeds(robot, v, omega);
    const Real force = Real(acceleration.linear(torque, {0, 0})) * robot.mass;
    const Real moment = Real(acceleration.angular(torque, {0, 0})) * robot.inertia;
    const Real left = Real(torque.left) * speed.left;
    const Real right = Real(torque.right) * speed.right;
    ASSERT_TRUE(near(left + right, force * v + moment * omega,
                     20 * unit<TypeParam> * (std::fabs(left) + std::fabs(right) + 1)));
  }
}

TYPED_TEST(RobotDynamics, WheelSpeedsHaveThePapersSign) {
  const Robot<TypeParam> robot = {10, 1, TypeParam(0.5), TypeParam(0.1)};
  const TorquePair<TypeParam> straight = wheel_speeds(robot, TypeParam(0.3), TypeParam(0));
  EXPECT_TRUE(near(straight.left, 3, 8 * unit<TypeParam>));
  EXPECT_TRUE(near(straight.right, 3, 8 * unit<TypeParam>));
  // The paper's positive turn, counter-clockwise, has the left wheel ahead.
  const TorquePair<TypeParam> turning = wheel_speeds(robot, TypeParam(0), TypeParam(1));
  EXPECT_TRUE(near(turning.left, 2.5L, 8 * unit<TypeParam>));
  EXPECT_TRUE(near(turning.right, -2.5L, 8 * unit<TypeParam>));
  EXPECT_GT(Acceleration<TypeParam>(robot).angular(TorquePair<TypeParam>{1, 0}, {0, 0}), 0);
}

TYPED_TEST(RobotDynamics, LateralForceIsMassTimesSpeedTimesTurning) {
  const Robot<TypeParam> robot = {10, 1, TypeParam(0.5), TypeParam(0.1)};
  EXPECT_TRUE(near(lateral_force(robot, TypeParam(-0.5), TypeParam(3)), -15, 40 * unit<TypeParam>));
}

TYPED_TEST(RobotDynamics, ParametersAreChecked) {
  Robot<TypeParam>::fields([](const auto& field) {
    for (const TypeParam bad : {TypeParam(0), TypeParam(-1)}) {
      Robot<TypeParam> robot;
      robot.*field.member = bad;
      EXPECT_EQ(robot.validate(), Status::out_of_range) << field.name;
    }
    for (const TypeParam bad : {not_a_number<TypeParam>, infinite<TypeParam>}) {
      Robot<TypeParam> robot;
      robot.*field.member = bad;
      EXPECT_EQ(robot.validate(), Status::not_finite) << field.name;
    }
  });
}

}  // namespace
}  // namespace nfopidn::test
