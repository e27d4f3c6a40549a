#include "scenario.hpp"

#include "nfopidn/io/csv.hpp"
#include "nfopidn/io/files.hpp"

namespace nfopidn::commands {

namespace {

bool ends_in_csv(const std::string& name) {
  std::string end = name.size() > 4 ? name.substr(name.size() - 4) : "";
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return end == ".csv";
}

bool names_curve(const std::string& word) {
  const auto& names = ChoiceNames<Curve>::names;
  return std::find(std::begin(names), std::end(names), word) != std::end(names);
}

}  // namespace

bool names_file(const std::string& word) { return ends_in_csv(word) || file_exists(word); }

bool names_path_file(const std::string& word) {
  return !names_curve(word) && (names_file(word) || word.find_first_of("./") != std::string::npos);
}

namespace {

// The trajectory in a table.
Outcome load_path(const Arguments& arguments, Words words, Trajectory& result) {
  const std::string path = words["name"];
  words.erase("name");
  for (const char* key : {"period", "cusps", "scale", "derivatives"}) {
    if (words.count(key) != 0) {
      return {Status::inconsistent, std::string("--") + key + " does not apply to " + path};
    }
  }
  TableReading reading;
  const Json object = words_to_json<TrajectorySettings>(words);
  if (Outcome outcome = read_settings(object, "trajectory", reading.settings); !outcome) {
    return outcome;
  }
  reading.dt = words.count("dt") != 0 ? reading.settings.dt : 0;
  reading.heading_given = words.count("heading") != 0;
  reading.closed = arguments.closed;
  return load_trajectory(path, reading, result);
}

// The trajectory that options ask for, over the one the scenario has.
Outcome apply_trajectory(const Arguments& arguments, Scenario& scenario) {
  const Words& words = arguments.trajectory;
  const auto name = words.find("name");
  const bool is_file = name != words.end() && names_path_file(name->second);
  if (arguments.closed && !is_file) {
    return {Status::inconsistent, "--closed applies to --trajectory FILE alone"};
  }
  if (words.empty()) return {};
  if (is_file) return load_path(arguments, words, scenario.trajectory);
  if (name != words.end() && name->second == "samples") {
    return {Status::not_a_choice, "--trajectory samples has no positions; give a file"};
  }
  Json object = write_trajectory(scenario.trajectory);
  if (name != words.end() && scenario.trajectory.settings.name == Curve::samples) {
    object = Json::object();
    scenario.trajectory = {};
  }
  object.update(words_to_json<TrajectorySettings>(words));
  Outcome outcome = read_trajectory(object, "trajectory", scenario.trajectory);
  const Curve curve = scenario.trajectory.settings.name;
  if (outcome && words.count("cusps") != 0 && curve != Curve::ranunculoid) {
    return {Status::inconsistent, std::string("--cusps does not apply to the path ") +
                                      ChoiceNames<Curve>::names[static_cast<int>(curve)]};
  }
  const TrajectorySettings& settings = scenario.trajectory.settings;
  const bool by_motion = curve == Curve::samples || (settings.heading == HeadingChoice::forward &&
                                                     settings.derivatives == Derivatives::sampled);
  if (outcome && words.count("standstill_speed") != 0 && !by_motion) {
    return {Status::inconsistent,
            "--standstill-speed does not apply to a heading that is a closed form"};
  }
  return outcome;
}

}  // namespace

Outcome build_scenario(const Arguments& arguments, Scenario& scenario) {
  scenario = Scenario::published();
  const auto name = arguments.trajectory.find("name");
  const bool other_path = name != arguments.trajectory.end() && name->second != "ranunculoid";
  if (other_path || !arguments.scenario_file.empty()) scenario.initial_pose.reset();
  if (!arguments.scenario_file.empty()) {
    if (Outcome outcome = load_scenario(arguments.scenario_file, scenario); !outcome) {
      return outcome;
    }
  }
  if (Outcome outcome = apply_trajectory(arguments, scenario); !outcome) return outcome;
  const Json robot = words_to_json<Robot<double>>(arguments.robot);
  if (Outcome outcome = read_settings(robot, "robot", scenario.robot); !outcome) return outcome;
  Json fields = words_to_json<Scenario>(arguments.scenario);
  const auto disturbance = arguments.scenario.find("disturbance");
  if (disturbance != arguments.scenario.end() && names_file(disturbance->second)) {
    std::vector<std::array<double, 2>> pairs;
    const double dt = scenario.trajectory.dt();
    Outcome outcome = load_disturbance(disturbance->second, dt, pairs);
    if (!outcome) return outcome;
    fields["disturbance"] = pairs;
  }
  if (Outcome outcome = read_settings(fields, "", scenario); !outcome) return outcome;
  return explain_consistency(scenario);
}

}  // namespace nfopidn::commands
