// What the command is asked to do, as its command line says it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nfopidn/io/options.hpp"
#include "nfopidn/search/method.hpp"

namespace nfopidn::commands {

constexpr int exit_done = 0;
constexpr int exit_bad_input = 2;
constexpr int exit_diverged = 3;
constexpr int exit_interrupted = 130;

struct Arguments {
  std::string program;  // its name, for messages
  Words trajectory, robot, scenario, controller;
  std::string scenario_file, controller_file, out, save_scenario, save_controller, structure;
  std::string method = name_of({});
  std::vector<std::string> options;  // of the method, NAME=NUMBER
  std::optional<std::int64_t> maxfev;
  std::uint64_t tune_seed = 0;
  bool closed = false;  // the path of --trajectory FILE ends where it began
  bool tune = false;
  bool json = false;
  bool quiet = false;
};

// Fills the arguments with the command line's words. What is asked for may be done then, as with
// --help, or cannot be done: the answer is the exit code to end with.
std::optional<int> parse(const std::vector<std::string>& words, Arguments& arguments);

}  // namespace nfopidn::commands
