// The command line: runs a scenario under a controller.
#include <CLI/CLI.hpp>
#include <array>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <optional>

#include "nfopidn/io/json_method.hpp"
#include "nfopidn/io/options.hpp"
#include "nfopidn/tuning/tune.hpp"

namespace {

using namespace nfopidn;

constexpr int exit_done = 0;
constexpr int exit_bad_input = 2;
constexpr int exit_diverged = 3;
constexpr int exit_interrupted = 130;

struct Arguments {
  Words trajectory, robot, scenario, controller;
  std::string scenario_file, controller_file, out, save_scenario, save_controller, structure;
  std::string method = name_of({});
  std::vector<std::string> options;  // of the method, NAME=NUMBER
  std::optional<std::int64_t> maxfev;
  std::uint64_t tune_seed = 0;
  bool closed = false;  // the path of --traj FILE ends where it began
  bool tune = false;
  bool json = false;
  bool quiet = false;
};

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char line[512];
  std::snprintf(line, sizeof line, pattern, values...);
  return line;
}

template <class Value>
std::string default_text(const Value& field) {
  if constexpr (std::is_same_v<std::decay_t<Value>, SampleTime<double>>) {
    if (!field.has_value()) return "unknown";
  }
  if constexpr (std::is_same_v<std::decay_t<Value>, std::optional<double>>) {
    if (!field.has_value()) return "resolution";
  }
  if constexpr (std::is_same_v<std::decay_t<Value>, std::optional<Robot<double>>>) {
    if (!field.has_value()) return "robot";
  }
  const Json value = json::write(field);
  if (value.is_null()) return "the reference's start";
  if (value.is_string()) return value.get<std::string>();
  std::string text = value.dump();
  text.erase(std::remove_if(text.begin(), text.end(), [](char c) { return c == '[' || c == ']'; }),
             text.end());
  return text;
}

template <class Value>
std::string choices_text() {
  if constexpr (std::is_enum_v<Value>) {
    std::string text;
    for (const char* name : ChoiceNames<Value>::names) {
      text += (text.empty() ? ": " : ", ") + std::string(name);
    }
    return text;
  }
  return "";
}

// An option for every field of a settings struct.
template <class Settings>
void add_options(CLI::App& app, const std::string& group, const Settings& defaults, Words& words) {
  Settings::fields([&](const auto& field) {
    using Value = std::remove_reference_t<decltype(std::declval<Settings&>().*field.member)>;
    const std::string name = option_name(field);
    const std::string key = field.name;
    const std::string unit = *field.unit == '\0' ? "" : " [" + std::string(field.unit) + "]";
    const std::string text = field.text + unit + choices_text<Value>() + " (default " +
                             default_text(defaults.*field.member) + ")";
    if constexpr (std::is_same_v<Value, bool>) {
      // Of two opposites the last one counts: they act in the order of the command line.
      const auto set = [&](const std::string& flag, const char* word, const std::string& what) {
        app.add_flag_function(
               "--" + flag, [&words, key, word](std::int64_t) { words[key] = word; }, what)
            ->disable_flag_override()
            ->group(group)
            ->trigger_on_parse();
      };
      set(name, "true", text);
      set("no-" + name, "false", "the opposite of --" + name);
    } else {
      app.add_option_function<std::string>(
             "--" + name, [&words, key](const std::string& word) { words[key] = word; }, text)
          ->group(group)
          ->type_name("");
    }
  });
}

// "how it is searched: bfoa+ (10000 evaluations), bfoa (one schedule), ..."
std::string methods_text() {
  std::string text;
  for_each_method([&](auto* method) {
    using Method = MethodOf<decltype(method)>;
    text += (text.empty() ? "how it is searched: " : ", ") + std::string(Method::name) +
            (Method::default_budget == unlimited_budget
                 ? std::string(" (one schedule)")
                 : " (" + std::to_string(Method::default_budget) + " evaluations)");
  });
  return text + "; default " + name_of({});
}

void add_file(CLI::App& app, const std::string& option, std::string& path,
              const std::string& text) {
  app.add_option(option, path, text)->type_name("FILE")->check([](const std::string& name) {
    return name.empty() ? std::string("needs the name of a file") : std::string();
  });
}

