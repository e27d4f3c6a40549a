// Scrub: moments that oppose turning, and what the wheels' spin adds to mass and inertia.
#include <array>
#include <limits>

#include "motion.hpp"
#include "nfopidn/math/dual.hpp"

namespace nfopidn::test {
namespace {

constexpr Integrator either_integrator[] = {Integrator::semi_implicit_euler, Integrator::exact};

// What an implicit step with dry friction minimises over the speeds after it:
// m (v - v0)^2 / 2 + I (omega - omega0)^2 / 2 + h (c |w_L| + c |w_R| + q |omega|).
struct DryStep {
  Robot<double> robot;
  double coulomb, scrub, step, v0, omega0;

  double value(double v, double omega) const {
    const auto wheels = wheel_speeds(robot, v, omega);
    const double dv = v - v0, turned = omega - omega0;
    return robot.mass * dv * dv / 2 + robot.inertia * turned * turned / 2 +
           step * (coulomb * (std::fabs(wheels.left) + std::fabs(wheels.right)) +
                   scrub * std::fabs(omega));
  }

  // The least value lies where the slope is zero in one of the regions between the three lines of
  // standstill, on one of the lines, or where they meet: all such points are tried.
  std::array<double, 2> minimum() const {
    const double half = robot.track_width / 2, r = robot.wheel_radius;
    std::array<double, 2> best = {0, 0};
    const auto take = [&](double v, double omega) {
      if (value(v, omega) < value(best[0], best[1])) best = {v, omega};
    };
    for (const double left : {-1.0, 1.0}) {
      for (const double right : {-1.0, 1.0}) {
        for (const double turn : {-1.0, 1.0}) {
          const double push = -step * coulomb * (left + right) / r;
          const double moment = -step * (coulomb * half * (left - right) / r + scrub * turn);
          take(v0 + push / robot.mass, omega0 + moment / robot.inertia);
          take(v0 + push / robot.mass, 0);
          for (const double side : {-1.0, 1.0}) {  // v = side * half * omega: a wheel stands
            const double inertia = robot.mass * half * half + robot.inertia;
            const double other = left * 2 * half / r;  // the other wheel's speed per omega
            const double impulse = robot.mass * half * side * v0 + robot.inertia * omega0 -
                                   step * (coulomb * other + scrub * turn);
            const double omega = impulse / inertia;
            take(side * half * omega, omega);
          }
        }
      }
    }
    return best;
  }
};

TEST(Scrub, AnEulerStepMinimisesItsDryFrictionProblem) {
  Draws draw(91);
  int straight = 0, rests = 0, pivots = 0, slides = 0;
  for (int i = 0; i < 20000; ++i) {
    const Robot<double> robot = some_robots()[static_cast<std::size_t>(i % 3)];
    const double coulomb = i % 7 == 0 ? 0 : draw.between(0.01, 0.5);
    const double scrub = draw.between(0.001, 0.3);
    const double size = i % 2 == 0 ? 0.02 : 0.2;
    const DryStep problem = {
        robot, coulomb, scrub, 0.04, draw.between(-size, size), draw.between(-3 * size, 3 * size)};
    const Surroundings around{robot, {0, coulomb, 0, scrub}};
    const State<double> after = moved(around, Integrator::semi_implicit_euler, problem.step, 1,
                                      {0, 0, 0, problem.v0, problem.omega0});
    const auto [v, omega] = problem.minimum();
    ASSERT_NEAR(after.v, v, 1e-9) << i;
    ASSERT_NEAR(after.omega, omega, 1e-9) << i;
    const bool stands = std::fabs(std::fabs(v) - robot.track_width / 2 * std::fabs(omega)) < 1e-12;
    const bool turns = std::fabs(omega) > 1e-12;
    ++(!turns ? (std::fabs(v) > 1e-12 ? straight : rests) : stands ? pivots : slides);
  }
  for (const int count : {straight, rests, pivots, slides}) EXPECT_GT(count, 500);
}

TEST(Scrub, StopsAtTheClosedFormsHeadingAndSticks) {
  for (const Robot<double>& robot : some_robots()) {
    const double scrub = 0.1, omega = -0.8, moment = 0.03;
    const Surroundings around{robot, {0, 0, 0, scrub}, {0, 0}, {0, moment}};
    const double slowing = (scrub + moment) / robot.inertia;  // the moment pushes against the turn
    const State<double> end = moved(around, Integrator::exact, 6, 1, {0, 0, 0.2, 0, omega});
    EXPECT_EQ(end.omega, 0);
    EXPECT_NEAR(end.theta, 0.2 - omega * omega / (2 * slowing), 1e-12);
  }
}

// Rolling, held on its heading by scrub until the torques' moment exceeds it.
TEST(Scrub, HoldsTheHeadingOfARollingRobot) {
  for (const Robot<double>& robot : some_robots()) {
    for (const Integrator integrator : either_integrator) {
      const double per_torque = robot.track_width / (2 * robot.wheel_radius);
      for (const double coulomb : {0.0, 0.05}) {
        for (const double sign : {-1.0, 1.0}) {
          const auto after = [&](double moment) {
            const double difference = sign * moment / per_torque;
            const Surroundings around{
                robot, {0, coulomb, 0, 0.1}, {0.2 + difference / 2, 0.2 - difference / 2}};
            return moved(around, integrator, 0.5, 1, {0, 0, 0.3, 0.4, 0});
          };
          EXPECT_EQ(after(0.099).omega, 0);
          EXPECT_EQ(after(0.099).theta, 0.3);
          const double gain = 2 * (0.2 - coulomb) / (robot.mass * robot.wheel_radius);
          EXPECT_NEAR(after(0.099).v, 0.4 + 0.5 * gain, 1e-12);
          EXPECT_GT(sign * after(0.101).omega, 1e-5);
        }
      }
    }
  }
}

TEST(Scrub, ViscousScrubSlowsTurningAlone) {
  const Robot<double> robot = Robot<double>::eddie_datasheet();
  const Surroundings around{robot, {0, 0, 0.2, 0}};
  const State<double> end = moved(around, Integrator::exact, 0.7, 1, {0, 0, 0, 0.5, 1.2});
  EXPECT_EQ(end.v, 0.5);
  EXPECT_NEAR(end.omega, 1.2 * std::exp(-0.2 / robot.inertia * 0.7), 1e-14);
  const State<double> euler =
      moved(around, Integrator::semi_implicit_euler, 0.7, 1, {0, 0, 0, 0.5, 1.2});
  EXPECT_NEAR(euler.omega, 1.2 / (1 + 0.2 / robot.inertia * 0.7), 1e-15);
}

Surroundings scrubbing_surroundings(Draws& draw, int i) {
  const Robot<double> robot = some_robots()[static_cast<std::size_t>(i % 3)];
  return {robot,
          {i % 2 == 0 ? draw.between(0, 0.3) : 0, i % 5 == 0 ? 0 : draw.between(0.05, 0.6),
           i % 4 < 2 ? draw.between(0, 0.3) : 0, draw.between(0.05, 0.5)},
          {draw.between(-1.2, 1.2), draw.between(-1.2, 1.2)},
          {draw.between(-3, 3), draw.between(-0.5, 0.5)}};
}
State<double> scrubbing_state(Draws& draw, int i) {
  const bool turns = i % 3 != 0;
  return {0, 0, draw.between(-3, 3), i % 11 == 0 ? 0 : draw.between(-0.5, 0.5),
          turns ? draw.between(-1.5, 1.5) : 0};
}

TEST(Scrub, ExactMotionDoesNotDependOnItsSubsteps) {
  Draws draw(92);
  int straight = 0;
  for (int i = 0; i < 600; ++i) {
    const Surroundings around = scrubbing_surroundings(draw, i);
    const State<double> start = scrubbing_state(draw, i);
    const State<double> whole = moved(around, Integrator::exact, 0.5, 1, start);
    const State<double> parts = moved(around, Integrator::exact, 0.5, 7, start);
    ASSERT_LT(largest_difference(whole, parts), 1e-9) << "case " << i;
    straight += whole.omega == 0 && whole.v != 0 ? 1 : 0;
  }
  EXPECT_GT(straight, 20);
}

TEST(Scrub, EulerConvergesToTheExactMotionThroughItsEvents) {
  Draws draw(93);
  for (int i = 0; i < 60; ++i) {
    const Surroundings around = scrubbing_surroundings(draw, i);
    const State<double> start = scrubbing_state(draw, i);
    const State<double> exact = moved(around, Integrator::exact, 1, 1, start);
    const auto distance = [&](int substeps) {
      return largest_difference(moved(around, Integrator::semi_implicit_euler, 1, substeps, start),
                                exact);
    };
    const double coarse = distance(1000);
    EXPECT_LT(coarse, 2e-2) << i;
    EXPECT_LT(distance(10000), 0.2 * coarse + 1e-9) << i;
  }
}

TEST(Scrub, EnergyNeverGrowsWithoutTorque) {
  Draws draw(94);
  for (const Integrator integrator : either_integrator) {
    int stopped = 0;
    for (int i = 0; i < 60; ++i) {
      Surroundings around = scrubbing_surroundings(draw, i);
      around.torque = {0, 0};
      around.outside = {0, 0};
      State<double> state = scrubbing_state(draw, i);
      for (int k = 0; k < 30; ++k) {
        const double before = energy(around.robot, state);
        state = moved(around, integrator, 0.1, 1, state);
        ASSERT_LE(energy(around.robot, state), before * (1 + 1e-14)) << "case " << i;
      }
      stopped += state.omega == 0 ? 1 : 0;
    }
    EXPECT_GT(stopped, 40);
  }
}

// Both slopes of a dual number through an event, against differences.
TEST(Scrub, SlopesGoThroughTheStopOfATurn) {
  const Robot<double> robot = Robot<double>::eddie_datasheet();
  const DifferentialDrive<double> plant(robot, {0.01, 0.05, 0.02, 0.1}, Integrator::exact, 0.5, 1);
  const auto end = [&](auto torque) {
    using T = decltype(torque);
    State<T> state = {T(0.0), T(0.0), T(0.2), T(0.4), T(0.15)};
    plant.advance(state, math<T>::heading(state.theta), TorquePair<T>{torque, T(0.15)});
    return state;
  };
  const State<Dual<double>> at = end(Dual<double>(0.12, 1.0));
  EXPECT_EQ(at.omega.value, 0);
  EXPECT_EQ(at.omega.slope, 0);
  const double h = 1e-5;
  const State<double> above = end(0.12 + h), below = end(0.12 - h);
  EXPECT_NEAR(at.theta.slope, (above.theta - below.theta) / (2 * h), 1e-8);
  EXPECT_NEAR(at.x.slope, (above.x - below.x) / (2 * h), 1e-8);
  EXPECT_NEAR(at.y.slope, (above.y - below.y) / (2 * h), 1e-8);
  EXPECT_NEAR(at.v.slope, (above.v - below.v) / (2 * h), 1e-8);
  EXPECT_GT(std::fabs(at.theta.slope), 1e-3);
}

TEST(Scrub, ActsBesideMotors) {
  const Robot<double> robot = Robot<double>::eddie_datasheet();
  Motor<double> idle;
  idle.back_emf_constant = 0;
  for (const Integrator integrator : either_integrator) {
    const Friction<double> friction = {0.01, 0.02, 0.03, 0.04};
    const MotorDrive<double> driven(robot, idle, integrator, 0.2, 1, friction);
    const DifferentialDrive<double> plain(robot, friction, integrator, 0.2, 1);
    State<double> one = {0, 0, 0, 0.3, 1}, other = one;
    driven.advance(one, math<double>::heading(0.0), {0, 0});
    plain.advance(other, math<double>::heading(0.0), {0, 0});
    EXPECT_EQ(largest_difference(one, other), 0);
  }
}

// By the kinetic energy: the wheels turn at w_L and w_R.
TEST(WithWheels, HasTheEnergyOfTheSpinningWheels) {
  Draws draw(95);
  for (const Robot<double>& robot : some_robots()) {
    const double inertia = draw.between(0.001, 0.1);
    const Robot<double> loaded = with_wheels(robot, inertia);
    const State<double> state = {0, 0, 0, draw.between(-1, 1), draw.between(-2, 2)};
    const auto wheels = wheel_speeds(robot, state.v, state.omega);
    const double spin = 0.5 * inertia * (wheels.left * wheels.left + wheels.right * wheels.right);
    EXPECT_NEAR(energy(loaded, state), energy(robot, state) + spin, 1e-12);
    EXPECT_EQ(loaded.track_width, robot.track_width);
    EXPECT_EQ(loaded.wheel_radius, robot.wheel_radius);
    Motor<double> motor;
    motor.gear_ratio = 2;
    motor.rotor_inertia = inertia / 4;
    EXPECT_EQ(with_rotors(robot, motor).mass, loaded.mass);
    EXPECT_EQ(with_rotors(robot, motor).inertia, loaded.inertia);
  }
}

}  // namespace
}  // namespace nfopidn::test
