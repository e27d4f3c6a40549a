// What the command prints and writes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "arguments.hpp"
#include "nfopidn/io/outcome.hpp"
#include "nfopidn/simulation/scenario.hpp"
#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn::commands {

// A line on standard error, under the program's name.
void say(const Arguments& arguments, const std::string& text);

// Says what is wrong; the exit code for it.
int fail(const Arguments& arguments, const Outcome& outcome);

// Text to standard output, or the reason why not.
Outcome print(const std::string& text);

// The metrics, as text or JSON, unless --quiet asks for neither.
Outcome print_result(const Arguments& arguments, const Scenario& scenario,
                     const SimulationResult& result);

// Says that the best controller of a search diverges, and what may be why.
void explain_divergence(const Arguments& arguments, const Scenario& scenario,
                        const SimulationResult& result);

// The files that the options name to be read.
std::vector<std::string> inputs_of(const Arguments& arguments);

// Run table, scenario and controller: their paths, or what they hold.
using Outputs = std::array<std::string, 3>;  // a path is empty where none is wanted

Outcome check_outputs(const Outputs& paths, const std::vector<std::string>& inputs);

// Writes what can be written; names all that cannot.
Outcome write_all(const Outputs& paths, const Outputs& contents);

}  // namespace nfopidn::commands