void declare(CLI::App& app, Arguments& arguments) {
  const Scenario published = Scenario::published();
  add_options(app, "Trajectory", published.trajectory.settings, arguments.trajectory);
  add_options(app, "Robot", published.robot, arguments.robot);
  add_options(app, "Scenario", published, arguments.scenario);
  add_options(app, "Controller", ControllerSettings<double>{}, arguments.controller);
  app.get_option("--traj")->description(app.get_option("--traj")->get_description() +
                                        "; or a file with columns x, y and a time, or --dt");
  app.get_option("--disturbance")
      ->description(app.get_option("--disturbance")->get_description() +
                    "; or a file with columns force, moment");
  app.add_flag("--closed", arguments.closed,
               "the path in the file of --traj is closed: its first point follows the last")
      ->disable_flag_override()
      ->group("Trajectory");
  add_file(app, "--scenario", arguments.scenario_file, "scenario file (JSON)");
  add_file(app, "--controller", arguments.controller_file, "controller file (JSON)");
  add_file(app, "--out", arguments.out, "write the run table here (CSV)");
  add_file(app, "--save-scenario", arguments.save_scenario, "write the scenario here (JSON)");
  add_file(app, "--save-controller", arguments.save_controller, "write the controller here (JSON)");
  app.add_flag("--tune", arguments.tune,
               "search for the gains and orders of least cost and run those")
      ->disable_flag_override()
      ->group("Tuning");
  app.add_option("--structure", arguments.structure,
                 "what is tuned: paper, decoupled, incremental, extended, taps (default paper)")
      ->needs("--tune")
      ->group("Tuning")
      ->type_name("NAME");
  app.add_option("--method", arguments.method, methods_text())
      ->needs("--tune")
      ->group("Tuning")
      ->type_name("NAME");
  app.add_option("--option", arguments.options, "option of the method; may be given several times")
      ->needs("--tune")
      ->group("Tuning")
      ->type_name("NAME=NUMBER")
      ->allow_extra_args(false);
  app.add_option("--maxfev", arguments.maxfev, "evaluations of the cost; default: the method's")
      ->needs("--tune")
      ->group("Tuning")
      ->type_name("N")
      ->check(CLI::Range(std::int64_t{1}, std::int64_t{1} << 53));
  app.add_option("--tune-seed", arguments.tune_seed, "seed of the search (default 0)")
      ->needs("--tune")
      ->group("Tuning")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 53));
  app.add_flag("--json", arguments.json, "print the metrics as one JSON object, nothing else")
      ->disable_flag_override();
  app.add_flag("--quiet", arguments.quiet, "print nothing but what --json asks for")
      ->disable_flag_override();
  app.set_version_flag("--version", std::string("nfopidn_sim ") + NFOPIDN_VERSION);
  app.footer(
      "Without options but --traj ranunculoid this is the paper's scenario under its gains.\n"
      "Torques have the paper's sign: a positive left torque turns the robot counter-clockwise.\n"
      "Exit code: 0 done, 2 bad usage or bad file, 3 the run diverged (after --tune: that of the "
      "best\n"
      "controller), 130 --tune was interrupted (by Ctrl-C or SIGTERM; the best so far is run and\n"
      "written).");
}

bool ends_in_csv(const std::string& name) {
  std::string end = name.size() > 4 ? name.substr(name.size() - 4) : "";
  for (char& c : end) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return end == ".csv";
}

bool names_curve(const std::string& word) {
  const auto& names = ChoiceNames<Curve>::names;
  return std::find(std::begin(names), std::end(names), word) != std::end(names);
}

// Whether a word for --disturbance is a file's name: one that exists, or that ends as a table's.
bool names_file(const std::string& word) { return ends_in_csv(word) || file_exists(word); }

