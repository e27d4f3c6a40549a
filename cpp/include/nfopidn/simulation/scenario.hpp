// L3. A scenario: everything about a run but the controller.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/loop/delay_line.hpp"
#include "nfopidn/plant/feedforward.hpp"
#include "nfopidn/plant/motor.hpp"
#include "nfopidn/simulation/samples.hpp"

namespace nfopidn {

// At the start: given, or the reference's own.
struct InitialVelocity {
  bool reference = false;
  std::array<double, 2> value = {0, 0};  // v [m/s], omega [rad/s]
};

// Where the noise comes from: one sequence of draws, or each sample's by its number.
enum class NoiseSource : unsigned char { mersenne, counter };

template <>
struct ChoiceNames<NoiseSource> {
  static constexpr const char* names[] = {"mersenne", "counter"};
};

struct Scenario {
  Trajectory trajectory;
  Robot<double> robot;
  // The robot that the reference torques are computed for, where it is not the true one.
  std::optional<Robot<double>> model;
  // What gives the torques; none: they arrive as they are commanded.
  std::optional<Motor<double>> motor;
  std::optional<std::array<double, 3>> initial_pose;  // x, y [m], theta [rad]
  InitialVelocity initial_velocity;
  double torque_limit = 3.078;  // [N m]
  bool feedforward = true;
  std::optional<double> feedforward_limit;  // [N m]; none: the reference torques as they are
  // Friction of each wheel that the reference torques make up for: viscous [N m s/rad], Coulomb
  // [N m], and the wheel speed [rad/s] that smooths the latter at standstill.
  std::array<double, 2> friction_feedforward = {0, 0};
  double friction_feedforward_speed = FrictionFeedforward<double>{}.speed;
  Integrator integrator = Integrator::semi_implicit_euler;
  int substeps = 1;
  // Force [N] and moment [N m]: one pair for the whole run, or one a sample.
  std::vector<std::array<double, 2>> disturbance = {{0, 0}};
  double viscous_friction = 0;
  double coulomb_friction = 0;
  double viscous_scrub = 0;  // moments that oppose turning: [N m s/rad], [N m]
  double coulomb_scrub = 0;
  std::array<double, 2> pose_noise = {0, 0};
  int encoder_counts = 0;  // a revolution of a wheel; 0: the pose is measured
  // Relative, of the left and the right wheel's radius and of the track, as odometry has them.
  std::array<double, 3> odometry_errors = {0, 0, 0};
  int delay = 0;
  double divergence_distance = 10;
  std::array<double, 3> cost_weights = {1, 1, 1};  // of position, heading and torque errors
  std::uint64_t seed = 0;
  NoiseSource noise_source = NoiseSource::mersenne;

  // The scenario of the paper's figures, as it can be read (docs/reproduction.md).
  static Scenario published() {
    Scenario scenario;
    make_trajectory(TrajectorySettings{}, scenario.trajectory);
    scenario.initial_pose = {4.0, 0.0, 1.0472};
    return scenario;
  }

  // The robot that the feedforward and the controller's gains are made for.
  const Robot<double>& modelled_robot() const { return model.has_value() ? *model : robot; }

