// L3. A scenario made ready to run: what the loop takes of it, sample by sample.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/loop/closed_loop.hpp"
#include "nfopidn/math/counter_noise.hpp"
#include "nfopidn/math/random.hpp"
#include "nfopidn/parallel/interruption.hpp"
#include "nfopidn/plant/feedforward.hpp"
#include "nfopidn/plant/robot_drive.hpp"
#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn {

// A scenario made ready to run: samples as the loop takes them.
struct PreparedRun {
  std::vector<ReferenceSample<double>> reference;
  std::vector<Measurement<double>> noise;  // empty without noise
  std::vector<Disturbance<double>> disturbance;
  std::optional<Encoders<double>> encoders;
  State<double> start;
  RobotDrive<double> plant;
  ControlLimits<double> limits;
  LoopInputs<double> inputs() const;
  // The cosine and sine of each reference heading, which the lanes take.
  std::vector<Heading<double>> reference_headings() const {
    std::vector<Heading<double>> headings;
    headings.reserve(reference.size());
    for (const auto& sample : reference) headings.push_back(math<double>::heading(sample.theta));
    return headings;
  }
  // How this thread's present work is interrupted.
  Poll poll() const { return Interruption::poll(scenario->substeps); }
  const Scenario* scenario;
};

namespace detail {

// What is fed forward, and what eq. 41 compares the torque with.
inline TorquePair<double> reference_torque(const Scenario& scenario, Eigen::Index k) {
  const Trajectory& t = scenario.trajectory;
  const std::array<double, 2>& friction = scenario.friction_feedforward;
  TorquePair<double> torque = reference_torques(
      scenario.modelled_robot(), {friction[0], friction[1], scenario.friction_feedforward_speed},
      t.v(k), t.omega(k), t.acceleration(k), t.turn_acceleration(k));
  if (const std::optional<double>& limit = scenario.feedforward_limit) {
    torque.left = std::clamp(torque.left, -*limit, *limit);
    torque.right = std::clamp(torque.right, -*limit, *limit);
  }
  return torque;
}

inline ReferenceSample<double> reference_sample(const Scenario& scenario, Eigen::Index k) {
  const Trajectory& t = scenario.trajectory;
  const TorquePair<double> torque = reference_torque(scenario, k);
  return {t.x(k),     t.y(k),      t.theta(k),   t.v(k),
          t.omega(k), torque.left, torque.right, t.reverse[static_cast<std::size_t>(k)] != 0};
}

inline Friction<double> friction_of(const Scenario& scenario) {
  return {scenario.viscous_friction, scenario.coulomb_friction, scenario.viscous_scrub,
          scenario.coulomb_scrub};
}

inline RobotDrive<double> robot_drive(const Scenario& scenario) {
  return {
      scenario.robot,      friction_of(scenario),    scenario.motor ? &*scenario.motor : nullptr,
      scenario.integrator, scenario.trajectory.dt(), scenario.substeps};
}

inline std::optional<Encoders<double>> encoders_of(const Scenario& scenario) {
  if (scenario.encoder_counts == 0) return std::nullopt;
  const Robot<double>& robot = scenario.robot;
  const std::array<double, 3>& error = scenario.odometry_errors;
  return Encoders<double>{
      static_cast<double>(scenario.encoder_counts),
      robot,
      {robot.wheel_radius * (1 + error[0]), robot.wheel_radius * (1 + error[1])},
      robot.track_width * (1 + error[2])};
}

// Fills the noise of each sample, if there is any. normal(n) gives the standard normals, asked for
// in order.
template <class Normal>
void fill_noise(const std::array<double, 2>& deviation, const Normal& normal,
                std::vector<Measurement<double>>& noise) {
  std::uint64_t number = 0;
  for (auto& sample : noise) {
    constexpr std::uint64_t seldom = 12288;  // three a sample
    if (number % seldom == 0 && Interruption::stops_here()) break;
    sample.x = deviation[0] * normal(number++);
    sample.y = deviation[0] * normal(number++);
    sample.theta = deviation[1] * normal(number++);
  }
}

inline void draw_noise(const Scenario& scenario, std::vector<Measurement<double>>& noise) {
  const std::array<double, 2>& deviation = scenario.pose_noise;
  if (!(deviation[0] > 0 || deviation[1] > 0)) return;
  noise.resize(static_cast<std::size_t>(scenario.trajectory.size()));
  if (scenario.noise_source == NoiseSource::counter) {
    const CounterNoise source(scenario.seed);
    fill_noise(
        deviation, [&](std::uint64_t number) { return source.normal(number); }, noise);
  } else {
    Random random(scenario.seed);
    fill_noise(
        deviation, [&](std::uint64_t /*number*/) { return random.normal(); }, noise);
  }
}

}  // namespace detail

// The scenario must outlive what is prepared from it, and its trajectory must not be empty.
PreparedRun prepare(const Scenario&& scenario) = delete;
NFOPIDN_HOST PreparedRun prepare(const Scenario& scenario);

inline LoopInputs<double> PreparedRun::inputs() const {
  LoopInputs<double> in;
  in.reference = reference.data();
  in.samples = static_cast<int>(reference.size());
  in.noise = noise.empty() ? nullptr : noise.data();
  in.encoders = encoders ? &*encoders : nullptr;
  const bool calm =
      disturbance.size() == 1 && disturbance[0].force == 0 && disturbance[0].moment == 0;
  in.disturbance = calm ? nullptr : disturbance.data();
  in.disturbance_by_sample = disturbance.size() > 1;
  in.delay = scenario->delay;
  in.feedforward = scenario->feedforward;
  in.divergence_distance = scenario->divergence_distance;
  const std::array<double, 3>& weights = scenario->cost_weights;
  in.cost_weights = {weights[0], weights[1], weights[2]};
  return in;
}

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST PreparedRun prepare(const Scenario& scenario) {
  const StandardArithmetic arithmetic;
  const Trajectory& t = scenario.trajectory;
  PreparedRun run{{},
                  {},
                  {},
                  detail::encoders_of(scenario),
                  detail::start_state(scenario),
                  detail::robot_drive(scenario),
                  {scenario.torque_limit, std::max(t.peak_speed(), least_speed_scale), t.dt()},
                  &scenario};
  const auto count = static_cast<std::size_t>(t.size());
  run.reference.reserve(count);
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    run.reference.push_back(detail::reference_sample(scenario, k));
  }
  for (const auto& pair : scenario.disturbance) run.disturbance.push_back({pair[0], pair[1]});
  detail::draw_noise(scenario, run.noise);
  return run;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
