// L3. The parameters of a scenario that a Monte Carlo analysis may draw, by name.
#pragma once

#include <string_view>
#include <vector>

#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn {

struct DrawnParameter {
  const char* name;
  const char* unit;
  Range range;
  const char* text;
  void (*set)(Scenario&, double);
};

namespace detail {

template <class Settings>
Range range_of(std::string_view name) {
  Range range;
  Settings::fields([&](const auto& field) {
    if (name == field.name) range = field.range;
  });
  return range;
}

inline void set_start(Scenario& scenario, std::size_t coordinate, double value) {
  const State<double> start = start_state(scenario);
  std::array<double, 3> pose = {start.x, start.y, start.theta};
  pose[coordinate] = value;
  scenario.initial_pose = pose;
}

// Of a named path; another has no scale.
inline void scale_path(Scenario& scenario, double scale) {
  TrajectorySettings settings = scenario.trajectory.settings;
  settings.scale = scale;
  make_trajectory(settings, scenario.trajectory);
}

}  // namespace detail

// All of them, in the order in which they are to be set: the start comes after the path.
inline const std::vector<DrawnParameter>& drawn_parameters() {
  using S = Scenario;
  static const Range position = between(-1e9, 1e9);
  static const std::vector<DrawnParameter> all = {
      {"path_scale", "", detail::range_of<TrajectorySettings>("scale"), "scale of a named path",
       detail::scale_path},
      {"mass", "kg", detail::range_of<Robot<double>>("mass"), "mass of the robot",
       [](S& s, double value) { s.robot.mass = value; }},
      {"inertia", "kg m^2", detail::range_of<Robot<double>>("inertia"), "its moment of inertia",
       [](S& s, double value) { s.robot.inertia = value; }},
      {"track_width", "m", detail::range_of<Robot<double>>("track_width"),
       "distance between its wheels", [](S& s, double value) { s.robot.track_width = value; }},
      {"wheel_radius", "m", detail::range_of<Robot<double>>("wheel_radius"), "radius of its wheels",
       [](S& s, double value) { s.robot.wheel_radius = value; }},
      {"viscous_friction", "N m s/rad", detail::range_of<S>("viscous_friction"),
       "viscous friction at each wheel", [](S& s, double value) { s.viscous_friction = value; }},
      {"coulomb_friction", "N m", detail::range_of<S>("coulomb_friction"),
       "Coulomb friction at each wheel", [](S& s, double value) { s.coulomb_friction = value; }},
      {"viscous_scrub", "N m s/rad", detail::range_of<S>("viscous_scrub"),
       "viscous moment that opposes turning", [](S& s, double value) { s.viscous_scrub = value; }},
      {"coulomb_scrub", "N m", detail::range_of<S>("coulomb_scrub"),
       "Coulomb moment that opposes turning", [](S& s, double value) { s.coulomb_scrub = value; }},
      {"disturbance_force", "N", detail::range_of<S>("disturbance"),
       "constant force along the robot", [](S& s, double value) { s.disturbance[0][0] = value; }},
      {"disturbance_moment", "N m", detail::range_of<S>("disturbance"), "constant moment on it",
       [](S& s, double value) { s.disturbance[0][1] = value; }},
      {"position_noise", "m", detail::range_of<S>("pose_noise"),
       "standard deviation of the measured position",
       [](S& s, double value) { s.pose_noise[0] = value; }},
      {"heading_noise", "rad", detail::range_of<S>("pose_noise"),
       "standard deviation of the measured heading",
       [](S& s, double value) { s.pose_noise[1] = value; }},
      {"delay", "samples", detail::range_of<S>("delay"), "from measurement to applied torque",
       [](S& s, double value) { s.delay = static_cast<int>(value); }},
      {"start_x", "m", position, "where the robot starts",
       [](S& s, double value) { detail::set_start(s, 0, value); }},
      {"start_y", "m", position, "where the robot starts",
       [](S& s, double value) { detail::set_start(s, 1, value); }},
      {"start_theta", "rad", between(-1e6, 1e6), "its heading at the start",
       [](S& s, double value) { detail::set_start(s, 2, value); }},
  };
  return all;
}

// The scenario of one run after another: a base, with some parameters drawn and a seed of its own.
class DrawnScenarios {
 public:
  // drawn: indices into drawn_parameters(), ascending. The feedforward uses the
  // base's model, because the controller does not know the drawn parameters.
  DrawnScenarios(const Scenario& base, std::vector<std::size_t> drawn)
      : base_(base), drawn_(std::move(drawn)) {
    base_.model = base.modelled_robot();
    base_.noise_source = NoiseSource::counter;
  }

  const Scenario& base() const { return base_; }
  std::size_t drawn_count() const { return drawn_.size(); }
  bool draws(std::string_view name) const {
    return std::any_of(drawn_.begin(), drawn_.end(), [&](std::size_t parameter) {
      return name == drawn_parameters()[parameter].name;
    });
  }

  // Makes of a copy of base() the scenario of a run; values: [drawn_count()].
  void apply(const double* values, std::uint64_t seed, Scenario& scenario) const {
    scenario.initial_pose = base_.initial_pose;
    for (const std::size_t parameter : drawn_) {
      drawn_parameters()[parameter].set(scenario, *values++);
    }
    scenario.seed = seed;
  }

 private:
  Scenario base_;
  std::vector<std::size_t> drawn_;
};

}  // namespace nfopidn
