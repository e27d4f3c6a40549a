// The scenario that the arguments describe.
#pragma once

#include "arguments.hpp"
#include "nfopidn/io/outcome.hpp"
#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn::commands {

// Whether a word for --disturbance is a file's name: one that exists, or that ends as a table's.
bool names_file(const std::string& word);

// Whether a word for --trajectory is. The name of a curve comes first; none has a point or a slash.
bool names_path_file(const std::string& word);

// The published scenario or that of a file, with the options over it.
Outcome build_scenario(const Arguments& arguments, Scenario& scenario);

}  // namespace nfopidn::commands
