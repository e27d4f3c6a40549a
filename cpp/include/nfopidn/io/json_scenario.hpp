// L4. Trajectories and scenarios as JSON documents.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/json.hpp"

namespace nfopidn {

constexpr const char* scenario_format = "nfopidn-scenario";

NFOPIDN_HOST Json write_trajectory(const Trajectory& trajectory);

namespace json {

constexpr Range position_range = between(-1e9, 1e9);  // [m]
constexpr Range angle_range = between(-1e6, 1e6);     // [rad]

NFOPIDN_HOST Outcome read_numbers(const Json& object, const char* key, const std::string& path,
                                  const Range& range, const char* unit, Eigen::ArrayXd& result);

NFOPIDN_HOST Outcome read_flags(const Json& object, const std::string& path,
                                std::vector<unsigned char>& result);

// Says in words why make_trajectory() refused settings whose every field is in range.
NFOPIDN_HOST Outcome explain_trajectory(Status status, const TrajectorySettings& settings,
                                        double count, const std::string& path);

}  // namespace json

// Fills a trajectory from its settings, and from positions when its name is "samples".
NFOPIDN_HOST Outcome build_trajectory(const TrajectorySettings& settings, const Samples& samples,
                                      const std::string& path, Trajectory& result);

namespace json {

// The keys that a path of samples has, and those that it has not.
NFOPIDN_HOST Outcome read_samples(const Json& object, const std::string& path, Samples& samples);

NFOPIDN_HOST Outcome refuse_samples(const Json& object, const std::string& path);

}  // namespace json

// Keys not named keep the values of `result`, which is a trajectory already or empty.
NFOPIDN_HOST Outcome read_trajectory(const Json& object, const std::string& path,
                                     Trajectory& result);

NFOPIDN_HOST Json write_scenario(const Scenario& scenario);

// Settings each in range may still contradict each other.
NFOPIDN_HOST Outcome explain_consistency(const Scenario& scenario);

// What a scenario document's missing keys stand for.
NFOPIDN_HOST Scenario default_scenario();

NFOPIDN_HOST Outcome read_scenario(const Json& document, Scenario& result);

#ifdef NFOPIDN_COMPILED
extern template Json write_settings(const Scenario&);
extern template Json write_settings(const TrajectorySettings&);
extern template Outcome read_settings(const Json&, const std::string&, Scenario&,
                                      const std::vector<std::string>&);
extern template Outcome read_settings(const Json&, const std::string&, TrajectorySettings&,
                                      const std::vector<std::string>&);
#endif

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_IO

namespace nfopidn {

NFOPIDN_HOST Json write_trajectory(const Trajectory& trajectory) {
  const TrajectorySettings& s = trajectory.settings;
  // Documents without it are as they were before paths had a standstill speed.
  if (s.name != Curve::samples) {
    Json object = write_settings(s);
    if (!s.standstill_speed) object.erase("standstill_speed");
    return object;
  }
  const Eigen::Index lap = (trajectory.size() - 1) / s.laps + 1;
  // The first lap, but for its end: the ends may lie a little apart, and each lap but the last ends
  // where it began.
  const auto list = [&](const Eigen::ArrayXd& array) {
    std::vector<double> one(array.data(), array.data() + lap);
    one.back() = array(array.size() - 1);
    return Json(std::move(one));
  };
  Json object = {
      {"name", "samples"}, {"dt", s.dt}, {"heading", json::write(s.heading)}, {"laps", s.laps}};
  if (s.standstill_speed) object["standstill_speed"] = *s.standstill_speed;
  object["x"] = list(trajectory.x);
  object["y"] = list(trajectory.y);
  if (const Eigen::ArrayXd& theta = trajectory.given_theta; theta.size() != 0) {
    object["theta"] = std::vector<double>(theta.data(), theta.data() + theta.size());
  }
  if (const auto& reverse = trajectory.given_reverse; !reverse.empty()) {
    object["reverse"] = std::vector<bool>(reverse.begin(), reverse.end());
  }
  if (trajectory.origin[0] != 0 || trajectory.origin[1] != 0) object["origin"] = trajectory.origin;
  return object;
}

}  // namespace nfopidn

namespace nfopidn::json {

NFOPIDN_HOST Outcome read_numbers(const Json& object, const char* key, const std::string& path,
                                  const Range& range, const char* unit, Eigen::ArrayXd& result) {
  const std::string name = join(path, key);
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array()) {
    return {Status::wrong_size, name + " must be a list of numbers"};
  }
  Outcome outcome;
  result.resize(static_cast<Eigen::Index>(found->size()));
  const Context context = {name, range, unit, &outcome};
  for (std::size_t i = 0; i < found->size(); ++i) {
    read((*found)[i], context.at(i), result(static_cast<Eigen::Index>(i)));
  }
  return outcome;
}

NFOPIDN_HOST Outcome read_flags(const Json& object, const std::string& path,
                                std::vector<unsigned char>& result) {
  const std::string name = join(path, "reverse");
  const Json& list = object["reverse"];
  if (!list.is_array()) return {Status::wrong_size, name + " must be a list of true and false"};
  Outcome outcome;
  const Context context = {name, any_number(), "", &outcome};
  for (std::size_t i = 0; i < list.size(); ++i) {
    bool flag = false;
    read(list[i], context.at(i), flag);
    result.push_back(flag ? 1 : 0);
  }
  return outcome;
}

NFOPIDN_HOST Outcome explain_trajectory(Status status, const TrajectorySettings& settings,
                                        double count, const std::string& path) {
  if (status == Status::ok) return {};
  if (status == Status::not_a_choice) {
    return {status, join(path, "reverse") +
                        " contradicts theta: the positions do not move along it in that direction"};
  }
  if (status == Status::inconsistent) {
    return {status, join(path, "laps") + " is " + std::to_string(settings.laps) +
                        "; must be 1, since the path's ends are more than " +
                        number_text(closing_distance) + " m apart"};
  }
  return refuse(status, join(path, "samples"), number_text(count),
                range_text(between(minimum_samples, maximum_samples)));
}

}  // namespace nfopidn::json

