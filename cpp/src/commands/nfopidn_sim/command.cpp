#include "command.hpp"

#include <exception>
#include <iostream>
#include <new>
#include <optional>

#include "arguments.hpp"
#include "controller.hpp"
#include "nfopidn/io/files.hpp"
#include "nfopidn/io/json_controller.hpp"
#include "nfopidn/io/json_scenario.hpp"
#include "nfopidn/tuning/monte_carlo.hpp"
#include "output.hpp"
#include "scenario.hpp"
#include "stop_requests.hpp"
#include "tune.hpp"
#include "verdict.hpp"

namespace nfopidn::commands {

namespace {

// What is worth saying before the run.
void tell_notes(const Arguments& arguments, const Scenario& scenario,
                const ControllerDesign& design) {
  if (arguments.quiet) return;
  for (const std::string& note : scenario.trajectory.notes) say(arguments, note);
  const std::string other = arguments.tune ? "" : explain_robot(design, scenario.modelled_robot());
  if (!other.empty()) say(arguments, other);
}

int run(const Arguments& arguments) {
  Scenario scenario;
  ControllerDesign design;
  Outcome built = build_scenario(arguments, scenario);
  Json verdict;
  if (built) built = build_controller(arguments, scenario, design, verdict);
  if (!built) return fail(arguments, built);
  if (arguments.tune && !arguments.controller_file.empty()) {
    if (Outcome outcome = check_start(arguments, scenario, design); !outcome)
      return fail(arguments, outcome);
  }
  MethodOptions method;
  if (Outcome outcome = read_method(arguments, method); !outcome) return fail(arguments, outcome);
  // Whether the files can be written shows before the run, not after.
  const Outputs outputs = {arguments.out, arguments.save_scenario, arguments.save_controller};
  if (Outcome outcome = check_outputs(outputs, inputs_of(arguments)); !outcome) {
    return fail(arguments, outcome);
  }
  // From here on no file is open until the search is over: a second signal leaves none behind.
  std::optional<StopRequests> requests;
  if (arguments.tune) requests.emplace();
  tell_notes(arguments, scenario, design);
  if (arguments.tune && !tune_design(arguments, method, scenario, design)) return exit_interrupted;
  requests.reset();
  const SimulationResult result = simulate_as_drawn(scenario, design);
  const Outputs contents = {run_table_csv(result.table), document_text(write_scenario(scenario)),
                            document_text(write_controller(design))};
  if (Outcome outcome = write_all(outputs, contents); !outcome) return fail(arguments, outcome);
  Outcome printed = print_result(arguments, scenario, result);
  if (printed && !arguments.json && !arguments.quiet) {
    printed = print("\n" + printable(verdict_line(verdict, scenario, design, result)) + "\n");
  }
  if (!printed) return fail(arguments, printed);
  if (arguments.tune && StopRequests::asked()) return exit_interrupted;
  if (arguments.tune && result.diverged) explain_divergence(arguments, scenario, result);
  return result.diverged ? exit_diverged : exit_done;
}

}  // namespace

int run_simulate(const std::string& program, const std::vector<std::string>& words) {
  try {
    Arguments arguments;
    arguments.program = program;
    if (const std::optional<int> code = parse(words, arguments)) return *code;
    return run(arguments);
  } catch (const std::bad_alloc&) {
    std::cerr << program << ": out of memory\n";
  } catch (const std::exception& error) {
    std::cerr << program << ": " << error.what() << "\n";
  }
  return exit_bad_input;
}

}  // namespace nfopidn::commands