  // All but trajectory and robot, which have fields of their own.
  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using S = Scenario;
    visit(field("initial_pose", &S::initial_pose, "m, m, rad", between(-1e9, 1e9),
                "pose x, y, theta at the start; null (in words: reference): the reference's",
                "pose"));
    visit(field("initial_velocity", &S::initial_velocity, "m/s, rad/s", between(-1e3, 1e3),
                "v, omega at the start, or \"reference\"", "velocity"));
    visit(field("torque_limit", &S::torque_limit, "N m", between(1e-6, 1e6),
                "limit of each wheel's total torque"));
    visit(field("feedforward", &S::feedforward, "", any_number(),
                "the controller adds the reference torques"));
    visit(field("integrator", &S::integrator, "", any_number(), "of the robot's motion"));
    visit(field("substeps", &S::substeps, "", between(1, 10000), "integration steps in a sample"));
    visit(field("disturbance", &S::disturbance, "N, N m", between(-1e6, 1e6),
                "force along the robot and moment, constant or one pair a sample"));
    visit(field("viscous_friction", &S::viscous_friction, "N m s/rad", between(0, 1e3),
                "viscous friction at each wheel", "viscous"));
    visit(field("coulomb_friction", &S::coulomb_friction, "N m", between(0, 1e3),
                "Coulomb friction at each wheel", "coulomb"));
    visit(field("pose_noise", &S::pose_noise, "m, rad", between(0, 1e3),
                "standard deviations of measured position and heading", "noise"));
    visit(field("delay", &S::delay, "samples", between(0, maximum_delay),
                "from measurement to applied torque"));
    visit(field("divergence_distance", &S::divergence_distance, "m", between(1e-3, 1e6),
                "a run further than this from its reference has diverged"));
    visit(field("seed", &S::seed, "", between(0, 9007199254740992.0), "of the random draws"));
    visit(field("model", &S::model, "kg, kg m^2, m, m", any_number(),
                "robot that feedforward torques are computed for; null (in words: robot): the "
                "true one"));
    visit(field("motor", &S::motor, "ohm, N m/A, V s/rad, , kg m^2, N m s/rad, N m, V, V",
                any_number(),
                "behind each wheel, which turns torques into voltages; null (in words: none): "
                "torques arrive as they are commanded"));
    visit(field("encoder_counts", &S::encoder_counts, "", between(0, 1e6),
                "of each wheel's encoder in a revolution, from which odometry makes the pose that "
                "the controller is shown; 0: the pose is measured"));
    visit(field("odometry_errors", &S::odometry_errors, "", between(-0.5, 0.5),
                "relative errors of the left and the right wheel's radius and of the track, as "
                "odometry has them"));
    visit(field("feedforward_limit", &S::feedforward_limit, "N m", between(1e-6, 1e6),
                "limit of each wheel's reference torque; null (in words: none): no limit"));
    visit(field("friction_feedforward", &S::friction_feedforward, "N m s/rad, N m", between(0, 1e3),
                "viscous and Coulomb friction of each wheel that the reference torques make up "
                "for"));
    visit(field("friction_feedforward_speed", &S::friction_feedforward_speed, "rad/s",
                between(1e-6, 1e6),
                "wheel speed at which 76 % of the Coulomb friction are made up for"));
    visit(field("viscous_scrub", &S::viscous_scrub, "N m s/rad", between(0, 1e3),
                "moment that opposes turning, in proportion to the turning rate"));
    visit(field("coulomb_scrub", &S::coulomb_scrub, "N m", between(0, 1e3),
                "moment that opposes turning at any rate, and up to which the heading holds"));
    visit(
        field("cost_weights", &S::cost_weights, "", between(1e-6, 1e6),
              "of the squares of position [m], heading [rad] and torque errors [N m] in the cost; "
              "eq. 41 has 1 for each"));
    visit(
        field("noise_source", &S::noise_source, "", any_number(),
              "of the draws: one sequence, or each by its number, as Monte Carlo runs have them"));
  }
};

namespace detail {

inline State<double> start_state(const Scenario& scenario) {
  const Trajectory& t = scenario.trajectory;
  const std::array<double, 3> pose =
      scenario.initial_pose.value_or(std::array<double, 3>{t.x(0), t.y(0), t.theta(0)});
  const InitialVelocity& velocity = scenario.initial_velocity;
  const std::array<double, 2> speeds =
      velocity.reference ? std::array<double, 2>{t.v(0), t.omega(0)} : velocity.value;
  return {pose[0], pose[1], pose[2], speeds[0], speeds[1]};
}

}  // namespace detail

// What is wrong with a scenario as a whole, its fields each being in range.
NFOPIDN_HOST Finding check_consistency(const Scenario& scenario);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST Finding check_consistency(const Scenario& scenario) {
  const Trajectory& t = scenario.trajectory;
  const auto samples = static_cast<std::size_t>(t.size());
  if (samples < minimum_samples) {
    return {Status::wrong_size, "trajectory", static_cast<double>(samples),
            between(minimum_samples, maximum_samples)};
  }
  const std::size_t disturbances = scenario.disturbance.size();
  if (disturbances != 1 && disturbances != samples) {
    return {Status::wrong_size, "disturbance", static_cast<double>(disturbances),
            between(static_cast<double>(samples), static_cast<double>(samples))};
  }
  const State<double> start = detail::start_state(scenario);
  // The field's range is that of positions: as far as those of a path.
  const Range angle_range = between(-1e6, 1e6);
  if (scenario.initial_pose.has_value() && !angle_range.contains(start.theta)) {
    return {Status::out_of_range, "initial_pose", start.theta, angle_range};
  }
  const double distance = std::hypot(start.x - t.x(0), start.y - t.y(0));
  if (distance > scenario.divergence_distance) {
    return {Status::inconsistent, "initial_pose", distance,
            between(0, scenario.divergence_distance)};
  }
  return {};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