namespace nfopidn {

NFOPIDN_HOST Outcome build_trajectory(const TrajectorySettings& settings, const Samples& samples,
                                      const std::string& path, Trajectory& result) {
  if (settings.name != Curve::samples) {
    return json::explain_trajectory(make_trajectory(settings, result), settings,
                                    sample_count(settings), path);
  }
  const Eigen::Index count = samples.x.size();
  for (const auto& [numbers, key] : {std::pair{&samples.x, "x"}, std::pair{&samples.y, "y"},
                                     std::pair{&samples.theta, "theta"}}) {
    const bool is_angle = numbers == &samples.theta;
    const Range range = is_angle ? json::angle_range : json::position_range;
    for (Eigen::Index k = 0; k < numbers->size(); ++k) {
      if (range.contains((*numbers)(k))) continue;
      const std::string name = std::string(key) + "[" + std::to_string(k) + "]";
      const double value = (*numbers)(k);
      return refuse_number(json::join(path, name), value,
                           std::isfinite(value) ? range : any_number(), is_angle ? "rad" : "m");
    }
  }
  const auto flags = static_cast<Eigen::Index>(samples.reverse.size());
  for (const auto& [key, size] :
       {std::pair{"y", samples.y.size()}, std::pair{"theta", samples.theta.size()},
        std::pair{"reverse", flags}}) {
    if (size == count || (size == 0 && *key != 'y')) continue;
    return {Status::wrong_size, json::join(path, key) + " has " + std::to_string(size) +
                                    " numbers; must have as many as x, " + std::to_string(count)};
  }
  return json::explain_trajectory(make_trajectory(samples, settings, result), settings,
                                  static_cast<double>(count) * settings.laps, path);
}

}  // namespace nfopidn

namespace nfopidn::json {

NFOPIDN_HOST Outcome read_samples(const Json& object, const std::string& path, Samples& samples) {
  for (const char* key : {"period", "cusps", "scale", "derivatives"}) {
    if (object.contains(key)) {
      return unknown_key(join(path, key),
                         "name, dt, heading, laps, standstill_speed, x, y, theta, reverse, origin "
                         "(a path of samples)");
    }
  }
  for (const auto& [key, numbers] : {std::pair{"x", &samples.x}, std::pair{"y", &samples.y}}) {
    if (Outcome outcome = read_numbers(object, key, path, position_range, "m", *numbers); !outcome)
      return outcome;
  }
  if (object.contains("theta")) {
    Outcome outcome = read_numbers(object, "theta", path, angle_range, "rad", samples.theta);
    if (!outcome) return outcome;
  }
  if (object.contains("origin")) {
    Eigen::ArrayXd origin;
    Outcome outcome = read_numbers(object, "origin", path, position_range, "m", origin);
    if (!outcome) return outcome;
    if (origin.size() != 2) {
      return {Status::wrong_size, join(path, "origin") + " must be a list of 2 numbers"};
    }
    samples.origin = {origin(0), origin(1)};
  }
  return object.contains("reverse") ? read_flags(object, path, samples.reverse) : Outcome{};
}

NFOPIDN_HOST Outcome refuse_samples(const Json& object, const std::string& path) {
  for (const char* key : {"x", "y", "theta", "reverse", "origin"}) {
    if (object.contains(key)) return unknown_key(join(path, key), field_list<TrajectorySettings>());
  }
  return {};
}

}  // namespace nfopidn::json

