// L4. Settings and scenarios as JSON documents. The one JSON parser of the project: files, the
// command line and Python keywords all pass through read_settings().
#pragma once

#include <stdexcept>

#include "nfopidn/io/json_values.hpp"
#include "nfopidn/metrics.hpp"

namespace nfopidn {

constexpr int document_version = 1;
constexpr const char* scenario_format = "nfopidn-scenario";

namespace json {

inline std::string join(const std::string& path, const std::string& key) {
  return path.empty() ? key : path + "." + key;
}

template <class Settings>
bool has_field(const std::string& key) {
  bool found = false;
  Settings::fields([&](const auto& field) { found = found || key == field.name; });
  return found;
}

template <class Settings>
std::string field_list() {
  std::string list;
  Settings::fields(
      [&](const auto& field) { list += (list.empty() ? "" : ", ") + std::string(field.name); });
  return list;
}

// What an object may hold, but for the header that every document has.
template <class Settings>
std::string known_keys(const std::vector<std::string>& also) {
  std::string list;
  for (const std::string& key : also) {
    if (key != "format" && key != "version") list += key + ", ";
  }
  return list + field_list<Settings>();
}

inline Outcome unknown_key(const std::string& path, const std::string& known) {
  return {Status::not_a_choice, path + " is unknown; known: " + known};
}

}  // namespace json

// Reads the object's keys into `settings`, which keeps what is not named. `path` prefixes names in
// messages; keys in `also` are left to the caller. On a fault the settings stay as they were.
template <class Settings>
Outcome read_settings(const Json& object, const std::string& path, Settings& settings,
                      const std::vector<std::string>& also = {}) {
  if (!object.is_object()) {
    return {Status::not_a_choice, (path.empty() ? "the document" : path) + " must be an object"};
  }
  for (const auto& item : object.items()) {
    const bool known = json::has_field<Settings>(item.key()) ||
                       std::find(also.begin(), also.end(), item.key()) != also.end();
    if (!known) {
      return json::unknown_key(json::join(path, item.key()), json::known_keys<Settings>(also));
    }
  }
  Outcome outcome;
  Settings result = settings;
  Settings::fields([&](const auto& field) {
    const auto found = object.find(field.name);
    if (found == object.end()) return;
    const json::Context context = {json::join(path, field.name), field.range, field.unit, &outcome};
    json::read(*found, context, result.*field.member);
  });
  if (outcome) settings = std::move(result);
  return outcome;
}

template <class Settings>
Json write_settings(const Settings& settings) {
  Json object = Json::object();
  Settings::fields(
      [&](const auto& field) { object[field.name] = json::write(settings.*field.member); });
  return object;
}

inline Json write_trajectory(const Trajectory& trajectory) {
  const TrajectorySettings& s = trajectory.settings;
  if (s.name != Curve::samples) return write_settings(s);
  const Eigen::Index lap = (trajectory.size() - 1) / s.laps + 1;
  // The first lap, but for its end: the ends may lie a little apart, and each lap but the last ends
  // where it began.
  const auto list = [&](const Eigen::ArrayXd& array) {
    std::vector<double> one(array.data(), array.data() + lap);
    one.back() = array(array.size() - 1);
    return Json(std::move(one));
  };
  return {{"name", "samples"},
          {"dt", s.dt},
          {"heading", json::write(s.heading)},
          {"laps", s.laps},
          {"x", list(trajectory.x)},
          {"y", list(trajectory.y)}};
}

namespace json {

constexpr Range position_range = between(-1e9, 1e9);  // [m]

inline Outcome read_positions(const Json& object, const char* key, const std::string& path,
                              Eigen::ArrayXd& result) {
  const std::string name = join(path, key);
  const auto found = object.find(key);
  if (found == object.end() || !found->is_array()) {
    return {Status::wrong_size, name + " must be a list of numbers"};
  }
  Outcome outcome;
  result.resize(static_cast<Eigen::Index>(found->size()));
  const Context context = {name, position_range, "m", &outcome};
  for (std::size_t i = 0; i < found->size(); ++i) {
    read((*found)[i], context.at(i), result(static_cast<Eigen::Index>(i)));
  }
  return outcome;
}

// Says in words why make_trajectory() refused settings whose every field is in range.
inline Outcome explain_trajectory(Status status, const TrajectorySettings& settings, double count,
                                  const std::string& path) {
  if (status == Status::ok) return {};
  if (status == Status::inconsistent) {
    return {status, join(path, "laps") + " is " + std::to_string(settings.laps) +
                        "; must be 1, since the path's ends are more than " +
                        number_text(closing_distance) + " m apart"};
  }
  return refuse(status, join(path, "samples"), number_text(count),
                range_text(between(minimum_samples, maximum_samples)));
}

}  // namespace json

// Fills a trajectory from its settings, and from positions when its name is "samples".
inline Outcome build_trajectory(const TrajectorySettings& settings, const Eigen::ArrayXd& x,
                                const Eigen::ArrayXd& y, const std::string& path,
                                Trajectory& result) {
  if (settings.name != Curve::samples) {
    return json::explain_trajectory(make_trajectory(settings, result), settings,
                                    sample_count(settings), path);
  }
  for (const auto& [positions, key] : {std::pair{&x, "x"}, std::pair{&y, "y"}}) {
    for (Eigen::Index k = 0; k < positions->size(); ++k) {
      if (json::position_range.contains((*positions)(k))) continue;
      const std::string name = std::string(key) + "[" + std::to_string(k) + "]";
      const double value = (*positions)(k);
      return refuse_number(json::join(path, name), value,
                           std::isfinite(value) ? json::position_range : any_number(), "m");
    }
  }
  if (x.size() != y.size()) {
    return {Status::wrong_size, json::join(path, "y") + " has " + std::to_string(y.size()) +
                                    " numbers; must have as many as x, " +
                                    std::to_string(x.size())};
  }
  return json::explain_trajectory(make_trajectory(x, y, settings, result), settings,
                                  static_cast<double>(x.size()) * settings.laps, path);
}

// Keys not named keep the values of `result`, which is a trajectory already or empty.
inline Outcome read_trajectory(const Json& object, const std::string& path, Trajectory& result) {
  TrajectorySettings settings = result.settings;
  if (Outcome outcome = read_settings(object, path, settings, {"x", "y"}); !outcome) return outcome;
  Eigen::ArrayXd x, y;
  if (settings.name == Curve::samples) {
    for (const char* key : {"period", "cusps", "scale", "derivatives"}) {
      if (object.contains(key))
        return json::unknown_key(json::join(path, key),
                                 "name, dt, heading, laps, x, y (a path of samples)");
    }
    if (Outcome outcome = json::read_positions(object, "x", path, x); !outcome) return outcome;
    if (Outcome outcome = json::read_positions(object, "y", path, y); !outcome) return outcome;
  } else {
    for (const char* key : {"x", "y"}) {
      if (object.contains(key))
        return json::unknown_key(json::join(path, key), json::field_list<TrajectorySettings>());
    }
  }
  return build_trajectory(settings, x, y, path, result);
}

inline Json write_scenario(const Scenario& scenario) {
  Json document = {{"format", scenario_format}, {"version", document_version}};
  document["trajectory"] = write_trajectory(scenario.trajectory);
  document["robot"] = write_settings(scenario.robot);
  document.update(write_settings(scenario));
  return document;
}

// Settings each in range may still contradict each other.
inline Outcome explain_consistency(const Scenario& scenario) {
  const Finding finding = check_consistency(scenario);
  if (finding.status == Status::ok) return {};
  const std::string value = number_text(finding.value);
  if (finding.status == Status::inconsistent) {
    return {finding.status, std::string(finding.field) + " is " + value +
                                " m from the reference's start; must be within "
                                "divergence_distance, " +
                                number_text(finding.range.high) + " m"};
  }
  return {finding.status, std::string(finding.field) + " has " + value +
                              " samples; must have 1 or as many as the trajectory, " +
                              number_text(finding.range.high)};
}

namespace json {

inline Outcome check_header(const Json& document, const char* format) {
  if (!document.is_object()) return {Status::not_a_choice, "the document must be an object"};
  const auto found = document.find("format");
  if (found == document.end() || *found != format) {
    return {Status::not_a_choice, "format must be \"" + std::string(format) + "\""};
  }
  const auto version = document.find("version");
  if (version == document.end() || !version->is_number_integer() ||
      version->get<std::int64_t>() != document_version) {
    return {Status::out_of_range,
            "version is " +
                (version == document.end()
                     ? "missing"
                     : version->dump(-1, ' ', true, Json::error_handler_t::replace)) +
                "; this library reads version " + std::to_string(document_version)};
  }
  return {};
}

}  // namespace json

// What a scenario document's missing keys stand for.
inline Scenario default_scenario() {
  Scenario scenario = Scenario::published();
  scenario.initial_pose.reset();
  return scenario;
}

inline Outcome read_scenario(const Json& document, Scenario& result) {
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

namespace json {

constexpr int deepest = 16;  // levels of a document

// Refuses, while the text is parsed, what a document never has: a key that stands twice in an
// object, and nesting so deep that it could only be meant to exhaust the stack.
class Guard {
 public:
  bool operator()(int /*depth*/, Json::parse_event_t event, Json& parsed) {
    using Event = Json::parse_event_t;
    if (event == Event::object_start || event == Event::array_start) {
      keys_.emplace_back();
      if (keys_.size() > deepest) throw std::length_error("nested too deeply");
    } else if (event == Event::object_end || event == Event::array_end) {
      keys_.pop_back();
    } else if (event == Event::key) {
      const auto& key = parsed.get_ref<const std::string&>();
      auto& seen = keys_.back();
      if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
        throw std::length_error("the key " + key + " stands twice");
      }
      seen.push_back(key);
    }
    return true;
  }

 private:
  std::vector<std::vector<std::string>> keys_;
};

}  // namespace json

// Text to JSON. NaN, infinities, trailing text and bad UTF-8 are refused.
inline Outcome parse_json(const std::string& text, Json& result) {
  const StandardArithmetic arithmetic;  // the conversion of decimals rounds
  try {
    result = Json::parse(text, json::Guard());
  } catch (const Json::exception& error) {
    return {Status::not_a_choice, std::string("not valid JSON: ") + error.what()};
  } catch (const std::length_error& error) {
    return {Status::not_a_choice, error.what()};
  }
  return {};
}

}  // namespace nfopidn
