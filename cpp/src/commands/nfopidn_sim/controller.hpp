// The controller that the arguments describe, and what --tune searches for.
#pragma once

#include "arguments.hpp"
#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/io/json.hpp"
#include "nfopidn/io/outcome.hpp"
#include "nfopidn/simulation/scenario.hpp"
#include "nfopidn/tuning/structures.hpp"

namespace nfopidn::commands {

// The published controller, that of a structure or that of a file, with the options over it; and
// the verdict that the file carries, null where there is none.
Outcome build_controller(const Arguments& arguments, const Scenario& scenario,
                         ControllerDesign& design, Json& verdict);

// Which of the controller's numbers --tune searches for.
Structure structure_to_tune(const Arguments& arguments, const Scenario& scenario,
                            const ControllerDesign& design);

// A file's controller must lie where the search looks.
Outcome check_start(const Arguments& arguments, const Scenario& scenario,
                    const ControllerDesign& design);

}  // namespace nfopidn::commands