namespace nfopidn {

NFOPIDN_HOST Outcome read_trajectory(const Json& object, const std::string& path,
                                     Trajectory& result) {
  TrajectorySettings settings = result.settings;
  if (Outcome outcome =
          read_settings(object, path, settings, {"x", "y", "theta", "reverse", "origin"});
      !outcome) {
    return outcome;
  }
  Samples samples;
  Outcome outcome = settings.name == Curve::samples ? json::read_samples(object, path, samples)
                                                    : json::refuse_samples(object, path);
  if (!outcome) return outcome;
  return build_trajectory(settings, samples, path, result);
}

NFOPIDN_HOST Json write_scenario(const Scenario& scenario) {
  Json document = {{"format", scenario_format}, {"version", document_version}};
  document["trajectory"] = write_trajectory(scenario.trajectory);
  document["robot"] = write_settings(scenario.robot);
  Json settings = write_settings(scenario);
  // Documents without them are as they were before scenarios had them.
  if (!scenario.model) settings.erase("model");
  if (scenario.encoder_counts == 0) settings.erase("encoder_counts");
  if (scenario.odometry_errors == Scenario{}.odometry_errors) settings.erase("odometry_errors");
  if (!scenario.motor) settings.erase("motor");
  if (!scenario.feedforward_limit) settings.erase("feedforward_limit");
  if (scenario.friction_feedforward == Scenario{}.friction_feedforward) {
    settings.erase("friction_feedforward");
  }
  if (scenario.friction_feedforward_speed == Scenario{}.friction_feedforward_speed) {
    settings.erase("friction_feedforward_speed");
  }
  if (scenario.viscous_scrub == 0) settings.erase("viscous_scrub");
  if (scenario.coulomb_scrub == 0) settings.erase("coulomb_scrub");
  if (scenario.cost_weights == Scenario{}.cost_weights) settings.erase("cost_weights");
  if (scenario.noise_source == Scenario{}.noise_source) settings.erase("noise_source");
  document.update(settings);
  return document;
}

NFOPIDN_HOST Outcome explain_consistency(const Scenario& scenario) {
  const Finding finding = check_consistency(scenario);
  if (finding.status == Status::ok) return {};
  const std::string value = number_text(finding.value);
  if (finding.status == Status::inconsistent) {
    return {finding.status, std::string(finding.field) + " is " + value +
                                " m from the reference's start; must be within "
                                "divergence_distance, " +
                                number_text(finding.range.high) + " m"};
  }
  if (finding.status == Status::out_of_range) {  // an angle has a narrower range than positions
    return {finding.status, std::string(finding.field) + "[2] is " + value + "; must be " +
                                range_text(finding.range) + " rad"};
  }
  return {finding.status, std::string(finding.field) + " has " + value +
                              " samples; must have 1 or as many as the trajectory, " +
                              number_text(finding.range.high)};
}

NFOPIDN_HOST Scenario default_scenario() {
  Scenario scenario = Scenario::published();
  scenario.initial_pose.reset();
  return scenario;
}

NFOPIDN_HOST Outcome read_scenario(const Json& document, Scenario& result) {
  if (Outcome outcome = json::check_header(document, scenario_format); !outcome) return outcome;
  Scenario scenario = result;
  if (const auto found = document.find("trajectory"); found != document.end()) {
    if (Outcome outcome = read_trajectory(*found, "trajectory", scenario.trajectory); !outcome) {
      return outcome;
    }
  }
  if (const auto found = document.find("robot"); found != document.end()) {
    if (Outcome outcome = read_settings(*found, "robot", scenario.robot); !outcome) return outcome;
  }
  const std::vector<std::string> also = {"format", "version", "trajectory", "robot"};
  if (Outcome outcome = read_settings(document, "", scenario, also); !outcome) return outcome;
  if (Outcome outcome = explain_consistency(scenario); !outcome) return outcome;
  result = std::move(scenario);
  return {};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_IO
