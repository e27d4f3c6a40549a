#include "arguments.hpp"

#include <CLI/CLI.hpp>
#include <sstream>

#include "output.hpp"

namespace nfopidn::commands {

namespace {

constexpr std::size_t help_column = 34;  // behind the longest names of an option

template <class Value>
std::string default_text(const Value& field, const std::string& text_of_field) {
  const Json value = json::write(field);
  if (value.is_null()) return words::word_for_null(text_of_field);
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

// Names as CLI11 takes them: --initial-pose,--pose.
std::string spelled(const std::vector<std::string>& names, const std::string& prefix = "--") {
  std::string list;
  for (const std::string& name : names) {
    if (!list.empty()) list += ',';
    list += prefix;
    list += name;
  }
  return list;
}

// An option for every field of a settings struct. The group is the object's name, as a title.
template <class Settings>
void add_options(CLI::App& app, const std::string& group, const Settings& defaults, Words& words) {
  std::string object = group;
  object.front() = static_cast<char>(std::tolower(static_cast<unsigned char>(object.front())));
  Settings::fields([&](const auto& field) {
    using Value = std::remove_reference_t<decltype(std::declval<Settings&>().*field.member)>;
    const std::vector<std::string> names = option_names(field, object);
    const std::string key = field.name;
    const std::string unit = *field.unit == '\0' ? "" : " [" + std::string(field.unit) + "]";
    const std::string text = field.text + unit + choices_text<Value>() + " (default " +
                             default_text(defaults.*field.member, field.text) + ")";
    if constexpr (std::is_same_v<Value, bool>) {
      // Of two opposites the last one counts: they act in the order of the command line.
      const auto set = [&](const std::string& flag, const char* word, const std::string& what) {
        app.add_flag_function(
               flag, [&words, key, word](std::int64_t) { words[key] = word; }, what)
            ->disable_flag_override()
            ->group(group)
            ->trigger_on_parse();
      };
      set(spelled(names), "true", text);
      set(spelled(names, "--no-"), "false", "the opposite of --" + names.front());
    } else {
      app.add_option_function<std::string>(
             spelled(names), [&words, key](const std::string& word) { words[key] = word; }, text)
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
  CLI::Option* const path = app.get_option("--trajectory");
  path->description(path->get_description() + "; or a file with columns x, y and a time, or --dt");
  app.get_option("--disturbance")
      ->description(app.get_option("--disturbance")->get_description() +
                    "; or a file with columns force, moment");
  app.add_flag("--closed", arguments.closed,
               "the path in the file of --trajectory is closed: its first point follows the last")
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
  app.add_option("--tune-seed", arguments.tune_seed,
                 "seed of the search; --seed is that of the run's noise (default 0)")
      ->needs("--tune")
      ->group("Tuning")
      ->type_name("N")
      ->check(CLI::Range(std::uint64_t{0}, std::uint64_t{1} << 53));
  app.add_flag("--json", arguments.json, "print the metrics as one JSON object, nothing else")
      ->disable_flag_override();
  app.add_flag("--quiet", arguments.quiet, "print nothing but what --json asks for")
      ->disable_flag_override();
  app.set_version_flag("--version", arguments.program + " " + NFOPIDN_VERSION);
  app.get_formatter()->column_width(help_column);
  app.footer(
      "Without options but --trajectory ranunculoid this is the paper's scenario under its gains.\n"
      "Torques have the paper's sign: a positive left torque turns the robot counter-clockwise.\n"
      "Exit code: 0 done, 2 bad usage or bad file, 3 the run diverged (after --tune: that of the "
      "best\n"
      "controller), 130 --tune was interrupted (by Ctrl-C or SIGTERM; the best so far is run and\n"
      "written).");
}

// Names the option that was probably meant by the first one that is unknown.
std::string option_suggestion(const CLI::App& app) {
  std::vector<std::string> known;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back(name);
  }
  for (const std::string& word : app.remaining()) {
    if (word.rfind("--", 0) != 0) continue;
    const std::string name = word.substr(2, word.find('=') - 2);
    const std::string nearest = nearest_word(name, known);
    return nearest.empty() ? "" : " (did you mean --" + nearest + "?)";
  }
  return "";
}

}  // namespace

std::optional<int> parse(const std::vector<std::string>& words, Arguments& arguments) {
  CLI::App app("Simulates a differential-drive robot under the NFOPIDN controller.",
               arguments.program);
  declare(app, arguments);
  try {
    app.parse(std::vector<std::string>(words.rbegin(), words.rend()));  // CLI11 reads from the end
  } catch (const CLI::Success& asked) {                                 // --help, --version
    std::ostringstream text;
    app.exit(asked, text, text);
    const Outcome printed = print(text.str());
    return printed ? exit_done : fail(arguments, printed);
  } catch (const CLI::ParseError& error) {
    std::string message = error.what();
    const std::string clumsy = " was given a disallowed flag override";
    if (const auto place = message.find(clumsy); place != std::string::npos) {
      message = "--" + message.replace(place, clumsy.size(), " takes no value");
    }
    message += option_suggestion(app) + "; see --help";
    return fail(arguments, {Status::not_a_choice, message});
  }
  return std::nullopt;
}

}  // namespace nfopidn::commands
