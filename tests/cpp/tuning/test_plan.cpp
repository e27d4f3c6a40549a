// The plan of a tuning: how its stages share evaluations and time, and what their results make.
#include <gtest/gtest.h>

#include "nfopidn/tuning/tune.hpp"

namespace nfopidn::test {
namespace {

// Stands in for the searches: notes what each stage is given, and answers what the test says.
class ScriptedRunner : public StageRunner {
 public:
  using Answer = std::function<void(const SearchStage&, SearchResult&)>;
  explicit ScriptedRunner(Answer answer = {}) : answer_(std::move(answer)) {}

  bool has_begun(const PlannedStage& stage) const override { return stage.name == begun; }
  bool has_failed() const override { return fails; }

  // By default a stage uses all of its evaluations in one second.
  SearchResult run(const SearchStage& stage, Objective& /*objective*/) override {
    names.push_back(stage.planned.name);
    given.push_back(stage.search);
    starts.push_back(stage.start);
    spent.push_back(stage.spent);
    SearchResult result;
    result.x = (stage.planned.space.low + stage.planned.space.high) / 2;
    result.cost = 1;
    result.evaluations = stage.search.limits.evaluations;
    result.reason = StopReason::evaluations;
    result.seconds = 1;
    if (answer_) answer_(stage, result);
    return result;
  }

  std::string begun = "none";
  bool fails = false;
  std::vector<std::string> names;
  std::vector<SearchSettings> given;
  std::vector<Point> starts;
  std::vector<std::int64_t> spent;

