#include "tune.hpp"

#include <unistd.h>

#include "controller.hpp"
#include "nfopidn/io/json_method.hpp"
#include "nfopidn/tuning/tune.hpp"
#include "output.hpp"
#include "stop_requests.hpp"

namespace nfopidn::commands {

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

bool tune_design(const Arguments& arguments, const MethodOptions& method, const Scenario& scenario,
                 ControllerDesign& design) {
  const Structure structure = structure_to_tune(arguments, scenario, design);
  std::vector<double> start;
  if (!arguments.controller_file.empty()) start = parameters_of(structure.parameters, design);
  TuningPlan plan = plan_tuning({&scenario}, structure, start);
  plan.search.method = method;
  plan.search.limits.evaluations = arguments.maxfev.value_or(default_budget(method));
  plan.search.seed = arguments.tune_seed;
  const bool shown = !arguments.quiet && ::isatty(STDERR_FILENO) != 0;
  const auto show = [&](std::int64_t evaluations, double cost) {
    if (shown) {
      std::fprintf(stderr, "\rtuning: %lld evaluations, cost %.6g ",
                   static_cast<long long>(evaluations), cost);
    }
  };
  const TuningResult found = run_tuning(plan, show, StopRequests::asked);
  if (shown) std::fputc('\n', stderr);
  if (found.reason == StopReason::callback) {
    say(arguments, "interrupted after " + std::to_string(found.evaluations) + " evaluations");
  }
  if (found.x.size() == 0) return false;
  design = design_of(found.structure, std::vector<double>(found.x.begin(), found.x.end()));
  design.sample_time = scenario.trajectory.dt();
  if (structure.parameters == ParameterSet::tracking) design.robot = scenario.robot;
  return true;
}

}  // namespace nfopidn::commands
