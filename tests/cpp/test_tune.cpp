// The cost over several scenarios, against the costs of each.
#include "nfopidn/tune.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

TEST(TuneObjective, IsTheMeanOfTheWorstScenarios) {
  Scenario scenarios[3] = {short_scenario(), short_scenario(), short_scenario()};
  scenarios[1].robot.mass = 20;
  scenarios[2].initial_pose = {{2.0, 0.5, 1.0}};
  const std::vector<const Scenario*> all = {&scenarios[0], &scenarios[1], &scenarios[2]};
  const Structure structure;
  const ControllerDesign design(structure.settings);
  const std::vector<double> x = parameters_of(structure.parameters, design);
  const auto size = static_cast<Eigen::Index>(x.size());
  double each[3];
  for (int i = 0; i < 3; ++i) each[i] = evaluate(prepare(scenarios[i]), design);
  std::sort(each, each + 3);
  ASSERT_LT(each[0], each[1]);
  ASSERT_LT(each[1], each[2]);
  const auto cost = [&](double share) {
    TuneObjective objective(all, structure, FreeParameters::all(x.size()),
                            static_cast<int>(x.size()), share, 1);
    double result = 0;
    objective.costs(Eigen::Map<const Point>(x.data(), size), &result);
    return result;
  };
  EXPECT_NEAR(cost(1), (each[0] + each[1] + each[2]) / 3, 1e-10);
  EXPECT_NEAR(cost(0.5), (each[2] + 0.5 * each[1]) / 1.5, 1e-10);
  EXPECT_NEAR(cost(0), each[2], 1e-10);
}

// On the published scenario the lateral error as it is serves free taps better than by speed.
TEST(RunTuning, ChoosesWhatTheLateralChannelIsFed) {
  const Scenario scenario = Scenario::published();
  TuningTask task;
  task.scenarios = {&scenario};
  task.structure = named_structure(StructureName::taps);
  task.evaluations = 10000;
  task.seed = 2;
  const TuningResult found = run_tuning(task);
  EXPECT_EQ(found.evaluations, 10000);
  EXPECT_EQ(found.structure.settings.lateral, Lateral::direction);
  const ControllerDesign design =
      design_of(found.structure, std::vector<double>(found.x.begin(), found.x.end()));
  EXPECT_NEAR(simulate(scenario, design).metrics.cost, found.cost, 1e-9 * found.cost);
  task.structure.either_lateral = false;
  const TuningResult by_speed = run_tuning(task);
  EXPECT_EQ(by_speed.structure.settings.lateral, Lateral::speed);
  EXPECT_EQ(by_speed.evaluations, 10000);
  EXPECT_GT(by_speed.cost, found.cost);
}

// Asked to stop in one of its stages, it does not go on to the next.
TEST(RunTuning, StopsWhenAsked) {
  const Scenario scenario = Scenario::published();
  TuningTask task;
  task.scenarios = {&scenario};
  task.structure = named_structure(StructureName::taps);
  task.evaluations = 4000;
  int whole = 0;
  run_tuning(task, [&](const SearchResult&) { return ++whole > 0; });
  for (const int last : {2, whole / 2, whole - 2}) {
    int calls = 0;
    const TuningResult found =
        run_tuning(task, [&](const SearchResult&) { return ++calls < last; });
    EXPECT_EQ(calls, last);
    EXPECT_EQ(found.reason, StopReason::callback);
  }
}

}  // namespace
}  // namespace nfopidn::test
