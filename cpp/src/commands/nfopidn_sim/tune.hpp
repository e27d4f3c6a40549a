// The search that --tune asks for.
#pragma once

#include "arguments.hpp"
#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/io/outcome.hpp"
#include "nfopidn/search/method.hpp"
#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn::commands {

// The method of --method with the options of --option.
Outcome read_method(const Arguments& arguments, MethodOptions& method);

// Searches from the design, if a file gave one; shows its progress in a terminal. False if nothing
// was found before an interruption.
bool tune_design(const Arguments& arguments, const MethodOptions& method, const Scenario& scenario,
                 ControllerDesign& design);

}  // namespace nfopidn::commands