 private:
  Answer answer_;
};

class Plan : public testing::Test {
 protected:
  Plan() {
    TrajectorySettings path;
    path.period = 10;
    EXPECT_EQ(make_trajectory(path, scenario.trajectory), Status::ok);
    plan = plan_tuning({&scenario}, named_structure(StructureName::taps));
    plan.search.limits = {1000, 10};
  }
  Scenario scenario = Scenario::published();
  TuningPlan plan;
};

TEST_F(Plan, SharesEvaluationsAndTimeOut) {
  plan.search.method = CmaEsOptions{};
  ScriptedRunner runner;
  const TuningResult found = run_tuning(plan, runner);
  EXPECT_EQ(runner.names, (std::vector<std::string>{"gains", "speed", ""}));
  ASSERT_EQ(runner.given.size(), 3U);
  EXPECT_EQ(runner.given[0].limits.evaluations, 300);
  EXPECT_EQ(runner.given[1].limits.evaluations, 350);
  EXPECT_EQ(runner.given[2].limits.evaluations, 350);
  EXPECT_DOUBLE_EQ(runner.given[0].limits.seconds, 3);
  EXPECT_DOUBLE_EQ(runner.given[1].limits.seconds, 4.5);
  EXPECT_DOUBLE_EQ(runner.given[2].limits.seconds, 8);
  EXPECT_EQ(runner.given[0].method.index(), MethodOptions().index());
  EXPECT_EQ(runner.given[1].method.index(), plan.search.method.index());
  EXPECT_EQ(runner.spent, (std::vector<std::int64_t>{0, 300, 650}));
  EXPECT_EQ(found.evaluations, 1000);
  EXPECT_DOUBLE_EQ(found.seconds, 3);
  EXPECT_EQ(found.alternative, 1U);  // of equal costs the later one
  EXPECT_EQ(found.structure.settings.lateral, Lateral::direction);
}

// An odd number of evaluations is used to the last one.
TEST_F(Plan, LosesNoEvaluation) {
  plan.search.limits.evaluations = 1001;
  ScriptedRunner runner;
  EXPECT_EQ(run_tuning(plan, runner).evaluations, 1001);
  EXPECT_EQ(runner.given[1].limits.evaluations, 351);
}

TEST_F(Plan, GivesOnWhatAStageHasLeftUnlessItsTimeWasUp) {
  for (const StopReason reason : {StopReason::schedule, StopReason::time}) {
    ScriptedRunner runner([&](const SearchStage& stage, SearchResult& result) {
      if (stage.planned.name != "gains") return;
      result.evaluations = 100;
      result.reason = reason;
    });
    run_tuning(plan, runner);
    ASSERT_EQ(runner.given.size(), 3U);
    EXPECT_EQ(runner.given[1].limits.evaluations, reason == StopReason::time ? 350 : 450);
  }
}

TEST_F(Plan, HasNoLimitForLaterStagesWithoutOneForAll) {
  plan.search.limits = {unlimited_budget};
  ScriptedRunner runner([](const SearchStage&, SearchResult& result) {
    result.evaluations = 7;
    result.reason = StopReason::schedule;
  });
  run_tuning(plan, runner);
  ASSERT_EQ(runner.given.size(), 3U);
  EXPECT_EQ(runner.given[0].limits.evaluations, 3000);
  EXPECT_EQ(runner.given[1].limits.evaluations, unlimited_budget);
  EXPECT_EQ(runner.given[2].limits.evaluations, unlimited_budget);
}

TEST_F(Plan, EndsWithAStageThatIsToldTo) {
  for (const StopReason reason :
       {StopReason::callback, StopReason::target, StopReason::not_a_number}) {
    ScriptedRunner runner([&](const SearchStage& stage, SearchResult& result) {
      if (stage.planned.name == "speed") result.reason = reason;
    });
    EXPECT_EQ(run_tuning(plan, runner).reason, reason);
    EXPECT_EQ(runner.names.back(), "speed");
  }
  ScriptedRunner failing;
  failing.fails = true;
  run_tuning(plan, failing);
  EXPECT_EQ(failing.names, std::vector<std::string>{"gains"});
}

TEST_F(Plan, EndsWhenTheTimeOfAllIsUp) {
  ScriptedRunner runner([](const SearchStage&, SearchResult& result) { result.seconds = 5; });
  run_tuning(plan, runner);
  EXPECT_EQ(runner.names, (std::vector<std::string>{"gains", "speed"}));
}

// A stage that knew no cost leaves the result of those before.
TEST_F(Plan, KeepsWhatEarlierStagesHaveFound) {
  ScriptedRunner runner([](const SearchStage& stage, SearchResult& result) {
    if (stage.planned.name == "gains") return;
    result = SearchResult();
    result.reason = StopReason::time;
  });
  const TuningResult found = run_tuning(plan, runner);
  EXPECT_EQ(runner.names.size(), 3U);
  EXPECT_EQ(found.evaluations, 300);
  EXPECT_EQ(found.reason, StopReason::time);
  EXPECT_EQ(found.x.size(), plan.alternatives[0].space.dimension());
  EXPECT_TRUE(std::isfinite(found.cost));
}

TEST_F(Plan, EndsWithoutAStart) {
  ScriptedRunner runner([](const SearchStage&, SearchResult& result) {
    result = SearchResult();
    result.reason = StopReason::time;
  });
  EXPECT_EQ(run_tuning(plan, runner).x.size(), 0);
  EXPECT_EQ(runner.names, std::vector<std::string>{"gains"});
}

// What an earlier process had found when its time was up is what later stages started from.
TEST_F(Plan, DoesNotProlongAStageThatOthersHaveFollowed) {
  ScriptedRunner runner;
  runner.begun = "speed";
  run_tuning(plan, runner);
  EXPECT_EQ(runner.given[0].limits.seconds, 0);
  EXPECT_GT(runner.given[1].limits.seconds, 0);
}

// The alternatives start from the taps of the gains, moved into their bounds, with frozen ones left
// out; their cost is that of the taps.
TEST_F(Plan, StartsFreeTapsFromGains) {
  for (PlannedStage& stage : plan.alternatives) {
    ParameterSpace& space = stage.space;
    space.parameters.source[0] = -1;
    for (int& source : space.parameters.source) source = source > 0 ? source - 1 : -1;
    space.low = Point::Constant(space.dimension() - 1, -0.5);
    space.high = -space.low;
  }
  plan.search.limits.target = 1e-3;
  Point gains;
  ScriptedRunner runner([&](const SearchStage& stage, SearchResult& result) {
    if (stage.planned.name != "gains") return;
    gains = result.x;
    result.cost = 1e-4;  // the target is met with gains, but not with the taps
    result.reason = StopReason::target;
    result.history = {{0, 0, 0, 300, 1e-4, 2, 0.1}};
  });
  const TuningResult found = run_tuning(plan, runner);
  ASSERT_EQ(runner.starts.size(), 3U);
  const ControllerDesign design = plan.gains->space.design(gains);
  std::vector<double> taps = parameters_of(ParameterSet::taps, design);
  ASSERT_EQ(runner.starts[1].size() + 1, static_cast<Eigen::Index>(taps.size()));
  taps[0] = 0;
  for (std::size_t i = 1; i < taps.size(); ++i) {
    taps[i] = std::clamp(taps[i], -0.5, 0.5);
    EXPECT_EQ(runner.starts[1](static_cast<Eigen::Index>(i) - 1), taps[i]);
  }
  EXPECT_EQ(runner.starts[2], runner.starts[1]);
  ControllerDesign of_taps(plan.alternatives[0].space.structure.settings);
  of_taps.taps = taps;
  const double cost = simulate(scenario, of_taps).metrics.cost;
  ASSERT_EQ(found.history.size(), 1U);
  EXPECT_NEAR(found.history[0].best, cost, 1e-9 * cost);
}

TEST_F(Plan, JoinsTheHistories) {
  ScriptedRunner runner([](const SearchStage& stage, SearchResult& result) {
    const bool first = stage.planned.name == "speed";
    if (stage.planned.name == "gains") return;
    result.cost = first ? 0.25 : 0.75;
    result.history = {{0, 0, 0, 10, first ? 0.5 : 0.9, 2, 0.1}, {0, 0, 1, 20, result.cost, 2, 0.1}};
  });
  plan.start = Point::Zero(plan.alternatives[0].space.dimension());
  plan.gains.reset();
  const TuningResult found = run_tuning(plan, runner);
  ASSERT_EQ(found.history.size(), 4U);
  const std::int64_t evaluations[] = {10, 20, 510, 520};
  const double best[] = {0.5, 0.25, 0.25, 0.25};
  for (std::size_t row = 0; row < 4; ++row) {
    EXPECT_EQ(found.history[row].evaluations, evaluations[row]);
    EXPECT_EQ(found.history[row].best, best[row]);
  }
  EXPECT_EQ(found.cost, 0.25);
  EXPECT_EQ(found.alternative, 0U);
  EXPECT_EQ(found.structure.settings.lateral, Lateral::speed);
}

TEST_F(Plan, HasOneStageForOtherStructures) {
  const TuningPlan one = plan_tuning({&scenario}, named_structure(StructureName::extended));
  EXPECT_FALSE(one.gains.has_value());
  ASSERT_EQ(one.alternatives.size(), 1U);
  EXPECT_EQ(one.alternatives[0].name, "");
  ScriptedRunner runner;
  EXPECT_EQ(run_tuning(one, runner).evaluations, default_budget({}));
}

}  // namespace
}  // namespace nfopidn::test
