#include "verdict.hpp"

#include <cstdio>

#include "nfopidn/io/json_controller.hpp"
#include "nfopidn/io/json_scenario.hpp"
#include "nfopidn/io/sha256.hpp"
#include "nfopidn/tuning/monte_carlo.hpp"

namespace nfopidn::commands {

namespace {

// As nfopidn.robustness has it: 16 hexadecimal digits of the document's SHA-256.
std::string digest(const Json& document) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx",
                static_cast<unsigned long long>(sha256_start(document.dump())));
  return digits;
}

std::string text_of(const Json& object, const char* key) {
  const auto found = object.find(key);
  return found != object.end() && found->is_string() ? found->get<std::string>() : "";
}

// Colour and reasons of a verdict; empty of what is none.
std::string stored_line(const Json& stored) {
  const std::string colour = text_of(stored, "colour");
  if (colour != "green" && colour != "amber" && colour != "red") return "";
  std::string line = colour;
  const char* before = ": ";
  for (const Json& reason : stored.value("reasons", Json::array())) {
    if (!reason.is_string()) return "";
    line += before + reason.get<std::string>();
    before = "; ";
  }
  return line + " (from the controller's file)";
}

std::string diverges(const char* what, double at) {
  char text[128];
  std::snprintf(text, sizeof text, "red: %s diverges at %.4g s", what, at);
  return text;
}

std::string judge(const Json& stored, const Scenario& scenario, const ControllerDesign& design,
                  const SimulationResult& result) {
  if (result.diverged) return diverges("the run", result.diverged_at);
  const bool is_of_these =
      stored.is_object() &&
      text_of(stored, "controller_digest") == digest(write_controller(design)) &&
      text_of(stored, "scenario_digest") == digest(write_scenario(scenario));
  if (is_of_these) {
    if (std::string line = stored_line(stored); !line.empty()) return line;
  }
  if (scenario.delay < maximum_delay) {
    Scenario late = scenario;
    ++late.delay;
    const SimulationResult run = simulate_as_drawn(late, design);
    if (run.diverged) return diverges("with one sample of delay more it", run.diverged_at);
  }
  const char* why = stored.is_null() ? "" : " (its file's is on another controller or scenario)";
  return std::string("not verified") + why + "; `nfopidn verdict` runs the variations";
}

}  // namespace

std::string verdict_line(const Json& stored, const Scenario& scenario,
                         const ControllerDesign& design, const SimulationResult& result) {
  return "verdict: " + judge(stored, scenario, design, result);
}

}  // namespace nfopidn::commands
