// The cost over several scenarios, against the costs of each.
#include "nfopidn/tuning/tune.hpp"
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
    TuneObjective objective(all, ParameterSpace::whole(structure), share, 1);
    double result = 0;
    objective.costs(Eigen::Map<const Point>(x.data(), size), &result);
    return result;
  };
  EXPECT_NEAR(cost(1), (each[0] + each[1] + each[2]) / 3, 1e-10);
  EXPECT_NEAR(cost(0.5), (each[2] + 0.5 * each[1]) / 1.5, 1e-10);
  EXPECT_NEAR(cost(0), each[2], 1e-10);
}

TEST(CostCap, GrowsAsTheLogarithmBeyondTheCap) {
  const CostCap cap{2.0};
  EXPECT_EQ(cap.seen(1.5), 1.5);
  EXPECT_NEAR(cap.seen(20), 2 * (1 + std::log(10.0)), 1e-14);
  EXPECT_NEAR(cap.unseen(cap.seen(20)), 20, 1e-12);
  EXPECT_EQ(cap.unseen(1.5), 1.5);
  for (const double cost : {1.0, 3.0, 50.0}) {
    EXPECT_NEAR(cap.slope(cost), (cap.seen(cost + 1e-6) - cap.seen(cost - 1e-6)) / 2e-6, 1e-8);
  }
}

TEST(CostCap, IsTenTimesWhatFrictionCosts) {
  Scenario scenario = short_scenario();
  EXPECT_EQ(family_cap(scenario), 1);
  scenario.coulomb_friction = 0.4;  // of two wheels, at each sample in motion
  const Trajectory& t = scenario.trajectory;
  int turning = 0;
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const double half = 0.5 * scenario.robot.track_width * t.omega(k);
    turning += (t.v(k) + half != 0 ? 1 : 0) + (t.v(k) - half != 0 ? 1 : 0);
  }
  EXPECT_NEAR(family_cap(scenario), 10 * 0.16 * turning / static_cast<double>(t.size()), 1e-12);
  scenario.viscous_friction = 0.5;
  EXPECT_GT(friction_cost(scenario), 0.32);
}

// Scrub asks of both wheels the same, in opposite directions.
TEST(CostCap, CountsWhatScrubCosts) {
  Scenario scenario = short_scenario();
  scenario.viscous_scrub = 0.05;
  scenario.coulomb_scrub = 0.1;
  const Trajectory& t = scenario.trajectory;
  double sum = 0;
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const double moment = 0.05 * std::fabs(t.omega(k)) + (t.omega(k) != 0 ? 0.1 : 0);
    const double torque = moment * scenario.robot.wheel_radius / scenario.robot.track_width;
    sum += 2 * torque * torque;
  }
  EXPECT_GT(sum, 0);
  EXPECT_NEAR(friction_cost(scenario), sum / static_cast<double>(t.size()), 1e-15);
}

// Costs and slopes under caps, of which one is exceeded, one is not and one scenario diverges; and
// what bounds spare changes no cost that is within them.
TEST(TuneObjective, CapsTheCostOfEachScenario) {
  Scenario scenarios[3] = {short_scenario(), short_scenario(), short_scenario()};
  scenarios[1].robot.mass = 20;
  scenarios[2].initial_pose = {{2.0, 0.5, 1.0}};
  const std::vector<const Scenario*> all = {&scenarios[0], &scenarios[1], &scenarios[2]};
  const Structure structure;
  const std::vector<double> x =
      parameters_of(structure.parameters, ControllerDesign(structure.settings));
  const auto size = static_cast<Eigen::Index>(x.size());
  const Point point = Eigen::Map<const Point>(x.data(), size);
  std::vector<double> each;
  for (const Scenario& one : scenarios) {
    each.push_back(evaluate(prepare(one), ControllerDesign(structure.settings)));
  }
  const std::vector<double> caps = {each[0] / 3, each[1] * 2, each[2] / 5};
  const double expected =
      (caps[0] * (1 + std::log(3.0)) + each[1] + caps[2] * (1 + std::log(5.0))) / 3;
  TuneObjective objective(all, ParameterSpace::whole(structure), {1.0, caps}, 1);
  double cost = 0;
  objective.costs(point, &cost);
  EXPECT_NEAR(cost, expected, 1e-10);
  Eigen::VectorXd slopes(size);
  EXPECT_NEAR(objective.gradient(point, slopes.data()), expected, 1e-10);
  for (Eigen::Index i = 0; i < size; ++i) {
    Points two = point.replicate(1, 2);
    two(i, 0) += 1e-6;
    two(i, 1) -= 1e-6;
    double costs[2];
    objective.costs(two, costs);
    EXPECT_NEAR(slopes(i), (costs[0] - costs[1]) / 2e-6, 1e-5 * std::fabs(slopes(i)) + 1e-7) << i;
  }
  for (const double factor : {0.3, 0.9, 1.1, 3.0}) {
    const double bound = expected * factor;
    double bounded = 0;
    objective.bounded_costs(point, &bound, &bounded);
    if (factor > 1) {
      EXPECT_EQ(bounded, cost);
    } else {
      EXPECT_GT(bounded, bound);
    }
  }
}

