#include "controller.hpp"

#include "nfopidn/io/files.hpp"
#include "nfopidn/io/json_controller.hpp"
#include "output.hpp"

namespace nfopidn::commands {

namespace {

// What --structure names must be what is searched: neither a file's controller, from which the
// search then starts, nor an option may make it another.
Outcome check_structure(const Arguments& arguments, const Structure& structure,
                        const ControllerDesign& start) {
  if (arguments.structure.empty()) return {};
  const std::string about = "--structure " + arguments.structure + ": ";
  const bool taps_wanted = structure.parameters == ParameterSet::taps;
  if (!start.taps.empty() && !taps_wanted) {
    return {Status::inconsistent,
            about + arguments.controller_file + " has free taps; gains and orders are needed"};
  }
  const Json wanted = write_settings<ControllerSettings<double>>(structure.settings);
  const Json given = write_settings<ControllerSettings<double>>(start);
  for (const std::string key : {"form", "allocation", "lateral"}) {
    if (given[key] == wanted[key] || (key == "lateral" && taps_wanted)) continue;
    const bool by_option = arguments.controller.count(key) != 0;
    std::string message = about + key;
    if (!by_option) message += " of " + arguments.controller_file;
    message += " is " + given[key].dump() + "; must be " + wanted[key].dump();
    return {Status::inconsistent, message};
  }
  if (structure.parameters == ParameterSet::shared_orders && !shares_orders(start)) {
    return {Status::inconsistent, about + "alpha and sigma must be one for all channels"};
  }
  return {};
}

// Settings that would have no effect.
Outcome refuse_ignored(const Arguments& arguments, const ControllerDesign& design) {
  if (!design.taps.empty()) {
    for (const char* key : {"gains", "alpha", "sigma", "generator", "memory"}) {
      if (arguments.controller.count(key) == 0) continue;
      return {Status::inconsistent,
              std::string(key) + " does not apply to a controller of free taps"};
    }
  }
  if (arguments.tune && arguments.controller_file.empty()) {
    for (const std::string key : {"gains", "alpha", "sigma"}) {
      if (arguments.controller.count(key) == 0) continue;
      const char* verb = key == "gains" ? " are" : " is";
      return {Status::inconsistent, "--tune: " + key + verb + " what is searched for"};
    }
  }
  return {};
}

// A file's controller that does not know its sample time is run at the scenario's, which is said.
void note_unknown_sample_time(const Arguments& arguments, const ControllerDesign& design,
                              double dt) {
  const bool by_option = arguments.controller.count("sample_time") != 0;
  if (arguments.controller_file.empty() || by_option || arguments.quiet) return;
  if (design.sample_time.has_value()) return;
  say(arguments, arguments.controller_file +
                     " does not carry its sample time; the controller is run at the scenario's, " +
                     number_text(dt) + " s (--sample-time says it)");
}

}  // namespace

Outcome build_controller(const Arguments& arguments, const Scenario& scenario,
                         ControllerDesign& design, Json& verdict) {
  Structure structure;
  if (!arguments.structure.empty()) {
    StructureName name{};
    Outcome outcome;
    json::read(arguments.structure, json::Context{"structure", {}, "", &outcome}, name);
    if (!outcome) return outcome;
    structure = named_structure(name);
    design = ControllerDesign(structure.settings);
  }
  if (!arguments.controller_file.empty()) {
    const auto read = [&](const Json& document, ControllerDesign& result) {
      Outcome outcome = read_controller(document, result);
      if (outcome) verdict = document.value("verdict", Json());
      return outcome;
    };
    Outcome outcome = load_document(arguments.controller_file, read, design);
    if (!outcome) return outcome;
  }
  if (Outcome outcome = refuse_ignored(arguments, design); !outcome) return outcome;
  ControllerSettings<double>& settings = design;
  const Json given = words_to_json<ControllerSettings<double>>(arguments.controller);
  if (Outcome outcome = read_settings(given, "", settings); !outcome) return outcome;
  if (Outcome outcome = check_structure(arguments, structure, design); !outcome) return outcome;
  if (arguments.tune) {
    if (Outcome outcome = explain_memory_to_tune(design.memory); !outcome) return outcome;
  }
  const double dt = scenario.trajectory.dt();
  Outcome outcome = explain_sample_time(design, dt);
  if (!outcome && !arguments.controller_file.empty()) {
    outcome.message = arguments.controller_file + ": " + outcome.message;
  }
  if (outcome) outcome = explain_consistency(design);
  if (outcome) note_unknown_sample_time(arguments, design, dt);
  return outcome;
}

Structure structure_to_tune(const Arguments& arguments, const Scenario& scenario,
                            const ControllerDesign& design) {
  Structure structure = {design, parameter_set_of(design)};
  structure.scale = tracking_scale(scenario);
  if (structure.parameters == ParameterSet::taps) return structure;
  if (arguments.structure == "extended") structure.parameters = ParameterSet::orders_by_channel;
  if (arguments.structure == "taps") {
    structure.parameters = ParameterSet::taps;
    structure.either_lateral =
        arguments.controller_file.empty() && arguments.controller.count("lateral") == 0;
  }
  return structure;
}

Outcome check_start(const Arguments& arguments, const Scenario& scenario,
                    const ControllerDesign& design) {
  const Structure structure = structure_to_tune(arguments, scenario, design);
  const std::vector<double> start = parameters_of(structure.parameters, design);
  const std::vector<ParameterBounds> bounds = default_bounds(structure);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const ParameterBounds& b = bounds[i];
    const double slack = 1e-9 * (b.high - b.low);
    if (start[i] >= b.low - slack && start[i] <= b.high + slack) continue;
    Outcome outcome =
        refuse_number(b.name, start[i], between(b.low, b.high), "to start a search from");
    outcome.message = arguments.controller_file + ": " + outcome.message;
    return outcome;
  }
  return {};
}

}  // namespace nfopidn::commands
