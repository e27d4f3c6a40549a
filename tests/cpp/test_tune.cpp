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

}  // namespace
}  // namespace nfopidn::test
