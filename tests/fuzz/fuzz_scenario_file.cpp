// Any bytes as a scenario file; a short one that is accepted is run.
#include "documents.hpp"
#include "nfopidn/simulation/simulate.hpp"

using namespace nfopidn;

namespace {

// Millions of samples are in range, and only slow.
constexpr double most_samples = 5000;
constexpr double most_steps = 20000;

Outcome read_short_scenario(const Json& document, Scenario& result) {
  const auto found = document.is_object() ? document.find("trajectory") : document.end();
  TrajectorySettings settings = result.trajectory.settings;
  if (found != document.end() && read_settings(*found, "", settings, {"x", "y"}) &&
      sample_count(settings) * settings.laps > most_samples) {
    return {Status::wrong_size, "too long to be fuzzed"};
  }
  return read_scenario(document, result);
}

void check_run(const Scenario& scenario) {
  const SimulationResult result = simulate(scenario, ControllerSettings<double>{});
  fuzz::require(std::isfinite(result.metrics.cost), "the cost is a number");
  fuzz::require(result.table.isFinite().all(), "the run table holds numbers");
  fuzz::require(result.diverged || result.table.rows() == scenario.trajectory.size(),
                "a run ends early only where it diverges");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Scenario start = default_scenario();
  Scenario scenario;
  const bool accepted = fuzz::check_document(fuzz::text_of(data, size), read_short_scenario,
                                             write_scenario, start, scenario);
  if (accepted &&
      static_cast<double>(scenario.trajectory.size()) * scenario.substeps <= most_steps) {
    check_run(scenario);
  }
  return 0;
}
