// Symmetries: the robot turned round, driving its path in reverse, and the world in a mirror.
#include "support.hpp"

namespace nfopidn::test {
namespace {

constexpr double tolerance = 1e-12;

// Everything that decides a run but the gains.
struct Variant {
  Form form;
  Lateral lateral;
  AntiWindup anti_windup;
  Activation activation;
  Integrator integrator;
  HeadingChoice heading;
};

std::vector<Variant> variants() {
  std::vector<Variant> all;
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::exact}) {
    for (const HeadingChoice heading : {HeadingChoice::forward, HeadingChoice::continuous}) {
      for (const Lateral lateral : {Lateral::direction, Lateral::speed}) {
        all.push_back({Form::positional, lateral, AntiWindup::none, Activation::sigmoid, integrator,
                       heading});
        all.push_back(
            {Form::positional, lateral, AntiWindup::none, Activation::linear, integrator, heading});
        for (const AntiWindup rule : {AntiWindup::none, AntiWindup::hold, AntiWindup::clamp}) {
          all.push_back(
              {Form::incremental, lateral, rule, Activation::sigmoid, integrator, heading});
        }
      }
    }
  }
  return all;
}

ControllerSettings<double> settings_of(const Variant& variant) {
  auto settings = steady_settings(variant.form);
  settings.lateral = variant.lateral;
  settings.anti_windup = variant.anti_windup;
  settings.activation = variant.activation;
  return settings;
}

// A gentle, smooth path, a push and a twist, friction, a delay, and a limit that is reached.
Scenario scenario_of(const Variant& variant) {
  TrajectorySettings settings;
  settings.name = variant.heading == HeadingChoice::forward ? Curve::eight : Curve::ranunculoid;
  settings.period = 30;
  settings.scale = 0.5;
  settings.heading = variant.heading;
  Scenario scenario;
  scenario.trajectory = make(settings);
  const Trajectory& t = scenario.trajectory;
  scenario.initial_pose = {t.x(0) + 0.05, t.y(0) + 0.08, t.theta(0) + 0.2};
  scenario.initial_velocity.value = {0.03, -0.05};
  scenario.integrator = variant.integrator;
  scenario.disturbance = {{0.1, 0.01}};
  scenario.viscous_friction = 0.001;
  scenario.torque_limit = 0.2;
  scenario.delay = variant.form == Form::positional ? 1 : 0;  // the other would not stand it
  return scenario;
}

Scenario turned_round(Scenario scenario) {
  Trajectory& t = scenario.trajectory;
  t.theta += M_PI;
  t.v = -t.v;
  t.acceleration = -t.acceleration;
  for (auto& reverse : t.reverse) reverse = reverse == 0 ? 1 : 0;
  (*scenario.initial_pose)[2] += M_PI;
  scenario.initial_velocity.value[0] *= -1;
  for (auto& pair : scenario.disturbance) pair[0] *= -1;
  return scenario;
}

Scenario mirrored(Scenario scenario) {
  Trajectory& t = scenario.trajectory;
  t.y = -t.y;
  t.theta = -t.theta;
  t.omega = -t.omega;
  t.turn_acceleration = -t.turn_acceleration;
  (*scenario.initial_pose)[1] *= -1;
  (*scenario.initial_pose)[2] *= -1;
  scenario.initial_velocity.value[1] *= -1;
  for (auto& pair : scenario.disturbance) pair[1] *= -1;
  return scenario;
}

// b's column times sign plus offset is a's.
void expect_column(const RunTable& a, int column_a, const RunTable& b, int column_b, double sign,
                   double offset = 0) {
  const double apart = (a.col(column_a) - (sign * b.col(column_b) + offset)).abs().maxCoeff();
  EXPECT_LE(apart, tolerance) << column_names[column_a];
}

