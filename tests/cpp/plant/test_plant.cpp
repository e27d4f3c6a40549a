// One sample of the robot's motion: the Euler step word for word, the exact one against Runge and
// Kutta's method.
#include "motion.hpp"
#include "nfopidn/plant/differential_drive.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class EulerStep : public ::testing::Test {
 protected:
  struct Case {
    Robot<Scalar> robot;
    Friction<Scalar> friction;
    TorquePair<Scalar> torque;
    Disturbance<Scalar> outside;
    State<Scalar> state;
  };
  Case random_case(double viscous) {
    Case c;
    c.robot = {draw.scalar<Scalar>(5, 15), draw.scalar<Scalar>(0.2, 1), draw.scalar<Scalar>(0.2, 1),
               draw.scalar<Scalar>(0.05, 0.1)};
    c.friction.viscous = static_cast<Scalar>(viscous);
    c.torque = {draw.scalar<Scalar>(-3, 3), draw.scalar<Scalar>(-3, 3)};
    c.outside = {draw.scalar<Scalar>(-5, 5), draw.scalar<Scalar>(-1, 1)};
    c.state = {draw.scalar<Scalar>(-3, 3), draw.scalar<Scalar>(-3, 3), draw.scalar<Scalar>(-3, 3),
               draw.scalar<Scalar>(-1, 1), draw.scalar<Scalar>(-1, 1)};
    return c;
  }
  static State<Scalar> advanced(const Case& c, Scalar dt, int substeps) {
    const DifferentialDrive<Scalar> plant(c.robot, c.friction, Integrator::semi_implicit_euler, dt,
                                          substeps);
    State<Scalar> state = c.state;
    plant.advance(state, math<Scalar>::heading(state.theta), c.torque, &c.outside);
    return state;
  }
  Draws draw{71};
};
TYPED_TEST_SUITE(EulerStep, Scalars);

// v and omega first, then the pose with the new v and omega and the old heading.
// eqs. 1-4
TYPED_TEST(EulerStep, IsTheDesignsStep) {
  for (const double viscous : {0.0, 0.05}) {
    for (int i = 0; i < 200; ++i) {
      const auto c = this->random_case(viscous);
      const auto dt = TypeParam(0.2);
      const State<TypeParam> next = this->advanced(c, dt, 1);
      const Real r = c.robot.wheel_radius;
      const Real track = c.robot.track_width;
      Real v = c.state.v + Real(dt) * ((Real(c.torque.left) + c.torque.right) / (c.robot.mass * r) +
                                       c.outside.force / c.robot.mass);
      Real omega = c.state.omega + Real(dt) * (track * (Real(c.torque.left) - c.torque.right) /
                                                   (2 * c.robot.inertia * r) +
                                               c.outside.moment / c.robot.inertia);
      // Viscous friction -b times the wheel's speed, taken at the end of the step.
      v /= 1 + Real(dt) * 2 * c.friction.viscous / (c.robot.mass * r * r);
      omega /= 1 + Real(dt) * c.friction.viscous * track * track / (2 * c.robot.inertia * r * r);
      const Real theta = c.state.theta;
      const Real allowed = 40 * unit<TypeParam> * (std::fabs(omega) + std::fabs(v) + 10);
      ASSERT_TRUE(near(next.v, v, allowed));
      ASSERT_TRUE(near(next.omega, omega, allowed));
      ASSERT_TRUE(near(next.x, c.state.x + dt * v * std::cos(theta), allowed));
      ASSERT_TRUE(near(next.y, c.state.y + dt * v * std::sin(theta), allowed));
      ASSERT_TRUE(near(next.theta, theta + dt * omega, allowed));
    }
  }
}

TYPED_TEST(EulerStep, SubstepsAreSmallerStepsRepeated) {
  for (const double viscous : {0.0, 0.05}) {
    auto c = this->random_case(viscous);
    c.friction.coulomb = static_cast<TypeParam>(viscous);
    const State<TypeParam> at_once = this->advanced(c, TypeParam(0.5), 8);
    for (int i = 0; i < 8; ++i) c.state = this->advanced(c, TypeParam(0.0625), 1);
    EXPECT_TRUE(same_bits(at_once, c.state));
  }
}