// Whether a word for --traj is. The name of a curve comes first; none has a point or a slash.
bool names_path_file(const std::string& word) {
  return !names_curve(word) && (names_file(word) || word.find_first_of("./") != std::string::npos);
}

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
    return {Status::inconsistent, "--closed applies to --traj FILE alone"};
  }
  if (words.empty()) return {};
  if (is_file) return load_path(arguments, words, scenario.trajectory);
  if (name != words.end() && name->second == "samples") {
    return {Status::not_a_choice, "--traj samples has no positions; give a file"};
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

// What --structure names must be what is searched: neither a file's controller, from which the
// search then starts, nor an option may make it another.
Outcome check_structure(const Arguments& arguments, const Structure& structure,
                        const ControllerDesign& start) {
  if (arguments.structure.empty()) return {};
  const std::string about = "--structure " + arguments.structure + ": ";
  const bool taps_wanted = structure.parameters == ParameterSet::taps;
  if (!start.taps.empty() && !taps_wanted) {
    return {Status::inconsistent,
            about + arguments.controller_file + " has free taps; gains and orders are needed"};
  }
  const Json wanted = write_settings<ControllerSettings<double>>(structure.settings);
  const Json given = write_settings<ControllerSettings<double>>(start);
  for (const std::string key : {"form", "allocation", "lateral"}) {
    if (given[key] == wanted[key] || (key == "lateral" && taps_wanted)) continue;
    const bool by_option = arguments.controller.count(key) != 0;
    std::string message = about + key;
    if (!by_option) message += " of " + arguments.controller_file;
    message += " is " + given[key].dump() + "; must be " + wanted[key].dump();
    return {Status::inconsistent, message};
  }
  if (structure.parameters == ParameterSet::shared_orders && !shares_orders(start)) {
    return {Status::inconsistent, about + "alpha and sigma must be one for all channels"};
  }
  return {};
}

// Settings that would have no effect.
Outcome refuse_ignored(const Arguments& arguments, const ControllerDesign& design) {
  if (!design.taps.empty()) {
    for (const char* key : {"gains", "alpha", "sigma", "generator", "memory"}) {
      if (arguments.controller.count(key) == 0) continue;
      return {Status::inconsistent,
              std::string(key) + " does not apply to a controller of free taps"};
    }
  }
  if (arguments.tune && arguments.controller_file.empty()) {
    for (const std::string key : {"gains", "alpha", "sigma"}) {
      if (arguments.controller.count(key) == 0) continue;
      const char* verb = key == "gains" ? " are" : " is";
      return {Status::inconsistent, "--tune: " + key + verb + " what is searched for"};
    }
  }
  return {};
}

// A file's controller that does not know its sample time is run at the scenario's, which is said.
void note_unknown_sample_time(const Arguments& arguments, const ControllerDesign& design,
                              double dt) {
  const bool by_option = arguments.controller.count("sample_time") != 0;
  if (arguments.controller_file.empty() || by_option || arguments.quiet) return;
  if (design.sample_time.has_value()) return;
  std::cerr << "nfopidn_sim: " << printable(arguments.controller_file)
            << " does not carry its sample time; the controller is run at the scenario's, "
            << number_text(dt) << " s (--sample-time says it)\n";
}

Outcome build_controller(const Arguments& arguments, const Scenario& scenario,
                         ControllerDesign& design) {
  Structure structure;
  if (!arguments.structure.empty()) {
    StructureName name{};
    Outcome outcome;
    json::read(arguments.structure, json::Context{"structure", {}, "", &outcome}, name);
    if (!outcome) return outcome;
    structure = named_structure(name);
    design = ControllerDesign(structure.settings);
  }
  if (!arguments.controller_file.empty()) {
    Outcome outcome = load_controller(arguments.controller_file, design);
    if (!outcome) return outcome;
  }
  if (Outcome outcome = refuse_ignored(arguments, design); !outcome) return outcome;
  ControllerSettings<double>& settings = design;
  const Json given = words_to_json<ControllerSettings<double>>(arguments.controller);
  if (Outcome outcome = read_settings(given, "", settings); !outcome) return outcome;
  if (Outcome outcome = check_structure(arguments, structure, design); !outcome) return outcome;
  if (arguments.tune) {
    if (Outcome outcome = explain_memory_to_tune(design.memory); !outcome) return outcome;
  }
  const double dt = scenario.trajectory.dt();
  Outcome outcome = explain_sample_time(design, dt);
  if (!outcome && !arguments.controller_file.empty()) {
    outcome.message = arguments.controller_file + ": " + outcome.message;
  }
  if (outcome) outcome = explain_consistency(design);
  if (outcome) note_unknown_sample_time(arguments, design, dt);
  return outcome;
}

// Which of the controller's numbers --tune searches for.
Structure structure_to_tune(const Arguments& arguments, const Scenario& scenario,
                            const ControllerDesign& design) {
  Structure structure = {design, parameter_set_of(design)};
  structure.scale = tracking_scale(scenario);
  if (structure.parameters == ParameterSet::taps) return structure;
  if (arguments.structure == "extended") structure.parameters = ParameterSet::orders_by_channel;
  if (arguments.structure == "taps") {
    structure.parameters = ParameterSet::taps;
    structure.either_lateral =
        arguments.controller_file.empty() && arguments.controller.count("lateral") == 0;
  }
  return structure;
}

// A file's controller must lie where the search looks.
Outcome check_start(const Arguments& arguments, const Scenario& scenario,
                    const ControllerDesign& design) {
  const Structure structure = structure_to_tune(arguments, scenario, design);
  const std::vector<double> start = parameters_of(structure.parameters, design);
  const std::vector<ParameterBounds> bounds = default_bounds(structure);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const ParameterBounds& b = bounds[i];
    const double slack = 1e-9 * (b.high - b.low);
    if (start[i] >= b.low - slack && start[i] <= b.high + slack) continue;
    Outcome outcome =
        refuse_number(b.name, start[i], between(b.low, b.high), "to start a search from");
    outcome.message = arguments.controller_file + ": " + outcome.message;
    return outcome;
  }
  return {};
}