// Candidates run scenario by scenario: what is within its bound costs what it costs, and all else
// more than its bound, whatever the share of the worst and the threads.
TEST(TuneObjective, GivesUpOnlyWhatIsOverItsBound) {
  std::vector<Scenario> scenarios(5, short_scenario());
  scenarios[1].robot.mass = 20;
  scenarios[2].delay = 1;
  scenarios[3].coulomb_friction = 0.05;
  scenarios[4].initial_pose = {{2.0, 0.5, 1.0}};
  std::vector<const Scenario*> all;
  for (const Scenario& one : scenarios) all.push_back(&one);
  const Structure structure;
  const std::vector<double> x =
      parameters_of(structure.parameters, ControllerDesign(structure.settings));
  constexpr int count = 40;
  Points points(static_cast<Eigen::Index>(x.size()), count);
  Draws draw(3);
  for (double& number : points.reshaped()) number = draw.between(0.5, 1.5);
  for (int j = 0; j < count; ++j) {
    points.col(j).array() *= Eigen::Map<const Eigen::ArrayXd>(x.data(), points.rows());
  }
  for (const double share : {1.0, 0.5, 0.0}) {
    for (const double cap : {0.0, 0.02}) {
      const FamilyCost family(share, cap > 0 ? std::vector<double>(5, cap) : std::vector<double>());
      TuneObjective objective(all, ParameterSpace::whole(structure), family, 1);
      double exact[count], bounds[count], costs[count], again[count];
      objective.costs(points, exact);
      constexpr double shares[] = {1.0, 0.999999, 1.5, 0.3};
      for (int j = 0; j < count; ++j) bounds[j] = shares[j % 4] * exact[j];
      objective.bounded_costs(points, bounds, costs);
      for (int j = 0; j < count; ++j) {
        if (j % 2 == 0) {
          EXPECT_EQ(costs[j], exact[j]) << share << " " << cap;
        } else {
          EXPECT_GT(costs[j], bounds[j]) << share << " " << cap;
        }
      }
      TuneObjective threaded(all, ParameterSpace::whole(structure), family, 3);
      threaded.bounded_costs(points, bounds, again);
      EXPECT_TRUE(std::equal(costs, costs + count, again));
    }
  }
}

// The same costs from all, whoever asks with bounds.
class Unbounded : public Objective {
 public:
  explicit Unbounded(Objective& objective) : objective_(objective) {}
  bool has_gradient() const override { return objective_.has_gradient(); }
  bool is_cheap() const override { return objective_.is_cheap(); }
  void costs(const Points& points, double* costs) override { objective_.costs(points, costs); }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    return objective_.partials(point, first, count, slopes);
  }

 private:
  Objective& objective_;
};

// Neither threads nor what is given up early leads a search elsewhere.
TEST(TuneObjective, LeadsASearchToOnePlace) {
  Scenario heavy = Scenario::published();
  heavy.robot.mass = 20;
  const Scenario published = Scenario::published();
  const std::vector<std::vector<const Scenario*>> lists = {{&published}, {&published, &heavy}};
  const Structure structure = named_structure(StructureName::extended);
  const std::vector<ParameterBounds> bounds = default_bounds(structure);
  const auto size = static_cast<Eigen::Index>(bounds.size());
  Point low(size), high(size);
  for (Eigen::Index i = 0; i < size; ++i) {
    low(i) = bounds[static_cast<std::size_t>(i)].low;
    high(i) = bounds[static_cast<std::size_t>(i)].high;
  }
  for (const auto& scenarios : lists) {
    const auto find = [&](int threads, bool bounded) {
      TuneObjective objective(scenarios, ParameterSpace::whole(structure), 0.7, threads);
      Unbounded unbounded(objective);
      Objective& used = bounded ? static_cast<Objective&>(objective) : unbounded;
      SearchSession search(used, {low, high, tuning_powers(low)}, {6000}, 5);
      BfoaPlus(search, {}, 6000).run();
      return search.result;
    };
    const SearchResult plain = find(1, false);
    for (const int threads : {1, 2, 3}) {
      const SearchResult found = find(threads, true);
      EXPECT_EQ(found.x, plain.x);
      EXPECT_EQ(found.cost, plain.cost);
      ASSERT_EQ(found.history.size(), plain.history.size());
      for (std::size_t row = 0; row < plain.history.size(); ++row) {
        EXPECT_EQ(found.history[row].evaluations, plain.history[row].evaluations);
        EXPECT_EQ(found.history[row].best, plain.history[row].best);
        EXPECT_EQ(found.history[row].mean, plain.history[row].mean);
      }
    }
  }
}