TEST(ExactMotion, SubstepsAreSmallerStepsRepeated) {
  Surroundings around{Robot<double>::eddie_datasheet(), {0.02, 0.1}, {0.7, -0.4}, {1, 0.2}};
  State<double> state = {1, 2, 0.3, 0.4, -0.5};
  const State<double> at_once = moved(around, Integrator::exact, 0.5, 8, state);
  for (int i = 0; i < 8; ++i) state = moved(around, Integrator::exact, 0.0625, 1, state);
  EXPECT_TRUE(same_bits(at_once, state));
}

TEST(Disturbances, ActAsTheDesignsSignsSay) {
  const Robot<double> robot = Robot<double>::eddie();
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::exact}) {
    const Surroundings pushed{robot, {}, {0, 0}, {2.3, 0}};
    const State<double> ahead = moved(pushed, integrator, 0.2, 1, {0, 0, 0, 0, 0});
    EXPECT_NEAR(ahead.v, 0.2 * 2.3 / 11.5, 1e-15);
    EXPECT_GT(ahead.x, 0);
    EXPECT_EQ(ahead.omega, 0);
    const Surroundings twisted{robot, {}, {0, 0}, {0, 0.5}};
    const State<double> turned = moved(twisted, integrator, 0.2, 1, {0, 0, 0, 0, 0});
    EXPECT_NEAR(turned.omega, 0.2 * 0.5 / 0.5873, 1e-15);
    EXPECT_GT(turned.theta, 0);
    EXPECT_EQ(turned.v, 0);
    const Surroundings driven{robot, {}, {1, 0}, {0, 0}};  // the left wheel turns it to the left
    EXPECT_GT(moved(driven, integrator, 0.2, 1, {0, 0, 0, 0, 0}).omega, 0);
  }
}

void expect_runge_kutta(const Surroundings& around, const State<double>& start, double span,
                        const std::array<Real, 2>& slide, const std::string& what) {
  const RungeKutta method(around, slide);
  const RealState expected =
      method.run({start.x, start.y, start.theta, start.v, start.omega}, span, 2000);
  const State<double> state = moved(around, Integrator::exact, span, 1, start);
  EXPECT_TRUE(near(state.x, expected.x, 1e-10L)) << what;
  EXPECT_TRUE(near(state.y, expected.y, 1e-10L)) << what;
  EXPECT_TRUE(near(state.theta, expected.theta, 1e-10L)) << what;
  EXPECT_TRUE(near(state.v, expected.v, 1e-10L)) << what;
  EXPECT_TRUE(near(state.omega, expected.omega, 1e-10L)) << what;
}

TEST(ExactMotion, EqualsRungeKuttaWithAndWithoutViscousFriction) {
  Draws draw(72);
  for (const Robot<double>& robot : some_robots()) {
    for (const double viscous : {0.0, 1e-9, 0.01, 0.3}) {
      for (int i = 0; i < 5; ++i) {
        const Surroundings around{robot,
                                  {viscous, 0},
                                  {draw.between(-1, 1), draw.between(-1, 1)},
                                  {draw.between(-3, 3), draw.between(-0.5, 0.5)}};
        const State<double> start = {1, -2, draw.between(-3, 3), draw.between(-1, 1),
                                     draw.between(-2, 2)};
        expect_runge_kutta(around, start, 0.8, {0, 0}, "viscous " + std::to_string(viscous));
      }
    }
  }
}

