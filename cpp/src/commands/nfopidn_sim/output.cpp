#include "output.hpp"

#include <cstdio>
#include <filesystem>
#include <iostream>

#include "nfopidn/io/files.hpp"
#include "nfopidn/io/json.hpp"
#include "scenario.hpp"

namespace nfopidn::commands {

namespace {

template <class... Values>
std::string format(const char* pattern, Values... values) {
  char line[512];
  std::snprintf(line, sizeof line, pattern, values...);
  return line;
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
      "--initial-velocity reference starts it with these.\n",
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

}  // namespace

void say(const Arguments& arguments, const std::string& text) {
  std::cerr << arguments.program << ": " << printable(text) << "\n";
}

int fail(const Arguments& arguments, const Outcome& outcome) {
  say(arguments, outcome.message);
  return exit_bad_input;
}

Outcome print(const std::string& text) {
  errno = 0;
  const bool written = std::fwrite(text.data(), 1, text.size(), stdout) == text.size();
  if (!written || std::fflush(stdout) != 0) {
    return file_fault("standard output", "cannot be written");
  }
  return {};
}

Outcome print_result(const Arguments& arguments, const Scenario& scenario,
                     const SimulationResult& result) {
  if (arguments.json) return print(metrics_json(result).dump() + "\n");
  if (!arguments.quiet) return print(summary(scenario, result));
  return {};
}

void explain_divergence(const Arguments& arguments, const Scenario& scenario,
                        const SimulationResult& result) {
  say(arguments, "--tune: the best controller that was found diverges at " +
                     format("%g s", result.diverged_at));
  if (arguments.json || arguments.quiet) std::cerr << start_advice(scenario);
}

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

}  // namespace nfopidn::commands
