// A tuning in C++: the gains and orders of least cost for a circle.
// Link it with nfopidn::batch: find_package(nfopidn), or add_subdirectory with NFOPIDN_BATCH=ON.
#include "nfopidn/tuning/tune.hpp"

#include <cstdio>

int main() {
  using namespace nfopidn;
  Scenario scenario = Scenario::published();
  TrajectorySettings circle;
  circle.name = Curve::circle;
  if (make_trajectory(circle, scenario.trajectory) != Status::ok) return 1;
  scenario.initial_pose.reset();

  TuningPlan plan = plan_tuning({&scenario}, named_structure(StructureName::decoupled));
  plan.search.limits.evaluations = 5000;
  plan.search.seed = 1;
  const TuningResult found = run_tuning(plan);
  const ControllerDesign design =
      design_of(found.structure, std::vector<double>(found.x.begin(), found.x.end()));
  std::printf("cost %.3g after %lld evaluations; simulated again: %.3g\n", found.cost,
              static_cast<long long>(found.evaluations), simulate(scenario, design).metrics.cost);
}