// On the published scenario the lateral error as it is serves free taps better than by speed.
TEST(RunTuning, ChoosesWhatTheLateralChannelIsFed) {
  const Scenario scenario = Scenario::published();
  Structure structure = named_structure(StructureName::taps);
  const auto tuned = [&] {
    TuningPlan plan = plan_tuning({&scenario}, structure);
    plan.search.seed = 2;
    return run_tuning(plan);
  };
  const TuningResult found = tuned();
  EXPECT_EQ(found.evaluations, 10000);
  EXPECT_EQ(found.structure.settings.lateral, Lateral::direction);
  const ControllerDesign design =
      design_of(found.structure, std::vector<double>(found.x.begin(), found.x.end()));
  EXPECT_NEAR(simulate(scenario, design).metrics.cost, found.cost, 1e-9 * found.cost);
  structure.either_lateral = false;
  const TuningResult by_speed = tuned();
  EXPECT_EQ(by_speed.structure.settings.lateral, Lateral::speed);
  EXPECT_EQ(by_speed.evaluations, 10000);
  EXPECT_GT(by_speed.cost, found.cost);
}

// Of a long memory each direction is a run of its own: as many at once as there are threads.
TEST(TuneObjective, GivesALongMemorysGradientInPieces) {
  TrajectorySettings path;
  path.period = 10;
  Scenario scenario = Scenario::published();
  scenario.trajectory = make(path);
  Structure structure = named_structure(StructureName::extended);
  structure.settings.memory = batch_capacity - 1;
  const std::vector<double> x = parameters_of(structure.parameters, ControllerSettings<double>{});
  const auto size = static_cast<Eigen::Index>(x.size());
  const Point point = Eigen::Map<const Point>(x.data(), size);
  TuneObjective objective({&scenario}, ParameterSpace::whole(structure), 1, 2);
  EXPECT_EQ(objective.partials_at_once(), 2);
  Point whole(size), pieces(size);
  const double cost = objective.gradient(point, whole.data());
  for (Eigen::Index first = 0; first < size; first += 2) {
    const Eigen::Index count = std::min<Eigen::Index>(2, size - first);
    EXPECT_EQ(objective.partials(point, first, count, pieces.data() + first), cost);
  }
  EXPECT_EQ(pieces, whole);
  structure.settings.memory = batch_capacity - 2;  // still one of lanes
  EXPECT_EQ(TuneObjective({&scenario}, ParameterSpace::whole(structure), 1, 2).partials_at_once(),
            size);
}

// Asked to stop in one of its stages, it does not go on to the next.
TEST(RunTuning, StopsWhenAsked) {
  const Scenario scenario = Scenario::published();
  TuningPlan plan = plan_tuning({&scenario}, named_structure(StructureName::taps));
  plan.search.limits.evaluations = 4000;
  int whole = 0;
  std::int64_t before = 0;
  double least = std::numeric_limits<double>::infinity();
  run_tuning(plan, [&](std::int64_t evaluations, double cost) {
    EXPECT_GE(evaluations, before);  // of all stages
    EXPECT_LE(cost, least);
    before = evaluations;
    least = cost;
    ++whole;
  });
  EXPECT_GT(before, 3900);
  for (const int last : {2, whole / 2, whole - 2}) {
    int calls = 0;
    const TuningResult found = run_tuning(
        plan, [&](auto...) { ++calls; }, [&] { return calls >= last; });
    EXPECT_GE(calls, last);
    EXPECT_LE(calls, last + 1);  // the step that the interruption ends is told too
    EXPECT_EQ(found.reason, StopReason::callback);
  }
}

}  // namespace
}  // namespace nfopidn::test