Outcome read_method(const Arguments& arguments, MethodOptions& method) {
  Json options = Json::object();
  for (const std::string& option : arguments.options) {
    const std::size_t end = option.find('=');
    const std::string name = option.substr(0, end);
    if (end == std::string::npos || name.empty()) {
      return refuse(Status::inconsistent, "--option", option, "NAME=NUMBER");
    }
    if (options.contains(name)) return {Status::inconsistent, "--option: " + name + " twice"};
    options[name] = words::number_or_text(std::string_view(option).substr(end + 1));
  }
  return nfopidn::read_method(arguments.method, options, method);
}

// While this is there, Ctrl-C and SIGTERM ask a search to stop; a second of either ends the
// program. One that is ignored, as a shell's background jobs ignore Ctrl-C, stays so.
class StopRequests {
 public:
  StopRequests() {
    struct sigaction action = {};
    action.sa_handler = [](int) {
      asked_ = 1;
      for (std::size_t i = 0; i < 2; ++i) {
        if (heeded_[i] != 0) ::signal(signals[i], SIG_DFL);
      }
    };
    for (std::size_t i = 0; i < 2; ++i) {
      ::sigaction(signals[i], nullptr, &before_[i]);
      heeded_[i] = before_[i].sa_handler == SIG_IGN ? 0 : 1;
    }
    for (std::size_t i = 0; i < 2; ++i) {
      if (heeded_[i] != 0) ::sigaction(signals[i], &action, nullptr);
    }
  }
  ~StopRequests() {
    for (std::size_t i = 0; i < 2; ++i) ::sigaction(signals[i], &before_[i], nullptr);
  }
  StopRequests(const StopRequests&) = delete;
  StopRequests& operator=(const StopRequests&) = delete;

  static bool asked() { return asked_ != 0; }

 private:
  static constexpr int signals[] = {SIGINT, SIGTERM};
  static inline volatile std::sig_atomic_t asked_ = 0;
  static inline volatile std::sig_atomic_t heeded_[2] = {};
  struct sigaction before_[2];
};

// Searches from the design, if a file gave one; shows its progress in a terminal. False if nothing
// was found before an interruption.
bool tune_design(const Arguments& arguments, const MethodOptions& method, const Scenario& scenario,
                 ControllerDesign& design) {
  const Structure structure = structure_to_tune(arguments, scenario, design);
  TuningTask task;
  task.scenarios = {&scenario};
  task.structure = structure;
  task.method = method;
  task.evaluations = arguments.maxfev.value_or(default_budget(method));
  task.seed = arguments.tune_seed;
  if (!arguments.controller_file.empty()) task.start = parameters_of(structure.parameters, design);
  const bool shown = !arguments.quiet && ::isatty(STDERR_FILENO) != 0;
  task.interrupted = StopRequests::asked;
  const TuningResult found = run_tuning(task, [&](std::int64_t evaluations, double cost) {
    if (shown) {
      std::fprintf(stderr, "\rtuning: %lld evaluations, cost %.6g ",
                   static_cast<long long>(evaluations), cost);
    }
  });
  if (shown) std::fputc('\n', stderr);
  if (found.reason == StopReason::callback) {
    std::cerr << "nfopidn_sim: interrupted after " << found.evaluations << " evaluations\n";
  }
  if (found.x.size() == 0) return false;
  design = design_of(found.structure, std::vector<double>(found.x.begin(), found.x.end()));
  design.sample_time = scenario.trajectory.dt();
  if (structure.parameters == ParameterSet::tracking) design.robot = scenario.robot;
  return true;
}

