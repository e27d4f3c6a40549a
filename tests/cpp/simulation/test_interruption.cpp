// Long work ends early when it is asked to, and not otherwise; what it gives is the same to the
// bit.
#include <limits>

#include "nfopidn/analysis/basin.hpp"
#include "nfopidn/analysis/floquet.hpp"
#include "nfopidn/rivals/tuning.hpp"
#include "nfopidn/simulation/playback.hpp"
#include "nfopidn/tuning/tune.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

bool never() { return false; }
bool at_once() { return true; }

// A path whose run takes from minutes to days: a test that is not interrupted never ends.
Scenario endless(int substeps = 10000, Integrator integrator = Integrator::semi_implicit_euler) {
  Scenario scenario = Scenario::published();
  TrajectorySettings settings = scenario.trajectory.settings;
  settings.period = 40000;
  EXPECT_EQ(make_trajectory(settings, scenario.trajectory), Status::ok);
  scenario.initial_pose.reset();
  scenario.substeps = substeps;
  scenario.integrator = integrator;
  return scenario;
}

struct Costs {
  double simulated, evaluated, rival, gradient;
  std::vector<double> candidates, slopes;

  bool operator==(const Costs& other) const {
    return simulated == other.simulated && evaluated == other.evaluated && rival == other.rival &&
           gradient == other.gradient && candidates == other.candidates && slopes == other.slopes;
  }
};

Costs costs_of(const Scenario& scenario, int threads) {
  const Structure structure = named_structure(StructureName::paper);
  const std::vector<double> x = parameters_of(structure.parameters, ControllerSettings<double>{});
  TuneObjective objective({&scenario}, ParameterSpace::whole(structure), 1, threads);
  Points points(11, 40);
  for (Eigen::Index j = 0; j < points.cols(); ++j) {
    points.col(j) = Eigen::Map<const Point>(x.data(), 11) * (1 + 0.02 * static_cast<double>(j));
  }
  Costs costs = {};
  costs.candidates.resize(40);
  costs.slopes.resize(11);
  objective.costs(points, costs.candidates.data());
  costs.gradient = objective.gradient(points.col(0), costs.slopes.data());
  costs.simulated = simulate(scenario, ControllerDesign{}).metrics.cost;
  costs.evaluated = evaluate(prepare(scenario), ControllerDesign{});
  rivals::RivalDesign rival;
  rival.parameters = rivals::default_parameters(rival.law);
  costs.rival = evaluate(prepare(scenario), rival);
  return costs;
}

// In pieces of one sample, of some, and in one piece: of tracking candidates and of diverging ones.
TEST(Interruption, ThatDoesNotHappenChangesNoBit) {
  for (const int substeps : {1, 3, 400, 2049}) {
    for (const double noise : {0.0, 0.002}) {
      Scenario scenario = Scenario::published();
      scenario.substeps = substeps;
      scenario.pose_noise = {noise, noise};
      scenario.delay = substeps == 3 ? 2 : 0;
      if (substeps > 100) {
        TrajectorySettings settings = scenario.trajectory.settings;
        settings.dt = 5;
        ASSERT_EQ(make_trajectory(settings, scenario.trajectory), Status::ok);
      }
      const Costs whole = costs_of(scenario, 1);
      for (const int threads : {1, 2}) {
        const Interruption interruption(never);
        EXPECT_TRUE(costs_of(scenario, threads) == whole) << substeps << ' ' << noise;
        EXPECT_FALSE(interruption.happened());
      }
    }
  }
}

// The pieces are counted in integration steps.
TEST(Interruption, IsAskedMoreOftenWhereASampleIsMoreWork) {
  EXPECT_EQ(Interruption::poll(1).question, nullptr);
  const Interruption interruption(never);
  EXPECT_EQ(Interruption::poll(1).samples, 2048);
  EXPECT_EQ(Interruption::poll(1000).samples, 2);
  EXPECT_EQ(Interruption::poll(10000).samples, 1);
}

TEST(Interruption, EndsASimulation) {
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::exact}) {
    const Scenario scenario = endless(10000, integrator);
    rivals::RivalDesign rival;
    rival.parameters = rivals::default_parameters(rival.law);
    ControllerDesign remembering;
    remembering.memory = 1000;
    const auto runs = std::vector<std::function<SimulationResult()>>{
        [&] { return simulate(scenario, ControllerDesign{}); },
        [&] { return simulate(scenario, remembering); }, [&] { return simulate(scenario, rival); },
        [&] {
          const auto samples = static_cast<std::size_t>(scenario.trajectory.size());
          return play(scenario, std::vector<TorquePair<double>>(samples, {0, 0}));
        }};
    for (const auto& run : runs) {
      const Interruption interruption(at_once);
      EXPECT_EQ(run().status, Status::interrupted);
      EXPECT_TRUE(interruption.happened());
    }
  }
}

