// Coulomb friction: stopping, sticking, breaking loose, turning about a stuck wheel.
#include "motion.hpp"

namespace nfopidn::test {
namespace {

constexpr Integrator both_integrators[] = {Integrator::semi_implicit_euler, Integrator::exact};

Surroundings random_surroundings(Draws& draw, const Robot<double>& robot, bool viscous) {
  return {robot,
          {viscous ? draw.between(0, 0.3) : 0, draw.between(0.05, 0.8)},
          {draw.between(-1.2, 1.2), draw.between(-1.2, 1.2)},
          {draw.between(-3, 3), draw.between(-1, 1)}};
}
State<double> random_state(Draws& draw) {
  return {0, 0, draw.between(-3, 3), draw.between(-0.5, 0.5), draw.between(-1.5, 1.5)};
}

// Within its limit, against the motion left over, and at its limit where a wheel goes on moving.
TEST(OpposingFriction, SolvesItsComplementarityProblem) {
  Draws draw(81);
  int inside = 0;
  int mixed = 0;
  for (int i = 0; i < 5000; ++i) {
    const Robot<double> robot = some_robots()[static_cast<std::size_t>(i % 3)];
    const FrictionCoefficients<double> friction(robot, {0, 0});
    const double limit = draw.between(0.01, 0.5);
    const double size = i % 2 == 0 ? 10 : 40;
    const double motion[2] = {draw.between(-size, size), draw.between(-size, size)};
    const auto pair = opposing_friction<double>(friction, {motion[0], motion[1]}, limit);
    const double f[2] = {pair.left, pair.right};
    bool loose[2] = {};
    for (int side = 0; side < 2; ++side) {
      ASSERT_LE(std::fabs(f[side]), limit);
      const double rest = motion[side] + friction.own * f[side] + friction.other * f[1 - side];
      loose[side] = std::fabs(f[side]) == limit;
      ASSERT_LE(loose[side] ? rest * f[side] : std::fabs(rest), 1e-12);
    }
    inside += !loose[0] && !loose[1] ? 1 : 0;
    mixed += loose[0] != loose[1] ? 1 : 0;
  }
  EXPECT_GT(inside, 100);
  EXPECT_GT(mixed, 500);
}

TEST(OpposingFriction, CoefficientsAreTheWheelsAccelerations) {
  for (const Robot<double>& robot : some_robots()) {
    const FrictionCoefficients<double> friction(robot, {0.3, 0.2});
    const Acceleration<double> acceleration(robot);
    const TorquePair<double> only_left = {1, 0};
    const auto wheels = wheel_speeds(robot, acceleration.linear(only_left, {0, 0}),
                                     acceleration.angular(only_left, {0, 0}));
    EXPECT_NEAR(friction.own, wheels.left, 1e-13 * friction.own);
    EXPECT_NEAR(friction.other, wheels.right, 1e-13 * friction.own);
    // Wheels turning at 1 rad/s are braked by 0.3 N m each.
    EXPECT_NEAR(friction.linear_rate * robot.wheel_radius,
                acceleration.linear(TorquePair<double>{0.3, 0.3}, {0, 0}), 1e-13);
    EXPECT_NEAR(friction.angular_rate * 2 * robot.wheel_radius / robot.track_width,
                acceleration.angular(TorquePair<double>{0.3, -0.3}, {0, 0}), 1e-13);
  }
}

TEST(Coulomb, StopsAtTheClosedFormsPlaceAndSticks) {
  const Robot<double> robot = Robot<double>::eddie_datasheet();
  const double coulomb = 0.2;
  const double torque = 0.05;
  const Surroundings around{robot, {0, coulomb}, {torque, torque}};
  const double braking = 2 * (coulomb - torque) / (robot.mass * robot.wheel_radius);
  const State<double> stopped = moved(around, Integrator::exact, 2, 1, {0, 0, 0.6, 0.4, 0});
  EXPECT_EQ(stopped.v, 0);
  EXPECT_EQ(stopped.omega, 0);
  const double distance = 0.4 * 0.4 / (2 * braking);
  EXPECT_NEAR(stopped.x, distance * std::cos(0.6), 1e-12);
  EXPECT_NEAR(stopped.y, distance * std::sin(0.6), 1e-12);
  EXPECT_NEAR(stopped.theta, 0.6, 1e-12);

  const Surroundings turning{robot, {0, coulomb}};
  const double slowing = robot.track_width * 2 * coulomb / (2 * robot.inertia * robot.wheel_radius);
  const State<double> turned = moved(turning, Integrator::exact, 2, 1, {0, 0, 0, 0, -1.5});
  EXPECT_EQ(turned.omega, 0);
  EXPECT_NEAR(turned.theta, -1.5 * 1.5 / (2 * slowing), 1e-12);
}

// 1 N m is a torque like any other.
TEST(Coulomb, HoldsARobotByOneNewtonMetreAlone) {
  for (const Integrator integrator : both_integrators) {
    const Surroundings held{Robot<double>::eddie(), {0, 1}, {0.9, -0.8}};
    const State<double> rest = {1, 2, 0.3, 0, 0};
    EXPECT_LE(largest_difference(moved(held, integrator, 0.2, 3, rest), rest), 1e-16);
    const Surroundings loose{Robot<double>::eddie(), {0, 1}, {1.2, 1.2}};
    EXPECT_GT(moved(loose, integrator, 0.2, 3, rest).v, 0.01);
  }
}

TEST(Coulomb, ARobotAtRestStaysBelowTheLimitAndLeavesAboveIt) {
  for (const Robot<double>& robot : some_robots()) {
    for (const Integrator integrator : both_integrators) {
      const State<double> rest = {1, 2, 0.3, 0, 0};
      // The exact motion stays to the bit; the Euler step leaves a rounding error of its impulse.
      const double allowed = integrator == Integrator::exact ? 0 : 1e-16;
      for (const double left : {-0.199, 0.0, 0.19}) {
        for (const double right : {-0.19, 0.1, 0.199}) {
          const Surroundings held{robot, {0.01, 0.2}, {left, right}};
          State<double> state = rest;
          for (int k = 0; k < 10; ++k) state = moved(held, integrator, 0.2, 3, state);
          EXPECT_LE(largest_difference(state, rest), allowed);
        }
      }
      for (const double sign : {-1.0, 1.0}) {
        const Surroundings driven{robot, {0, 0.2}, {sign * 0.3, sign * 0.3}};
        const double v = sign * 0.2 * 2 * 0.1 / (robot.mass * robot.wheel_radius);
        EXPECT_NEAR(moved(driven, integrator, 0.2, 4, rest).v, v, 1e-14);
        const Surroundings turned{robot, {0, 0.2}, {sign * 0.3, -sign * 0.3}};
        const double omega =
            sign * 0.2 * robot.track_width * 2 * 0.1 / (2 * robot.inertia * robot.wheel_radius);
        EXPECT_NEAR(moved(turned, integrator, 0.2, 4, rest).omega, omega, 1e-13);
      }
    }
  }
}

TEST(Coulomb, EulerSticksButForRounding) {
  const Surroundings around{Robot<double>::eddie_datasheet(), {0.02, 0.2}, {0.1, -0.15}};
  State<double> state = {0, 0, 0, 0.3, 1};
  for (int k = 0; k < 20; ++k) {
    state = moved(around, Integrator::semi_implicit_euler, 0.2, 1, state);
  }
  EXPECT_NEAR(state.v, 0, 1e-16);
  EXPECT_NEAR(state.omega, 0, 1e-16);
}

TEST(Coulomb, OneStuckWheelIsThePivot) {
  for (const Robot<double>& robot : some_robots()) {
    const FrictionCoefficients<double> m(robot, {0, 0});
    for (const bool left_drives : {true, false}) {
      const double coulomb = 0.3;
      const double torque = 0.7;
      const Surroundings around{
          robot, {0, coulomb}, {left_drives ? torque : 0, left_drives ? 0 : torque}};
      const State<double> start = {1, 2, 0.4, 0, 0};
      const double span = 0.5;
      const State<double> state = moved(around, Integrator::exact, span, 1, start);
      const auto wheels = wheel_speeds(robot, state.v, state.omega);
      const double stuck = left_drives ? wheels.right : wheels.left;
      const double driven = left_drives ? wheels.left : wheels.right;
      EXPECT_NEAR(stuck, 0, 1e-14);
      EXPECT_NEAR(driven, span * (torque - coulomb) * (m.own - m.other * m.other / m.own), 1e-12);
      // In the paper's sign the right wheel stands to the left of the robot's axis.
      const double side = (left_drives ? 0.5 : -0.5) * robot.track_width;
      EXPECT_NEAR(state.x - side * std::sin(state.theta), 1 - side * std::sin(0.4), 1e-12);
      EXPECT_NEAR(state.y + side * std::cos(state.theta), 2 + side * std::cos(0.4), 1e-12);
      EXPECT_GT(std::fabs(state.theta - 0.4), 0.1);
    }
  }
}

TEST(Coulomb, EnergyNeverGrowsWithoutTorque) {
  Draws draw(82);
  for (const Integrator integrator : both_integrators) {
    for (int i = 0; i < 60; ++i) {
      Surroundings around =
          random_surroundings(draw, some_robots()[static_cast<std::size_t>(i % 3)], i % 2 == 0);
      around.torque = {0, 0};
      around.outside = {0, 0};
      State<double> state = random_state(draw);
      const double first = energy(around.robot, state);
      for (int k = 0; k < 30; ++k) {
        const double before = energy(around.robot, state);
        state = moved(around, integrator, 0.1, 1, state);
        ASSERT_LE(energy(around.robot, state), before * (1 + 1e-14)) << "case " << i;
      }
      EXPECT_LT(energy(around.robot, state), 0.9 * first) << "case " << i;
    }
  }
}

void expect_euler_converges(const Surroundings& around, const State<double>& start,
                            const std::string& what) {
  const State<double> exact = moved(around, Integrator::exact, 1, 1, start);
  const auto distance = [&](int substeps) {
    return largest_difference(moved(around, Integrator::semi_implicit_euler, 1, substeps, start),
                              exact);
  };
  const double coarse = distance(1000);
  EXPECT_LT(coarse, 2e-2) << what;
  EXPECT_LT(distance(10000), 0.2 * coarse + 1e-9) << what;  // first order, but for the events
}

TEST(Coulomb, EulerConvergesToTheExactMotionThroughItsEvents) {
  Draws draw(83);
  int stopped = 0;
  for (int i = 0; i < 60; ++i) {
    const Robot<double> robot = some_robots()[static_cast<std::size_t>(i % 3)];
    const Surroundings around = random_surroundings(draw, robot, i % 2 == 0);
    const State<double> start = i % 5 == 0 ? State<double>{0, 0, 1, 0, 0} : random_state(draw);
    expect_euler_converges(around, start, "case " + std::to_string(i));
    const State<double> end = moved(around, Integrator::exact, 1, 1, start);
    stopped += end.v == 0 && end.omega == 0 ? 1 : 0;
  }
  EXPECT_GT(stopped, 3);
}

TEST(Coulomb, ExactMotionDoesNotDependOnItsSubsteps) {
  Draws draw(84);
  for (int i = 0; i < 300; ++i) {
    const Robot<double> robot = some_robots()[static_cast<std::size_t>(i % 3)];
    const Surroundings around = random_surroundings(draw, robot, i % 2 == 0);
    const State<double> start = random_state(draw);
    const State<double> whole = moved(around, Integrator::exact, 0.5, 1, start);
    const State<double> parts = moved(around, Integrator::exact, 0.5, 7, start);
    ASSERT_LT(largest_difference(whole, parts), 1e-9) << "case " << i;
  }
}

// A wheel that sticks while the robot turns about it, until the other wheel's viscous friction
// pulls it loose: it leaves with no acceleration at first, and time must go forward all the same.
TEST(Coulomb, AWheelBreaksLooseDuringAPivot) {
  const Robot<double> robot = Robot<double>::eddie_datasheet();
  const Surroundings from_rest{robot,
                               {0.29395428127629194, 0.25641754882551032},
                               {-0.95110768282503966, -0.15462383674930757},
                               {-1.9829139409948553, 0.73103710017104806}};
  expect_euler_converges(from_rest, {0, 0, 0, 0, 0}, "from rest");
  const Surroundings braking{
      robot, {0.64953470657581747, 0.61712768252930728}, {0.53822984866002432, 1.0944890235462292}};
  expect_euler_converges(braking, {0, 0, 0, -0.61431133131512972, -2.8450300917303375}, "braking");
}

// Long against the time constants nothing is left of a glide's slope, and a wheel that turns round
// twice in between must still be seen to stop.
TEST(Coulomb, HeavyViscousFrictionHidesNoStop) {
  const Surroundings around{Robot<double>::eddie_datasheet(),
                            {1.6426995824982151, 0.57990153132582667},
                            {0.62882737135820754, -1.7466964193057117}};
  const State<double> start = {0, 0, 0, -0.50412180617090563, 2.8490356279020252};
  const State<double> whole = moved(around, Integrator::exact, 0.953393425789546, 1, start);
  const State<double> parts = moved(around, Integrator::exact, 0.953393425789546, 40, start);
  EXPECT_LT(largest_difference(whole, parts), 1e-9);
}

TEST(FirstCrossing, IsWithinItsSpan) {
  const auto crossing = [](const auto& function, const auto& slope, double span) {
    return exact::first_crossing<double>(function, slope, span);
  };
  const auto falling = [](double t) { return 1 - t * t; };
  const auto falling_slope = [](double t) { return -2 * t; };
  EXPECT_NEAR(crossing(falling, falling_slope, 3.0), 1, 1e-15);
  EXPECT_EQ(crossing(falling, falling_slope, 0.9), 0.9);
  const auto dip = [](double t) { return (t - 1) * (t - 2); };
  const auto dip_slope = [](double t) { return 2 * t - 3; };
  EXPECT_NEAR(crossing(dip, dip_slope, 5.0), 1, 1e-15);
  EXPECT_NEAR(crossing(dip, dip_slope, 1.5), 1, 1e-15);
  const auto shallow = [](double t) { return (t - 1) * (t - 2) + 0.3; };
  EXPECT_EQ(crossing(shallow, dip_slope, 5.0), 5.0);
  const auto rising = [](double t) { return t; };
  EXPECT_EQ(crossing(
                rising, [](double) { return 1.0; }, 5.0),
            5.0);
}

// What a wheel's speed looks like that starts from rest with rounding errors in speed and slope.
TEST(FirstCrossing, TakesNoRoundingErrorForAStop) {
  const auto speed = [](double t) { return -1e-17 - 1e-12 * t + t * t; };
  const auto slope = [](double t) { return -1e-12 + 2 * t; };
  EXPECT_EQ(exact::first_crossing<double>(speed, slope, 0.2), 0.2);
}

}  // namespace
}  // namespace nfopidn::test