Json metrics_json(const SimulationResult& result) {
  Json object = write_settings(result.metrics);
  object["samples"] = result.table.rows();
  object["diverged_at"] = result.diverged ? Json(result.diverged_at) : Json(nullptr);
  return object;
}

// What may be why a run diverges: a start from rest where the reference moves.
std::string start_advice(const Scenario& scenario) {
  const InitialVelocity& start = scenario.initial_velocity;
  const double v = scenario.trajectory.v(0), omega = scenario.trajectory.omega(0);
  const bool rests = !start.reference && start.value == std::array<double, 2>{0, 0};
  if (!rests || (v == 0 && omega == 0)) return "";
  return format(
      "The robot starts from rest where the reference moves at %.3g m/s and %.3g rad/s:\n"
      "--velocity reference starts it with these.\n",
      v, omega);
}

std::string summary(const Scenario& scenario, const SimulationResult& result) {
  const TrajectorySettings& t = scenario.trajectory.settings;
  std::string text = format("%s, %lld samples, %g s apart, heading %s\n\n",
                            ChoiceNames<Curve>::names[static_cast<int>(t.name)],
                            static_cast<long long>(scenario.trajectory.size()), t.dt,
                            ChoiceNames<HeadingChoice>::names[static_cast<int>(t.heading)]);
  Metrics::fields([&](const auto& field) {
    text += format("  %-20s %12.6g %-6s  %s\n", field.name, result.metrics.*field.member,
                   field.unit, field.text);
  });
  if (result.diverged) {
    text += format("\nThe run diverged at %g s; the metrics but the cost are those before.\n",
                   result.diverged_at) +
            start_advice(scenario);
  }
  return text;
}

int fail(const Outcome& outcome) {
  std::cerr << "nfopidn_sim: " << printable(outcome.message) << "\n";
  return exit_bad_input;
}

// Text to standard output, or the reason why not.
Outcome print(const std::string& text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    return file_fault("standard output", "cannot be written");
  }
  return {};
}

// Whether two names stand for one file, there already or not.
bool same_place(const std::string& one, const std::string& other) {
  if (one.empty() || other.empty()) return false;
  std::error_code ignored;
  if (std::filesystem::is_regular_file(one, ignored) &&
      std::filesystem::equivalent(one, other, ignored)) {
    return true;
  }
  const auto place = [&](const std::string& name) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(name, ignored), ignored);
  };
  const auto status = std::filesystem::status(one, ignored);
  const bool special = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
  return !special && place(one) == place(other);
}

// The files that the options name to be read.
std::vector<std::string> inputs_of(const Arguments& arguments) {
  std::vector<std::string> inputs = {arguments.scenario_file, arguments.controller_file};
  const auto add = [&](const Words& words, const char* key, bool (*names)(const std::string&)) {
    const auto word = words.find(key);
    if (word != words.end() && names(word->second)) inputs.push_back(word->second);
  };
  add(arguments.trajectory, "name", names_path_file);
  add(arguments.scenario, "disturbance", names_file);
  return inputs;
}

using Outputs = std::array<std::string, 3>;  // empty where none is wanted

Outcome check_outputs(const Outputs& paths, const std::vector<std::string>& inputs) {
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].empty()) continue;
    for (const std::string& input : inputs) {
      if (same_place(paths[i], input)) {
        return {Status::inconsistent, paths[i] + " is to be read, and would be overwritten"};
      }
    }
    for (std::size_t other = 0; other < i; ++other) {
      if (same_place(paths[i], paths[other])) {
        return {Status::inconsistent, paths[i] + " is named for two files"};
      }
    }
    if (Outcome outcome = check_writable(paths[i]); !outcome) return outcome;
  }
  return {};
}