TEST(Interruption, EndsCostsAndGradients) {
  const Structure structure = named_structure(StructureName::paper);
  const std::vector<double> x = parameters_of(structure.parameters, ControllerSettings<double>{});
  const Points points = Eigen::Map<const Point>(x.data(), 11).replicate(1, 100);
  const std::vector<double> gains = rivals::default_parameters(rivals::RivalDesign{}.law);
  std::vector<double> answers(100);
  for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::exact}) {
    const Scenario scenario = endless(10000, integrator);
    for (const int threads : {1, 2, 3}) {
      TuneObjective objective({&scenario, &scenario}, ParameterSpace::whole(structure), 1, threads);
      rivals::RivalObjective rival({&scenario}, {}, FreeParameters::all(gains.size()),
                                   static_cast<int>(gains.size()), 1, threads);
      {
        const Interruption interruption(at_once);
        objective.costs(points, answers.data());
        EXPECT_TRUE(interruption.happened());
      }
      {
        const Interruption interruption(at_once);
        objective.gradient(points.col(0), answers.data());
        EXPECT_TRUE(interruption.happened());
      }
      {
        const Interruption interruption(at_once);
        rival.costs(Eigen::Map<const Point>(gains.data(), gains.size()).replicate(1, 9),
                    answers.data());
        EXPECT_TRUE(interruption.happened());
      }
    }
  }
}

TEST(Interruption, EndsAnAnalysis) {
  const Scenario scenario = endless(10000);
  const double poses[] = {4, 0, 1, 4, 0.1, 1};
  FinalErrors errors[2];
  {
    const Interruption interruption(at_once);
    basin(prepare(scenario), ControllerDesign{}, poses, 2, 10, 2, errors);
    EXPECT_TRUE(interruption.happened());
  }
  Scenario circle = scenario;
  TrajectorySettings settings = scenario.trajectory.settings;
  settings.name = Curve::ranunculoid;
  settings.period = 2000;
  ASSERT_EQ(make_trajectory(settings, circle.trajectory), Status::ok);
  LoopStability found;
  const Interruption interruption(at_once);
  analyse_loop(circle, ControllerDesign{}, found);
  EXPECT_TRUE(interruption.happened());
}

// Drawing a long run's noise takes long already.
TEST(Interruption, EndsThePreparation) {
  Scenario scenario = endless(1);
  scenario.pose_noise = {0.1, 0.1};
  const Interruption interruption(at_once);
  while (!Interruption::stops_here()) continue;
  const PreparedRun run = prepare(scenario);
  EXPECT_EQ(run.noise.front().x, 0);
  EXPECT_EQ(run.noise.size(), run.reference.size());
}

// Both are asked, and the inner one's end is not the outer one's.
TEST(Interruption, AsksTheOuterOneToo) {
  bool stops = false;
  Interruption outer([&] { return stops; });
  {
    Interruption inner(at_once);
    while (!Interruption::stops_here()) continue;
    EXPECT_TRUE(inner.happened());
  }
  EXPECT_FALSE(outer.happened());
  stops = true;
  Interruption inner(never);
  while (!Interruption::stops_here()) continue;
  EXPECT_TRUE(inner.happened());
  EXPECT_TRUE(outer.happened());
}

// One that never ends unless it is interrupted, from the n-th question on.
class Stuck : public Objective {
 public:
  explicit Stuck(int questions, bool gradient) : left_(questions), gradient_(gradient) {}
  void costs(const Points& points, double* costs) override {
    wait();
    for (Eigen::Index j = 0; j < points.cols(); ++j) costs[j] = points.col(j).squaredNorm();
  }
  bool has_gradient() const override { return gradient_; }
  Eigen::Index most_at_once() const override { return 10; }
  Eigen::Index partials_at_once() const override { return 2; }
  double partials(const Point& point, Eigen::Index first, Eigen::Index count,
                  double* slopes) override {
    wait();
    for (Eigen::Index i = 0; i < count; ++i) slopes[i] = 2 * point(first + i);
    return point.squaredNorm();
  }

 private:
  void wait() {
    if (left_-- > 0) return;
    while (!Interruption::stops_here()) continue;
  }
  int left_;
  bool gradient_;
};

// Wherever a question is interrupted, by a time limit or by a wish, what it would have answered is
// neither counted nor recorded.
TEST(Interruption, EndsASearchWithinAQuestion) {
  for (const bool gradient : {false, true}) {
    for (const int questions : {0, 1, 7, 40}) {
      for (const bool timed : {false, true}) {
        Stuck objective(questions, gradient);
        SearchLimits limits = {2000};
        if (timed) limits.seconds = 0.02;
        const Box box = {Point::Constant(3, -1), Point::Constant(3, 2), Point::Ones(3)};
        SearchSession search(objective, box, limits, 1);
        if (!timed) search.set_interruption(at_once);
        BfoaPlus(search, {}, 2000).run();
        EXPECT_EQ(search.result.reason, timed ? StopReason::time : StopReason::callback);
        EXPECT_EQ(search.result.evaluations, static_cast<std::int64_t>(search.record().size()));
        EXPECT_EQ(search.result.x.size(), search.result.evaluations == 0 ? 0 : 3);
        EXPECT_EQ(search.result.history.empty(), search.result.evaluations == 0);
        EXPECT_TRUE(questions > 0 || search.result.evaluations == 0);
      }
    }
  }
}

TEST(Interruption, EndsATuningBeforeItsFirstCost) {
  const Scenario scenario = endless();
  for (const StructureName name : {StructureName::paper, StructureName::taps}) {
    const TuningPlan plan = plan_tuning({&scenario}, named_structure(name));
    const TuningResult found = run_tuning(plan, {}, at_once);
    EXPECT_EQ(found.reason, StopReason::callback);
    EXPECT_EQ(found.evaluations, 0);
    EXPECT_EQ(found.x.size(), 0);
  }
}

}  // namespace
}  // namespace nfopidn::test
