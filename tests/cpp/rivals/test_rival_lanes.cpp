// Rivals in lanes: costs and slopes against single runs.
#include "nfopidn/rivals/tuning.hpp"
#include "support.hpp"

namespace nfopidn::rivals {
namespace {

std::vector<RivalDesign> designs() {
  std::vector<RivalDesign> all;
  for (std::size_t law = 0; law < law_count; ++law) {
    for (const Speeds speeds : {Speeds::measured, Speeds::differenced}) {
      for (const bool integral : {false, true}) {
        RivalDesign design;
        design.law = law;
        design.speeds = speeds;
        design.integral = integral;
        design.parameters = default_parameters(law, integral);
        if (integral) {
          design.parameters.end()[-2] = 0.3;
          design.parameters.end()[-1] = 0.1;
        }
        all.push_back(design);
      }
    }
  }
  return all;
}

std::vector<Scenario> scenarios() {
  std::vector<Scenario> all(6, Scenario::published());
  all[1].pose_noise = {0.005, 0.005};
  all[1].delay = 1;
  all[2].integrator = Integrator::exact;
  all[2].coulomb_friction = 0.02;
  all[3].integrator = Integrator::exact;
  all[3].viscous_friction = 0.02;
  all[3].coulomb_friction = 0.02;  // not in lanes
  all[4].torque_limit = 0.4;
  all[5].viscous_scrub = 0.05;
  all[5].coulomb_scrub = 0.02;
  return all;
}

Points around(const std::vector<double>& parameters, int count) {
  Points points(static_cast<Eigen::Index>(parameters.size()), count);
  for (Eigen::Index j = 0; j < count; ++j) {
    for (Eigen::Index i = 0; i < points.rows(); ++i) {
      const double factor = 1 + 0.01 * static_cast<double>((7 * i + 3 * j) % 11 - 5);
      points(i, j) = parameters[static_cast<std::size_t>(i)] * factor;
    }
  }
  return points;
}

TEST(RivalLanes, CostWhatSingleRunsCost) {
  constexpr double most = 0.05;
  int compared = 0;
  for (const Scenario& scenario : scenarios()) {
    for (const RivalDesign& design : designs()) {
      const Points points = around(design.parameters, 11);
      const auto size = static_cast<int>(points.rows());
      EXPECT_EQ(RivalEvaluator(scenario, design).has_lanes(), lane_law(design.law).has_value());
      RivalObjective objective({&scenario}, design, FreeParameters::all(design.parameters.size()),
                               size, 1, 2);
      Eigen::VectorXd costs(points.cols());
      objective.costs(points, costs.data());
      for (Eigen::Index j = 0; j < points.cols(); ++j) {
        RivalDesign one = design;
        one.parameters.assign(points.col(j).begin(), points.col(j).end());
        const double cost = simulate(scenario, one).metrics.cost;
        if (cost > most) continue;  // of runs that hardly track no digit stays
        ++compared;
        EXPECT_NEAR(costs(j), cost, 1e-9 * cost) << law_name(design.law) << " " << j;
      }
    }
  }
  EXPECT_GT(compared, 250);
}

TEST(RivalLanes, HaveTheSameBitsOnEveryInstructionSet) {
  const Scenario scenario = scenarios()[1];
  for (const RivalDesign& design : designs()) {
    if (!lane_law(design.law)) continue;
    RivalEvaluator evaluator(scenario, design);
    const Points points = around(design.parameters, 9);
    std::vector<double> numbers, first, second(9);
    int count = 0;
    for (Eigen::Index j = 0; j < points.cols(); ++j) {
      const std::vector<double> own = lane_numbers<double>(
          design, evaluator.model(), {points.col(j).begin(), points.col(j).end()});
      numbers.insert(numbers.end(), own.begin(), own.end());
      count = static_cast<int>(own.size());
    }
    for (const InstructionSet set : {InstructionSet::generic, InstructionSet::sse2,
                                     InstructionSet::avx2, InstructionSet::avx512}) {
      evaluator.set_instruction_set(set);
      if (!evaluator.has_lanes()) continue;
      evaluator.costs(numbers, 0, 9, count, second.data(), nullptr);
      if (first.empty()) first = second;
      EXPECT_EQ(first, second) << law_name(design.law);
      // Nor does the company matter.
      double alone = 0;
      evaluator.costs(numbers, 4, 1, count, &alone, nullptr);
      EXPECT_EQ(alone, first[4]);
    }
    EXPECT_FALSE(first.empty()) << "no instruction set has lanes";
  }
}

TEST(RivalLanes, GiveSlopesThatDifferencesConfirm) {
  const std::vector<Scenario> all = scenarios();
  int compared = 0;
  for (const RivalDesign& design : designs()) {
    if (!lane_law(design.law)) continue;
    const auto size = static_cast<int>(design.parameters.size());
    RivalObjective objective({&all[0], &all[3]}, design,
                             FreeParameters::all(design.parameters.size()), size, 1, 1);
    ASSERT_TRUE(objective.has_gradient());
    const Point x = around(design.parameters, 4).col(3);
    Point slopes(size);
    const double cost = objective.gradient(x, slopes.data());
    if (cost > 0.05) continue;  // runs that hardly track change with every digit
    ++compared;
    for (Eigen::Index i = 0; i < size; ++i) {
      const double step = 1e-5 * std::max(1e-3, std::abs(x(i)));
      Points both = x.replicate(1, 3);
      both(i, 0) -= step;
      both(i, 1) += step;
      double costs[3];
      objective.costs(both, costs);
      EXPECT_NEAR(cost, costs[2], 1e-9 * cost);
      const double slope = (costs[1] - costs[0]) / (2 * step);
      const double scale = cost / std::max(1e-3, std::abs(x(i)));
      EXPECT_NEAR(slopes(i), slope, 1e-4 * std::abs(slope) + 1e-6 * scale)
          << law_name(design.law) << " " << i;
    }
  }
  EXPECT_GE(compared, 6);
}

TEST(RivalLanes, AbandonWhatIsOverItsBound) {
  const Scenario scenario = scenarios()[0];
  RivalDesign design;
  design.parameters = default_parameters(design.law);
  const Points points = around(design.parameters, 4);
  RivalObjective objective({&scenario}, design, FreeParameters::all(design.parameters.size()),
                           static_cast<int>(points.rows()), 1, 1);
  double costs[4], bounded[4];
  objective.costs(points, costs);
  const double bounds[4] = {costs[0] / 10, costs[1] * 2, costs[2] / 10, costs[3] * 2};
  objective.bounded_costs(points, bounds, bounded);
  for (const int over : {0, 2}) {
    EXPECT_GT(bounded[over], bounds[over]);
    EXPECT_NE(bounded[over], costs[over]);  // it was not run to its end
  }
  EXPECT_EQ(bounded[1], costs[1]);
  EXPECT_EQ(bounded[3], costs[3]);
}

TEST(RivalObjective, HasNoGradientOfALawWithoutLanes) {
  const Scenario scenario = scenarios()[0];
  for (std::size_t law = 0; law < law_count; ++law) {
    RivalDesign design;
    design.law = law;
    const std::size_t size = default_parameters(law).size();
    const RivalObjective objective({&scenario}, design, FreeParameters::all(size),
                                   static_cast<int>(size), 1, 1);
    EXPECT_EQ(objective.has_gradient(), lane_law(law).has_value()) << law_name(law);
  }
}

// PI of P: of a constant disturbance no error of the speed is left.
TEST(IntegralAction, TakesAConstantDisturbanceAway) {
  TrajectorySettings line;
  line.name = Curve::line;
  line.period = 60;
  Scenario scenario = Scenario::published();
  scenario.trajectory = test::make(line);
  scenario.initial_pose.reset();
  scenario.initial_velocity.reference = true;
  scenario.disturbance = {{-1.0, 0.0}};
  RivalDesign design;
  design.parameters = default_parameters(design.law);
  const auto last_lag = [&] {
    const RunTable table = simulate(scenario, design).table;
    return std::abs(table(table.rows() - 1, column_e_x));
  };
  const double without = last_lag();
  design.integral = true;
  design.parameters = default_parameters(design.law, true);
  EXPECT_NEAR(last_lag(), without, 1e-12);  // gains of zero
  design.parameters.end()[-2] = 0.3;
  EXPECT_LT(last_lag(), 0.02 * without);
}

}  // namespace
}  // namespace nfopidn::rivals