// Writes what can be written; names all that cannot.
Outcome write_all(const Outputs& paths, const Outputs& contents) {
  Outcome faults;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].empty()) continue;
    const Outcome outcome = write_file(paths[i], contents[i]);
    if (outcome) continue;
    const std::string before = faults ? "" : faults.message + "; ";
    faults = {outcome.status, before + outcome.message};
  }
  return faults;
}

// What is worth saying before the run.
void tell_notes(const Arguments& arguments, const Scenario& scenario,
                const ControllerDesign& design) {
  if (arguments.quiet) return;
  for (const std::string& note : scenario.trajectory.notes) {
    std::cerr << "nfopidn_sim: " << printable(note) << "\n";
  }
  const std::string other = arguments.tune ? "" : explain_robot(design, scenario.robot);
  if (!other.empty()) std::cerr << "nfopidn_sim: " << other << "\n";
}

Outcome print_result(const Arguments& arguments, const Scenario& scenario,
                     const SimulationResult& result) {
  if (arguments.json) return print(metrics_json(result).dump() + "\n");
  return arguments.quiet ? Outcome{} : print(summary(scenario, result));
}

int run(const Arguments& arguments) {
  Scenario scenario;
  ControllerDesign design;
  if (Outcome outcome = build_scenario(arguments, scenario); !outcome) return fail(outcome);
  if (Outcome outcome = build_controller(arguments, scenario, design); !outcome)
    return fail(outcome);
  if (arguments.tune && !arguments.controller_file.empty()) {
    if (Outcome outcome = check_start(arguments, scenario, design); !outcome) return fail(outcome);
  }
  MethodOptions method;
  if (Outcome outcome = read_method(arguments, method); !outcome) return fail(outcome);
  std::optional<StopRequests> requests;
  if (arguments.tune) requests.emplace();
  // Whether the files can be written shows before the run, not after.
  const Outputs outputs = {arguments.out, arguments.save_scenario, arguments.save_controller};
  if (Outcome outcome = check_outputs(outputs, inputs_of(arguments)); !outcome) {
    return fail(outcome);
  }
  tell_notes(arguments, scenario, design);
  if (arguments.tune && !tune_design(arguments, method, scenario, design)) return exit_interrupted;
  requests.reset();
  const SimulationResult result = simulate(scenario, design);
  const Outputs contents = {run_table_csv(result.table), document_text(write_scenario(scenario)),
                            document_text(write_controller(design))};
  if (Outcome outcome = write_all(outputs, contents); !outcome) return fail(outcome);
  if (Outcome printed = print_result(arguments, scenario, result); !printed) return fail(printed);
  if (StopRequests::asked()) return exit_interrupted;
  if (arguments.tune && result.diverged) {
    std::cerr << "nfopidn_sim: --tune: the best controller that was found diverges at "
              << format("%g s\n", result.diverged_at);
    if (arguments.json || arguments.quiet) std::cerr << start_advice(scenario);
  }
  return result.diverged ? exit_diverged : exit_done;
}

int run_command_line(int argc, char** argv) {
  CLI::App app("Simulates a differential-drive robot under the NFOPIDN controller.", "nfopidn_sim");
  Arguments arguments;
  declare(app, arguments);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& asked) {  // --help, --version
    std::ostringstream text;
    app.exit(asked, text, text);
    const Outcome printed = print(text.str());
    return printed ? exit_done : fail(printed);
  } catch (const CLI::ParseError& error) {
    std::string message = error.what();
    const std::string clumsy = " was given a disallowed flag override";
    if (const auto place = message.find(clumsy); place != std::string::npos) {
      message = "--" + message.replace(place, clumsy.size(), " takes no value");
    }
    return fail({Status::not_a_choice, message + "; see --help"});
  }
  return run(arguments);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_command_line(argc, argv);
  } catch (const std::bad_alloc&) {
    std::cerr << "nfopidn_sim: out of memory\n";
  } catch (const std::exception& error) {
    std::cerr << "nfopidn_sim: " << error.what() << "\n";
  }
  return exit_bad_input;
}
