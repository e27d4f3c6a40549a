// The exact motion of lanes against that of a single number, step by step.
#include "batch/lanes_motion.hpp"
#include "motion.hpp"

namespace nfopidn::test {
namespace {

using Wide = Lanes<2, 2>;

struct Step {
  State<double> state[Wide::size];
  TorquePair<double> torque[Wide::size];
};

using States = std::array<State<double>, Wide::size>;

template <class Number>
States moved_together(const DifferentialDrive<Number>& plant, const Disturbance<Number>& outside,
                      const Step& step) {
  State<Wide> state;
  TorquePair<Wide> torque;
  for (int lane = 0; lane < Wide::size; ++lane) {
    const State<double>& s = step.state[lane];
    state.x.set(lane, s.x);
    state.y.set(lane, s.y);
    state.theta.set(lane, s.theta);
    state.v.set(lane, s.v);
    state.omega.set(lane, s.omega);
    torque.left.set(lane, step.torque[lane].left);
    torque.right.set(lane, step.torque[lane].right);
  }
  plant.advance(state, math<Wide>::heading(state.theta), torque, &outside);
  States result;
  for (int lane = 0; lane < Wide::size; ++lane) {
    result[static_cast<std::size_t>(lane)] = {state.x.get(lane), state.y.get(lane),
                                              state.theta.get(lane), state.v.get(lane),
                                              state.omega.get(lane)};
  }
  return result;
}

// Lanes with speeds up to `speed` and turning rates up to `turning`, some of them with a wheel or
// both at rest.
Step random_step(Draws& draw, const Robot<double>& robot, double speed, double turning,
                 double torque) {
  Step step;
  for (int lane = 0; lane < Wide::size; ++lane) {
    State<double> s = {draw.between(-2, 2), draw.between(-2, 2), draw.between(-9, 9),
                       draw.between(-speed, speed), draw.between(-turning, turning)};
    const double kind = draw.between(0, 1);
    if (kind < 0.2) s.v = s.omega = 0;
    if (kind > 0.9) s.v = s.omega * robot.track_width * 0.5;
    step.state[lane] = s;
    step.torque[lane] = {draw.between(-torque, torque), draw.between(-torque, torque)};
  }
  return step;
}

struct Case {
  const char* what;
  double viscous, coulomb;
  double speed, turning, torque;
  double scrub = 0, dry_scrub = 0;  // viscous, Coulomb
};

constexpr Case cases[] = {
    {"on a path", 0, 0, 0.5, 2, 0.5},
    {"saturated", 0, 0, 2, 8, 3},
    {"spinning", 0, 0, 1, 90, 3},
    {"viscous", 0.02, 0, 0.5, 2, 0.5},
    {"viscous, spinning", 0.3, 0, 1, 40, 3},
    {"friction", 0, 0.1, 0.5, 2, 0.3},
    {"much friction", 0, 0.6, 0.1, 0.5, 0.7},
    {"friction, spinning", 0, 0.2, 1, 40, 3},
    {"both frictions", 0.02, 0.1, 0.5, 2, 0.3},
    {"much of both", 0.1, 0.6, 0.1, 0.5, 0.7},
    {"both, spinning", 0.02, 0.2, 1, 40, 3},
    {"relaxing at once", 4, 0.3, 0.5, 2, 2},
    {"scrub", 0, 0, 0.5, 2, 0.5, 0.1},
    {"scrub and friction", 0, 0.1, 0.5, 2, 0.3, 0.1},
    {"much scrub", 0, 0.6, 0.1, 0.5, 0.7, 2},
    {"scrub and both frictions", 0.02, 0.1, 0.5, 2, 0.3, 0.2},
    {"dry scrub", 0, 0, 0.5, 0.5, 0.5, 0, 0.3},
    {"dry scrub and friction", 0, 0.1, 0.3, 0.5, 0.3, 0, 0.2},
    {"much dry scrub", 0, 0.3, 0.1, 0.5, 0.7, 0, 0.8},
    {"all kinds", 0.02, 0.1, 0.3, 0.5, 0.3, 0.1, 0.2},
    {"all kinds, relaxing at once", 4, 0.3, 0.5, 2, 2, 2, 0.5},
    {"all kinds, spinning", 0.02, 0.2, 1, 40, 3, 0.1, 0.2},
};

template <class Check>
void for_each_step(const Check& check) {
  Draws draw(31);
  for (const Case& one : cases) {
    for (int i = 0; i < 600; ++i) {
      const Robot<double> robot = some_robots()[static_cast<std::size_t>(i % 3)];
      const DifferentialDrive<double> plant(
          robot, {one.viscous, one.coulomb, one.scrub, one.dry_scrub}, Integrator::exact,
          i % 5 == 0 ? 0.02 : 0.2, i % 7 == 0 ? 3 : 1);
      const Disturbance<double> outside = {draw.between(-1, 1), draw.between(-0.2, 0.2)};
      check(one, plant, outside, random_step(draw, robot, one.speed, one.turning, one.torque),
            draw);
    }
  }
}

TEST(LanesMotion, IsThatOfASingleNumber) {
  int stops = 0, straight = 0;
  for_each_step([&](const Case& one, const DifferentialDrive<double>& plant,
                    const Disturbance<double>& outside, const Step& step, Draws&) {
    const auto together = moved_together(plant, outside, step);
    for (int lane = 0; lane < Wide::size; ++lane) {
      State<double> alone = step.state[lane];
      plant.advance(alone, math<double>::heading(alone.theta), step.torque[lane], &outside);
      ASSERT_LE(largest_difference(together[static_cast<std::size_t>(lane)], alone), 1e-12)
          << one.what;
      if (one.coulomb > 0 && alone.v * step.state[lane].v < 0) ++stops;
      if (one.dry_scrub > 0 && alone.omega == 0 && alone.v != 0) ++straight;
    }
  });
  EXPECT_GT(stops, 300);
  EXPECT_GT(straight, 300);
}

TEST(LanesMotion, DoesNotDependOnTheNeighbours) {
  for_each_step([](const Case& one, const DifferentialDrive<double>& plant,
                   const Disturbance<double>& outside, const Step& step, Draws& draw) {
    const auto together = moved_together(plant, outside, step);
    Step other = random_step(draw, Robot<double>::eddie(), 3, draw.between(0, 30), 3);
    other.state[2] = step.state[2];
    other.torque[2] = step.torque[2];
    ASSERT_EQ(largest_difference(moved_together(plant, outside, other)[2], together[2]), 0)
        << one.what;
  });
}

// A robot, friction and a disturbance a lane.
struct OwnRobots {
  Robot<double> robot[Wide::size];
  Friction<double> friction[Wide::size];
  Disturbance<double> outside[Wide::size];