TEST(Mirror, AReverseReferenceIsTheRobotTurnedRound) {
  int at_limit = 0;
  for (const Variant& variant : variants()) {
    const Scenario scenario = scenario_of(variant);
    const auto a = simulate(scenario, settings_of(variant));
    const auto b = simulate(turned_round(scenario), settings_of(variant));
    ASSERT_FALSE(a.diverged);
    ASSERT_EQ(a.table.rows(), b.table.rows());
    at_limit += a.metrics.share_at_limit > 0 ? 1 : 0;
    expect_column(a.table, column_x, b.table, column_x, 1);
    expect_column(a.table, column_y, b.table, column_y, 1);
    expect_column(a.table, column_theta, b.table, column_theta, 1, -M_PI);
    expect_column(a.table, column_v, b.table, column_v, -1);
    expect_column(a.table, column_omega, b.table, column_omega, 1);
    expect_column(a.table, column_e_x, b.table, column_e_x, -1);
    expect_column(a.table, column_e_y, b.table, column_e_y, -1);
    expect_column(a.table, column_e_theta, b.table, column_e_theta, 1);
    expect_column(a.table, column_tau_ref_left, b.table, column_tau_ref_right, -1);
    expect_column(a.table, column_tau_fb_left, b.table, column_tau_fb_right, -1);
    expect_column(a.table, column_tau_left, b.table, column_tau_right, -1);
    expect_column(a.table, column_tau_right, b.table, column_tau_left, -1);
    EXPECT_NEAR(a.metrics.cost, b.metrics.cost, tolerance);
  }
  EXPECT_GT(at_limit, 4);
}

TEST(Mirror, LeftAndRightAreAlike) {
  for (const Variant& variant : variants()) {
    Scenario scenario = scenario_of(variant);
    const auto a = simulate(scenario, settings_of(variant));
    const auto b = simulate(mirrored(scenario), settings_of(variant));
    ASSERT_EQ(a.table.rows(), b.table.rows());
    for (const int same : {column_x, column_v, column_e_x}) {
      expect_column(a.table, same, b.table, same, 1);
    }
    for (const int opposite : {column_y, column_theta, column_omega, column_e_y, column_e_theta}) {
      expect_column(a.table, opposite, b.table, opposite, -1);
    }
    expect_column(a.table, column_tau_ref_left, b.table, column_tau_ref_right, 1);
    expect_column(a.table, column_tau_fb_left, b.table, column_tau_fb_right, 1);
    expect_column(a.table, column_tau_left, b.table, column_tau_right, 1);
    expect_column(a.table, column_tau_right, b.table, column_tau_left, 1);
    EXPECT_NEAR(a.metrics.cost, b.metrics.cost, tolerance);
  }
}

TEST(Mirror, CoulombFrictionKeepsBothSymmetries) {
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::exact}) {
    const Variant variant = {Form::positional,    Lateral::direction, AntiWindup::none,
                             Activation::sigmoid, integrator,         HeadingChoice::continuous};
    Scenario scenario = scenario_of(variant);
    scenario.viscous_friction = 0;
    scenario.coulomb_friction = 0.03;
    const auto run = [&](const Scenario& s) { return simulate(s, settings_of(variant)).metrics; };
    EXPECT_NEAR(run(turned_round(scenario)).cost, run(scenario).cost, tolerance);
    EXPECT_NEAR(run(mirrored(scenario)).cost, run(scenario).cost, tolerance);
  }
}

// The laws are laws of `direction` and `speed`: plain e_y steers the wrong way in reverse.
TEST(Mirror, PlainLateralErrorBreaksTheTurningRound) {
  const Variant variant = {Form::positional,    Lateral::plain,    AntiWindup::none,
                           Activation::sigmoid, Integrator::exact, HeadingChoice::forward};
  const Scenario scenario = scenario_of(variant);
  const double ahead = simulate(scenario, settings_of(variant)).metrics.cost;
  const double back = simulate(turned_round(scenario), settings_of(variant)).metrics.cost;
  EXPECT_GT(std::fabs(ahead - back), 1e-3);
}

}  // namespace
}  // namespace nfopidn::test
