// What can be said of a controller without Python: a verdict that its file carries, or that a run
// diverges.
#pragma once

#include <string>

#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/io/json.hpp"
#include "nfopidn/simulation/scenario.hpp"
#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn::commands {

// One line. `stored` is what the controller's file has under "verdict", null where it has none; it
// counts if it is on this controller and this scenario, to the last bit. `result` is of their run.
std::string verdict_line(const Json& stored, const Scenario& scenario,
                         const ControllerDesign& design, const SimulationResult& result);

}  // namespace nfopidn::commands