  OwnRobots(Draws& draw, const Case& one) {
    for (int lane = 0; lane < Wide::size; ++lane) {
      const auto kind = static_cast<std::size_t>(draw.between(0, 3));
      robot[lane] = some_robots()[std::min<std::size_t>(kind, 2)];
      robot[lane].mass *= draw.between(0.8, 1.2);
      // Some lanes slide freely; with viscous friction are all, or none.
      const double share = draw.between(0, 1) < 0.3 ? 0 : draw.between(0.5, 1);
      const double part = draw.between(0.5, 1);
      friction[lane] = {one.viscous * part, one.coulomb * share, one.scrub * part,
                        one.dry_scrub * part};
      outside[lane] = {draw.between(-1, 1), draw.between(-0.2, 0.2)};
    }
  }

  States moved(const Step& step, double dt, int substeps,
               Integrator integrator = Integrator::exact) const {
    Robot<Wide> robots;
    Friction<Wide> frictions;
    Disturbance<Wide> disturbances;
    for (int lane = 0; lane < Wide::size; ++lane) {
      robots.mass.set(lane, robot[lane].mass);
      robots.inertia.set(lane, robot[lane].inertia);
      robots.track_width.set(lane, robot[lane].track_width);
      robots.wheel_radius.set(lane, robot[lane].wheel_radius);
      frictions.viscous.set(lane, friction[lane].viscous);
      frictions.coulomb.set(lane, friction[lane].coulomb);
      frictions.scrub_viscous.set(lane, friction[lane].scrub_viscous);
      frictions.scrub_coulomb.set(lane, friction[lane].scrub_coulomb);
      disturbances.force.set(lane, outside[lane].force);
      disturbances.moment.set(lane, outside[lane].moment);
    }
    const DifferentialDrive<Wide> plant(robots, frictions, integrator, dt, substeps);
    return moved_together(plant, disturbances, step);
  }
};

TEST(LanesMotion, OfARobotEachIsThatOfASingleNumber) {
  Draws draw(32);
  int some_stop = 0;
  for (const Case& one : cases) {
    for (int i = 0; i < 600; ++i) {
      const double dt = i % 5 == 0 ? 0.02 : 0.2;
      const int substeps = i % 7 == 0 ? 3 : 1;
      const OwnRobots own(draw, one);
      const Step step = random_step(draw, own.robot[0], one.speed, one.turning, one.torque);
      const States together = own.moved(step, dt, substeps);
      int stops = 0;
      for (int lane = 0; lane < Wide::size; ++lane) {
        const DifferentialDrive<double> plant(own.robot[lane], own.friction[lane],
                                              Integrator::exact, dt, substeps);
        State<double> alone = step.state[lane];
        plant.advance(alone, math<double>::heading(alone.theta), step.torque[lane],
                      &own.outside[lane]);
        ASSERT_LE(largest_difference(together[static_cast<std::size_t>(lane)], alone), 1e-12)
            << one.what;
        if (own.friction[lane].coulomb > 0 && alone.v * step.state[lane].v < 0) ++stops;
      }
      some_stop += stops > 0 && stops < Wide::size ? 1 : 0;
      OwnRobots other(draw, one);
      other.robot[2] = own.robot[2];
      other.friction[2] = own.friction[2];
      other.outside[2] = own.outside[2];
      Step beside = random_step(draw, own.robot[0], 3, draw.between(0, 30), 3);
      beside.state[2] = step.state[2];
      beside.torque[2] = step.torque[2];
      ASSERT_EQ(largest_difference(other.moved(beside, dt, substeps)[2], together[2]), 0)
          << one.what;
    }
  }
  EXPECT_GT(some_stop, 300);
}

// Nor does it matter to a lane without Coulomb scrub whether others have it.
TEST(LanesMotion, OneThatDoesNotScrubMovesAsAmongItsLike) {
  Draws draw(34);
  for (int i = 0; i < 600; ++i) {
    OwnRobots own(draw, cases[i % 2 == 0 ? 9 : 15]);
    const Step step = random_step(draw, own.robot[0], 0.5, 0.5, 0.3);
    const State<double> alike = own.moved(step, 0.2, 1)[2];
    own.friction[1].scrub_coulomb = 0.2;
    own.friction[3].scrub_coulomb = 0.05;
    ASSERT_EQ(largest_difference(own.moved(step, 0.2, 1)[2], alike), 0);
  }
}

// The Euler step has Coulomb scrub in lanes too, some of which have none.
TEST(LanesMotion, ScrubsAsASingleNumberDoesInAnEulerStep) {
  Draws draw(33);
  int straight = 0;
  for (int i = 0; i < 2000; ++i) {
    OwnRobots own(draw, cases[5]);
    for (int lane = 0; lane < Wide::size; ++lane) {
      own.friction[lane].scrub_coulomb = lane == 1 ? 0 : draw.between(0, 0.2);
      own.friction[lane].scrub_viscous = draw.between(0, 0.1);
    }
    const Step step = random_step(draw, own.robot[0], 0.5, 0.2, 0.3);
    const States together = own.moved(step, 0.2, 2, Integrator::semi_implicit_euler);
    for (int lane = 0; lane < Wide::size; ++lane) {
      const DifferentialDrive<double> plant(own.robot[lane], own.friction[lane],
                                            Integrator::semi_implicit_euler, 0.2, 2);
      State<double> alone = step.state[lane];
      plant.advance(alone, math<double>::heading(alone.theta), step.torque[lane],
                    &own.outside[lane]);
      ASSERT_LE(largest_difference(together[static_cast<std::size_t>(lane)], alone), 1e-14);
      straight += alone.omega == 0 && alone.v != 0 ? 1 : 0;
    }
  }
  EXPECT_GT(straight, 300);
}

// However fast a lane spins, its step ends, and is no longer than its way.
TEST(LanesMotion, EndsWhateverTheSpin) {
  const DifferentialDrive<double> plant(Robot<double>::eddie(), {0, 0}, Integrator::exact, 0.2, 1);
  for (const double omega : {1e3, 1e5, 1e9, 1e200}) {
    Step step = {};
    step.state[1] = {0, 0, 0, 1, omega};
    const auto end = moved_together<double>(plant, {0, 0}, step);
    EXPECT_LE(std::hypot(end[1].x, end[1].y), 0.2001) << omega;
    EXPECT_EQ(end[0].x, 0);
  }
}

}  // namespace
}  // namespace nfopidn::test
