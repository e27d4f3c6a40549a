// The rivals' laws against closed forms, and what they share.
#include <gtest/gtest.h>

#include "nfopidn/io/json_rival.hpp"
#include "nfopidn/rivals/tuning.hpp"
#include "support.hpp"

namespace nfopidn::rivals {
namespace {

using test::Draws;

const Model<double> model = {Robot<double>::eddie(), 0.2, 0.335};

ReferenceSample<double> drawn_reference(Draws& draws) {
  return {0, 0, 0, draws.between(-0.5, 0.5), draws.between(-1, 1), 0, 0, false};
}

View<double> drawn_view(Draws& draws, const ReferenceSample<double>& reference) {
  return {{draws.between(-1, 1), draws.between(-1, 1), draws.between(-3, 3)},
          {draws.between(-0.5, 0.5), draws.between(-1, 1)},
          reference,
          {draws.between(-0.2, 0.2), draws.between(-0.5, 0.5)}};
}

// The same a short time later, if the robot's accelerations are `own`.
View<double> later(const View<double>& view, const Accelerations<double>& own, double time,
                   ReferenceSample<double>& reference) {
  const Channels<double> rate = error_rates(view);
  reference = view.reference;
  reference.v += time * view.acceleration.linear;
  reference.omega += time * view.acceleration.angular;
  return {{view.error.x + time * rate.x, view.error.y + time * rate.y,
           view.error.theta + time * rate.theta},
          {view.speed.v + time * own.linear, view.speed.omega + time * own.angular},
          reference,
          view.acceleration};
}

TEST(RivalErrors, ChangeAsTheirRatesSay) {
  Draws draws(1);
  for (int n = 0; n < 50; ++n) {
    const ReferenceSample<double> reference = {draws.between(-1, 1),
                                               draws.between(-1, 1),
                                               draws.between(-3, 3),
                                               draws.between(-1, 1),
                                               draws.between(-1, 1),
                                               0,
                                               0,
                                               false};
    const Measurement<double> pose = {draws.between(-1, 1), draws.between(-1, 1),
                                      reference.theta + draws.between(-1, 1), draws.between(-1, 1),
                                      draws.between(-1, 1)};
    const auto errors = [&](double time) {
      ReferenceSample<double> r = reference;
      r.x += time * r.v * std::cos(r.theta);
      r.y += time * r.v * std::sin(r.theta);
      r.theta += time * r.omega;
      Measurement<double> m = pose;
      m.x += time * m.v * std::cos(m.theta);
      m.y += time * m.v * std::sin(m.theta);
      m.theta += time * m.omega;
      return rotate_into_robot(world_errors(m, r), math<double>::heading(m.theta));
    };
    const Channels<double> rate =
        error_rates(View<double>{errors(0), {pose.v, pose.omega}, reference, {0, 0}});
    const Channels<double> before = errors(-1e-6);
    const Channels<double> after = errors(1e-6);
    EXPECT_NEAR(rate.x, (after.x - before.x) / 2e-6, 1e-8);
    EXPECT_NEAR(rate.y, (after.y - before.y) / 2e-6, 1e-8);
    EXPECT_NEAR(rate.theta, (after.theta - before.theta) / 2e-6, 1e-8);
  }
}

TEST(RivalLaws, AreTheEquationsOfTheirSources) {
  Draws draws(2);
  for (int n = 0; n < 50; ++n) {
    const ReferenceSample<double> r = drawn_reference(draws);
    const View<double> view = drawn_view(draws, r);
    const auto& e = view.error;
    const double x = draws.between(0, 5), y = draws.between(0, 50), theta = draws.between(0, 5);

    Samson<double>::Settings linear;
    linear.k_x = x;
    linear.k_y = y;
    linear.k_theta = theta;
    const Velocity<double> samson = Samson<double>(linear, model).command(view);
    EXPECT_NEAR(samson.v, r.v * std::cos(e.theta) + x * e.x, 1e-12);
    EXPECT_NEAR(samson.omega, r.omega + y * r.v * e.y + theta * e.theta, 1e-12);

    KanayamaGains gains;
    gains.k_x = x;
    gains.k_y = y;
    gains.k_theta = theta;
    const Velocity<double> kanayama = Kanayama<double>(gains, model).command(view);
    EXPECT_NEAR(kanayama.v, r.v * std::cos(e.theta) + x * e.x, 1e-12);
    EXPECT_NEAR(kanayama.omega, r.omega + r.v * (y * e.y + theta * std::sin(e.theta)), 1e-11);

    Ramsete<double>::Settings nonlinear;
    nonlinear.b = y;
    nonlinear.zeta = x;
    const double k = 2 * x * std::sqrt(r.omega * r.omega + y * r.v * r.v);
    const Velocity<double> ramsete = Ramsete<double>(nonlinear, model).command(view);
    EXPECT_NEAR(ramsete.v, r.v * std::cos(e.theta) + k * e.x, 1e-11);
    EXPECT_NEAR(ramsete.omega, r.omega + k * e.theta + y * r.v * std::sin(e.theta) / e.theta * e.y,
                1e-11);
  }
}

TEST(RivalLaws, RamseteHasNoHoleAtNoHeadingError) {
  const ReferenceSample<double> r = {0, 0, 0, 0.3, 0, 0, 0, false};
  const View<double> view = {{0, 0.5, 0}, {0.3, 0}, r, {0, 0}};
  Ramsete<double>::Settings settings;
  EXPECT_DOUBLE_EQ(Ramsete<double>(settings, model).command(view).omega, settings.b * 0.3 * 0.5);
}

TEST(FierroLewis, AddsTheRateOfKanayamasVelocities) {
  Draws draws(3);
  FierroLewis<double>::Settings settings;
  for (int n = 0; n < 50; ++n) {
    const ReferenceSample<double> r = drawn_reference(draws);
    const View<double> view = drawn_view(draws, r);
    const Kanayama<double> kinematics(settings, model);
    ReferenceSample<double> moved{};
    const auto command = [&](double time) {
      return kinematics.command(later(view, {0, 0}, time, moved));
    };
    const Velocity<double> before = command(-1e-6), now = command(0), after = command(1e-6);
    const Accelerations<double> wanted = FierroLewis<double>(settings, model).feedback(view);
    EXPECT_NEAR(wanted.linear + view.acceleration.linear,
                (after.v - before.v) / 2e-6 + settings.k_4 * (now.v - view.speed.v), 1e-6);
    EXPECT_NEAR(wanted.angular + view.acceleration.angular,
                (after.omega - before.omega) / 2e-6 + settings.k_4 * (now.omega - view.speed.omega),
                1e-6);
  }
}

TEST(SlidingMode, BringsItsSurfacesDownAtTheRateItPromises) {
  Draws draws(4);
  SlidingMode<double>::Settings s;
  s.q_x = 0.7;
  s.q_theta = 1.3;
  const auto surfaces = [&](const View<double>& view) {
    const Channels<double> rate = error_rates(view);
    return std::array<double, 2>{rate.x + s.lambda_x * view.error.x,
                                 rate.theta + s.lambda_theta * view.error.theta +
                                     s.lambda_y * view.reference.v * view.error.y};
  };
  for (int n = 0; n < 50; ++n) {
    const ReferenceSample<double> r = drawn_reference(draws);
    const View<double> view = drawn_view(draws, r);
    const Accelerations<double> beyond = SlidingMode<double>(s, model).feedback(view);
    const Accelerations<double> own = {beyond.linear + view.acceleration.linear,
                                       beyond.angular + view.acceleration.angular};
    ReferenceSample<double> a{}, b{};
    const auto before = surfaces(later(view, own, -1e-6, a));
    const auto after = surfaces(later(view, own, 1e-6, b));
    const auto now = surfaces(view);
    const auto promised = [&](double surface, double q, double p) {
      return -q * surface - p * std::fmax(-1, std::fmin(1, surface / s.boundary));
    };
    EXPECT_NEAR((after[0] - before[0]) / 2e-6, promised(now[0], s.q_x, s.p_x), 1e-6);
    EXPECT_NEAR((after[1] - before[1]) / 2e-6, promised(now[1], s.q_theta, s.p_theta), 1e-6);
  }
}

TEST(TakagiSugeno, IsOneRulesLawInItsCorner) {
  TakagiSugeno<double>::Settings s;
  s.k_x_fast_aligned = 3;
  s.k_y_fast_aligned = 7;
  s.k_theta_fast_aligned = 2;
  const ReferenceSample<double> fast = {0, 0, 0, model.peak_speed, 0.1, 0, 0, false};
  const View<double> aligned = {{0.2, 0.3, 0}, {0, 0}, fast, {0, 0}};
  const Velocity<double> one = TakagiSugeno<double>(s, model).command(aligned);
  EXPECT_NEAR(one.v, fast.v + 3 * 0.2, 1e-12);
  EXPECT_NEAR(one.omega, 0.1 + 7 * fast.v * 0.3, 1e-12);

  const ReferenceSample<double> still = {0, 0, 0, 0, 0.1, 0, 0, false};
  const View<double> misalignment = {{0.2, 0.3, 2}, {0, 0}, still, {0, 0}};
  const Velocity<double> other = TakagiSugeno<double>(s, model).command(misalignment);
  EXPECT_NEAR(other.v, s.k_x_slow_askew * 0.2, 1e-12);
  EXPECT_NEAR(other.omega, 0.1 + s.k_theta_slow_askew * 2, 1e-12);

  // Half way between all four.
  const double half = std::acos(0.5);
  const ReferenceSample<double> slower = {0, 0, 0, model.peak_speed / 2, 0, 0, 0, false};
  const View<double> between = {{1, 0, half}, {0, 0}, slower, {0, 0}};
  const double mean =
      (s.k_x_slow_aligned + s.k_x_slow_askew + s.k_x_fast_aligned + s.k_x_fast_askew) / 4;
  EXPECT_NEAR(TakagiSugeno<double>(s, model).command(between).v, slower.v * 0.5 + mean, 1e-12);
}

TEST(Lqr, SolvesTheRiccatiEquation) {
  Draws draws(5);
  for (int n = 0; n < 30; ++n) {
    Eigen::Matrix2d a = Eigen::Matrix2d::Identity();
    a(0, 1) = draws.between(0.01, 0.2);
    const Eigen::Vector2d b(draws.between(0, 0.05), 0.2);
    const Eigen::Matrix2d q =
        Eigen::Vector2d(draws.between(0.1, 100), draws.between(0, 9)).asDiagonal();
    const double r = draws.between(0.1, 10);
    const Eigen::Matrix2d p = riccati<double>(a, b, q, r);
    const Eigen::Vector2d reply = a.transpose() * p * b;
    const Eigen::Matrix2d rest =
        a.transpose() * p * a - p + q - reply * reply.transpose() / (r + b.dot(p * b));
    EXPECT_LT(rest.norm(), 1e-11 * p.norm());
    // And it is the stabilising solution, by Jury's conditions.
    const Eigen::Matrix2d closed = a - b * (b.transpose() * p * a) / (r + b.dot(p * b));
    const double product = closed(0, 0) * closed(1, 1) - closed(0, 1) * closed(1, 0);
    EXPECT_LT(std::fabs(product), 1);
    EXPECT_LT(std::fabs(closed.trace()), 1 + product);
  }
}

TEST(Lqr, TurnsItsLateralGainRoundInReverse) {
  const Lqr<double> law(LqrTolerances<double>{}, model);
  for (const double v : {0.003, 0.1, 0.123, 0.3349}) {
    EXPECT_GT(law.gains(v).k_y, 0);
    EXPECT_EQ(law.gains(-v).k_y, -law.gains(v).k_y);
    EXPECT_EQ(law.gains(-v).k_theta, law.gains(v).k_theta);
  }
  const LqrGains<double> exact = lqr_gains(LqrTolerances<double>{}, 0.12, model.dt);
  EXPECT_NEAR(law.gains(0.12).k_y, exact.k_y, 1e-9 * exact.k_y);
  // Beyond the table its last value stands.
  EXPECT_EQ(law.gains(5).k_y, law.gains(50).k_y);
}

TEST(Lqr, FeedsItsGainsBackOnTheReferencesVelocities) {
  const Lqr<double> law(LqrTolerances<double>{}, model);
  for (const double v : {-0.2, 0.1, 0.3}) {
    const ReferenceSample<double> reference = {0, 0, 0, v, 0.4, 0, 0, v < 0};
    const Channels<double> error = {0.01, -0.02, 0.03};
    const Velocity<double> command = law.command({error, {0, 0}, reference, {0, 0}});
    const LqrGains<double> k = law.gains(v);
    EXPECT_NEAR(command.v, v + k.k_x * 0.01, 1e-15);
    EXPECT_NEAR(command.omega, 0.4 - k.k_y * 0.02 + k.k_theta * 0.03, 1e-15);
  }
}

TEST(Rival, LimitsTheTotalTorqueAndTellsTheUnlimitedPart) {
  VelocityLoop<Samson<double>>::Settings settings;
  settings.k_v = 10;
  Rival<VelocityLoop<Samson<double>>> rival({settings, model}, model, 1.5, Speeds::measured);
  const ReferenceSample<double> reference = {1, 0, 0, 0.3, 0, 0.2, 0.1, false};
  const TorquePair<double> torque = rival.step({0, 0, 0, 0, 0}, reference);
  const double force = 10 * (0.3 + settings.k_x) * model.robot.mass * model.robot.wheel_radius;
  EXPECT_NEAR(rival.feedback().left, force / 2, 1e-12);
  EXPECT_EQ(torque.left, 1.5);
  EXPECT_EQ(torque.right, 1.5);
  rival.reset();
  EXPECT_EQ(rival.feedback().left, 0);
}

TEST(Rival, ResetForgetsTheLastPose) {
  Rival<VelocityLoop<Samson<double>>> rival({{}, model}, model, 100, Speeds::differenced);
  const ReferenceSample<double> reference = {1, 0, 0, 0.3, 0, 0, 0, false};
  const TorquePair<double> first = rival.step({0, 0, 0, 0, 0}, reference);
  const TorquePair<double> second = rival.step({0.1, 0, 0, 0, 0}, reference);
  EXPECT_NE(first.left, second.left);
  rival.reset();
  EXPECT_EQ(rival.step({0, 0, 0, 0, 0}, reference).left, first.left);
}

TEST(Rivals, AreFoundByNameAndWrittenWhole) {
  EXPECT_EQ(law_names().size(), law_count);
  for (std::size_t law = 0; law < law_count; ++law) {
    RivalDesign design;
    design.law = law;
    design.parameters = default_parameters(law);
    design.parameters[0] *= 0.5;
    design.speeds = Speeds::differenced;
    design.robot = Robot<double>::eddie_datasheet();
    RivalDesign read;
    ASSERT_TRUE(read_rival(write_rival(design), read));
    EXPECT_EQ(write_rival(read), write_rival(design));
    EXPECT_EQ(read.parameters, design.parameters);
    EXPECT_EQ(law_bounds(law).size(), design.parameters.size());
  }
}

TEST(RivalObjective, IsTheCostOfTheRunOnAnyNumberOfThreads) {
  const Scenario first = Scenario::published();
  Scenario second = Scenario::published();
  second.delay = 1;
  RivalDesign design;
  const std::vector<ParameterBounds> bounds = law_bounds(design.law);
  const auto size = static_cast<Eigen::Index>(bounds.size());
  Points points(size, 7);
  Draws draws(6);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    for (Eigen::Index i = 0; i < size; ++i) points(i, j) = draws.between(0, 3);
  }
  std::vector<double> alone(7), together(7);
  const FreeParameters all = FreeParameters::all(bounds.size());
  RivalObjective({&first, &second}, design, all, static_cast<int>(size), 1, 1)
      .costs(points, alone.data());
  RivalObjective({&first, &second}, design, all, static_cast<int>(size), 1, 3)
      .costs(points, together.data());
  EXPECT_EQ(alone, together);
  design.parameters.assign(points.col(3).data(), points.col(3).data() + size);
  const double mean =
      (simulate(first, design).metrics.cost + simulate(second, design).metrics.cost) / 2;
  EXPECT_NEAR(alone[3], mean, 1e-12 * mean);
}

// Fast references have a coarser table, up to their peak all the same.
TEST(LqrGains, ReachThePeakSpeed) {
  const LqrTolerances<double> tolerances;
  for (const double peak : {0.335, 9.99, 40.0, 1e3, 1e9}) {
    const Lqr<double> law(tolerances, {Robot<double>::eddie(), 0.2, peak});
    const LqrGains<double> exact = lqr_gains(tolerances, peak, 0.2);
    EXPECT_NEAR(law.gains(peak).k_y, exact.k_y, 1e-3 * exact.k_y) << peak;
    EXPECT_NEAR(law.gains(-peak).k_y, -exact.k_y, 1e-3 * exact.k_y) << peak;
    EXPECT_EQ(law.gains(2 * peak).k_x, law.gains(3 * peak).k_x) << peak;
  }
}

}  // namespace
}  // namespace nfopidn::rivals