TEST(ExactMotion, EqualsRungeKuttaWhileBothWheelsSlide) {
  Draws draw(73);
  for (const Robot<double>& robot : some_robots()) {
    for (const double viscous : {0.0, 0.02}) {
      for (const double side : {-1.0, 1.0}) {
        // Driving fast, then turning fast on the spot: the wheels slide alike, then oppositely.
        const Surroundings around{robot, {viscous, 0.15}, {0.05, -0.04}, {0.3, -0.05}};
        expect_runge_kutta(around, {0, 0, draw.between(-3, 3), side * 1.2, side * 0.3}, 0.4,
                           {side, side}, "driving");
        expect_runge_kutta(around, {0, 0, draw.between(-3, 3), side * 0.05, side * 9}, 0.4,
                           {side, -side}, "turning");
      }
    }
  }
}

TEST(ExactMotion, FollowsAFastSpin) {
  const Surroundings around{Robot<double>::eddie()};
  const double v = 0.7;
  for (const double omega : {3.0, 40.0, -90.0}) {
    const State<double> state = moved(around, Integrator::exact, 2, 1, {0, 0, 0.5, v, omega});
    EXPECT_NEAR(state.theta, 0.5 + 2 * omega, 1e-13 * std::fabs(omega));
    EXPECT_NEAR(state.x, v / omega * (std::sin(state.theta) - std::sin(0.5)), 1e-12);
    EXPECT_NEAR(state.y, v / omega * (std::cos(0.5) - std::cos(state.theta)), 1e-12);
  }
}

TEST(ExactMotion, EndsWhateverTheSpin) {
  const Surroundings around{Robot<double>::eddie()};
  for (const double omega : {1e5, 1e12, infinite<double>, not_a_number<double>}) {
    const State<double> state = moved(around, Integrator::exact, 1, 1, {0, 0, 0, 0.1, omega});
    EXPECT_EQ(std::isfinite(state.x), std::isfinite(omega)) << omega;
  }
}

TEST(ExactMotion, IsTheSameLawInFloat) {
  const Robot<float> robot = Robot<float>::eddie_datasheet();
  const DifferentialDrive<float> plant(robot, {0.01F, 0.1F}, Integrator::exact, 0.2F, 1);
  State<float> state = {1, 2, 0.3F, 0.2F, -0.5F};
  const Disturbance<float> outside = {0.5F, 0.1F};
  plant.advance(state, math<float>::heading(state.theta), {0.4F, -0.2F}, &outside);
  const Surroundings around{Robot<double>::eddie_datasheet(), {0.01, 0.1}, {0.4, -0.2}, {0.5, 0.1}};
  const State<double> expected = moved(around, Integrator::exact, 0.2, 1, {1, 2, 0.3, 0.2, -0.5});
  const State<double> actual = {state.x, state.y, state.theta, state.v, state.omega};
  EXPECT_LT(largest_difference(actual, expected), 3e-6);
}

TEST(Decay, IsTheIntegralsOfTheExponential) {
  for (const double rate : {1e-12, 1e-6, 1e-3, 0.1, 1.0, 7.0, 300.0, 1e6}) {
    for (const double time : {1e-6, 0.02, 0.2, 1.0, 20.0}) {
      const auto decay = exact::decay(rate, time);
      const Real x = Real(rate) * time;
      Real phi = -std::expm1(-x) / rate;
      Real psi = (time - phi) / rate;
      if (x < 1e-2L) {  // the closed form cancels here
        psi =
            Real(time) * time * (0.5L - x / 6 + x * x / 24 - x * x * x / 120 + x * x * x * x / 720);
      }
      const Real left = std::exp(-x);
      EXPECT_TRUE(near(decay.left, left, (2 + x) * 4e-16L * left + 3e-308L))
          << rate << ", " << time;
      EXPECT_TRUE(near(decay.phi, phi, 2e-15L * phi)) << rate << ", " << time;
      EXPECT_TRUE(near(decay.psi, psi, 4e-15L * psi)) << rate << ", " << time;
    }
  }
  EXPECT_EQ(exact::decay(0.0, 3.0).left, 1.0);
  EXPECT_EQ(exact::decay(0.0, 3.0).phi, 3.0);
  EXPECT_EQ(exact::decay(0.0, 3.0).psi, 4.5);
}

}  // namespace
}  // namespace nfopidn::test
