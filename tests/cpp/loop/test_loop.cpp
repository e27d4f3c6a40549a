// The closed loop: divergence, delay, noise, disturbance, cost.
#include "nfopidn/loop/closed_loop.hpp"
#include "nfopidn/tuning/batch_job.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

// Plays torques from a list, and keeps what it was shown.
struct Player {
  std::vector<TorquePair<double>> torques;
  std::vector<Measurement<double>> measured = {};
  std::vector<ReferenceSample<double>> shown = {};

  TorquePair<double> step(const Measurement<double>& measurement,
                          const ReferenceSample<double>& reference) {
    measured.push_back(measurement);
    shown.push_back(reference);
    const std::size_t k = measured.size() - 1;
    return k < torques.size() ? torques[k] : TorquePair<double>{0, 0};
  }
};

struct Recorded {
  std::vector<State<double>> states;
  std::vector<TorquePair<double>> commanded;
  std::vector<TorquePair<double>> applied;
  LoopResult<double> result;
};

class Loop : public ::testing::Test {
 protected:
  Loop() : reference(12, {0.5, -0.2, 0.1, 0, 0, 0.3, -0.1, false}) {
    inputs.reference = reference.data();
    inputs.samples = static_cast<int>(reference.size());
    inputs.disturbance = &calm;
    Draws draw(91);
    for (int k = 0; k < 12; ++k) {
      player.torques.push_back({draw.between(-1, 1), draw.between(-1, 1)});
    }
  }
  template <class Law>
  Recorded run(Law& law) const {
    Recorded recorded;
    recorded.result = run_closed_loop<double>(
        plant, law, start, inputs,
        [&](int k, const State<double>& state, const TorquePair<double>& commanded,
            const TorquePair<double>& applied) {
          EXPECT_EQ(static_cast<std::size_t>(k), recorded.states.size());
          recorded.states.push_back(state);
          recorded.commanded.push_back(commanded);
          recorded.applied.push_back(applied);
        });
    return recorded;
  }

  DifferentialDrive<double> plant{
      Robot<double>::eddie(), {}, Integrator::semi_implicit_euler, 0.2, 1};
  std::vector<ReferenceSample<double>> reference;
  Disturbance<double> calm = {0, 0};
  LoopInputs<double> inputs;
  State<double> start = {0.1, 0.2, 0.3, 0.1, -0.2};
  Player player = {};
};

TEST_F(Loop, AppliesEachTorqueForOneSample) {
  const Recorded recorded = run(player);
  ASSERT_EQ(recorded.states.size(), 12U);
  State<double> state = start;
  for (std::size_t k = 0; k < 12; ++k) {
    ASSERT_TRUE(same_bits(recorded.states[k], state)) << k;
    ASSERT_TRUE(same_bits(recorded.commanded[k], player.torques[k])) << k;
    ASSERT_TRUE(same_bits(recorded.applied[k], player.torques[k])) << k;
    const Measurement<double> seen = {state.x, state.y, state.theta, state.v, state.omega};
    ASSERT_TRUE(same_bits(player.measured[k], seen)) << k;
    plant.advance(state, math<double>::heading(state.theta), player.torques[k], &calm);
  }
  EXPECT_EQ(recorded.result.completed, 12);
}

TEST_F(Loop, DelayShiftsTheAppliedTorques) {
  for (const int delay : {1, 3, 11, maximum_delay}) {
    inputs.delay = delay;
    Player late = player;
    const Recorded recorded = run(late);
    for (int k = 0; k < 12; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const TorquePair<double> expected = k < delay
                                              ? TorquePair<double>{0, 0}
                                              : player.torques[static_cast<std::size_t>(k - delay)];
      ASSERT_TRUE(same_bits(recorded.applied[at], expected)) << delay << ", " << k;
      ASSERT_TRUE(same_bits(recorded.commanded[at], player.torques[at])) << delay << ", " << k;
      if (k > 0) {
        State<double> state = recorded.states[at - 1];
        plant.advance(state, math<double>::heading(state.theta), recorded.applied[at - 1], &calm);
        ASSERT_TRUE(same_bits(recorded.states[at], state)) << delay << ", " << k;
      }
    }
  }
}

TEST_F(Loop, NoiseIsSeenByTheControllerAlone) {
  std::vector<Measurement<double>> noise;
  for (int k = 0; k < 12; ++k) noise.push_back({0.01 * k, -0.02 * k, 0.03 * k, 0, 0});
  Player deaf = player;
  const Recorded clean = run(deaf);
  inputs.noise = noise.data();
  const Recorded noisy = run(player);
  EXPECT_EQ(noisy.result.cost, clean.result.cost);
  for (std::size_t k = 0; k < 12; ++k) {
    ASSERT_TRUE(same_bits(noisy.states[k], clean.states[k]));
    ASSERT_EQ(player.measured[k].x, clean.states[k].x + noise[k].x);
    ASSERT_EQ(player.measured[k].y, clean.states[k].y + noise[k].y);
    ASSERT_EQ(player.measured[k].theta, clean.states[k].theta + noise[k].theta);
  }
}

TEST_F(Loop, NoiseReachesALawThatTakesHeadings) {
  Controller<double, Fir<double, 7>> law;
  ASSERT_EQ(law.configure({}), Status::ok);
  std::vector<Measurement<double>> noise(12, {0.01, -0.02, 0.4, 0, 0});
  inputs.noise = noise.data();
  const Recorded recorded = run(law);
  law.reset();
  for (std::size_t k = 0; k < recorded.states.size(); ++k) {
    const State<double>& s = recorded.states[k];
    const auto torque =
        law.step({s.x + 0.01, s.y - 0.02, s.theta + 0.4, s.v, s.omega}, reference[k]);
    ASSERT_TRUE(same_bits(torque, recorded.commanded[k])) << k;
  }
}

TEST_F(Loop, FeedforwardMayBeHiddenButIsStillJudged) {
  Player told = player;
  const Recorded with = run(told);
  EXPECT_EQ(told.shown[3].tau_left, 0.3);
  inputs.feedforward = false;
  const Recorded without = run(player);
  EXPECT_EQ(player.shown[3].tau_left, 0);
  EXPECT_EQ(player.shown[3].tau_right, 0);
  EXPECT_EQ(player.shown[3].x, 0.5);
  EXPECT_EQ(without.result.cost, with.result.cost);
}

TEST_F(Loop, DisturbanceActsBySampleOrAllAlong) {
  std::vector<Disturbance<double>> by_sample(12, {0, 0});
  by_sample[4] = {5, -1};
  inputs.disturbance = by_sample.data();
  inputs.disturbance_by_sample = true;
  Player same = player;
  const Recorded pushed = run(same);
  inputs.disturbance = &calm;
  inputs.disturbance_by_sample = false;
  const Recorded undisturbed = run(player);
  for (std::size_t k = 0; k < 12; ++k) {
    EXPECT_EQ(same_bits(pushed.states[k], undisturbed.states[k]), k <= 4) << k;
  }
  EXPECT_NEAR(pushed.states[5].v - undisturbed.states[5].v, 0.2 * 5 / 11.5, 1e-14);
  EXPECT_NEAR(pushed.states[5].omega - undisturbed.states[5].omega, -0.2 / 0.5873, 1e-14);
}

// eq. 41
TEST_F(Loop, CostIsEquation41) {
  const Recorded recorded = run(player);
  Real sum = 0;
  for (std::size_t k = 0; k < 12; ++k) {
    const Real x = Real(0.5) - recorded.states[k].x;
    const Real y = Real(-0.2) - recorded.states[k].y;
    const Real theta = std::remainder(Real(0.1) - recorded.states[k].theta, 2 * pi);
    const Real left = Real(0.3) - player.torques[k].left;
    const Real right = Real(-0.1) - player.torques[k].right;
    sum += x * x + y * y + theta * theta + left * left + right * right;
  }
  EXPECT_TRUE(near(recorded.result.cost, sum / 12, 1e-14L));
}

// The recorded samples' terms, and the limit squared for each that is missing.
TEST_F(Loop, ADivergedRunCostsWhatTheDesignSays) {
  start = {0.5, -0.2, 3.0, 2, 0};
  inputs.divergence_distance = 1.1;
  const Recorded recorded = run(player);
  const std::size_t completed = recorded.states.size();
  ASSERT_GT(completed, 1U);
  ASSERT_LT(completed, 8U);
  EXPECT_EQ(recorded.result.completed, static_cast<double>(completed));
  Real sum = 0;
  for (std::size_t k = 0; k < completed; ++k) {
    const State<double>& s = recorded.states[k];
    EXPECT_LE(std::hypot(0.5 - s.x, -0.2 - s.y), 1.1);
    const Real theta = std::remainder(Real(0.1) - s.theta, 2 * pi);
    sum += (Real(0.5) - s.x) * (Real(0.5) - s.x) + (Real(-0.2) - s.y) * (Real(-0.2) - s.y) +
           theta * theta + std::pow(Real(0.3) - player.torques[k].left, 2) +
           std::pow(Real(-0.1) - player.torques[k].right, 2);
  }
  const Real missing = 12 - Real(completed);
  EXPECT_TRUE(near(recorded.result.cost, (sum + missing * Real(1.1) * 1.1) / 12, 1e-14L));
  State<double> next = recorded.states.back();
  plant.advance(next, math<double>::heading(next.theta), player.torques[completed - 1], &calm);
  EXPECT_GT(std::hypot(0.5 - next.x, -0.2 - next.y), 1.1);
}

// Light weights hide no divergence, and a missing sample costs as a position error does.
TEST_F(Loop, TheCostCountsErrorsByTheirWeights) {
  start = {0.5, -0.2, 3.0, 2, 0};
  for (const double distance : {100.0, 1.1}) {
    inputs.divergence_distance = distance;
    for (const CostWeights<double>& weights :
         {CostWeights<double>{2, 3, 5}, CostWeights<double>{1e-3, 0.5, 1e-2}}) {
      inputs.cost_weights = weights;
      Player fresh = player;
      const Recorded recorded = run(fresh);
      const std::size_t completed = recorded.states.size();
      ASSERT_EQ(completed < 12, distance < 2);
      Real sum = 0;
      for (std::size_t k = 0; k < completed; ++k) {
        const State<double>& s = recorded.states[k];
        const Real theta = std::remainder(Real(0.1) - s.theta, 2 * pi);
        sum += weights.position * (std::pow(Real(0.5) - s.x, 2) + std::pow(Real(-0.2) - s.y, 2)) +
               weights.heading * theta * theta +
               weights.torque * (std::pow(Real(0.3) - fresh.torques[k].left, 2) +
                                 std::pow(Real(-0.1) - fresh.torques[k].right, 2));
      }
      sum += Real(12 - static_cast<int>(completed)) * weights.position * distance * distance;
      EXPECT_TRUE(near(recorded.result.cost, sum / 12, 1e-14L));
    }
  }
}

TEST_F(Loop, AStateThatIsNotFiniteDiverges) {
  for (const double bad : {not_a_number<double>, infinite<double>}) {
    for (int member = 0; member < 4; ++member) {
      Player fresh = player;
      start = {0.5, -0.2, 0.1, 0, 0};
      (member == 0   ? start.x
       : member == 1 ? start.y
       : member == 2 ? start.theta
                     : start.omega) = bad;
      const Recorded recorded = run(fresh);
      EXPECT_EQ(recorded.result.completed, member == 3 ? 1 : 0);
      EXPECT_TRUE(std::isfinite(recorded.result.cost));
      EXPECT_EQ(recorded.result.cost == 100, member < 3);
    }
  }
}

TEST_F(Loop, TheLimitItselfIsNoDivergence) {
  reference.assign(12, {0, 0, 0, 0, 0, 0, 0, false});
  inputs.reference = reference.data();
  start = {0, 2, 0, 0, 0};
  inputs.divergence_distance = 2;
  Player still;
  EXPECT_EQ(run(still).result.completed, 12);
  start.y = 2.0000001;
  Player again;
  EXPECT_EQ(run(again).result.completed, 0);
}

TEST(DelayRange, EndsWhereTheContractSays) { EXPECT_EQ(maximum_delay, 64); }

// What costs more than its bound is given up when the meter is looked at, at every 32nd sample.
TEST(BoundedMeter, IsLookedAtEvery32ndSample) {
  const Scenario scenario = Scenario::published();
  const PreparedRun run = prepare(scenario);
  const LoopInputs<double> inputs = run.inputs();
  for (const double bound : {0.0, no_bound}) {
    Controller<double, Fir<double, 7>> law;
    ASSERT_EQ(law.configure(ControllerSettings<double>{}, run.limits), Status::ok);
    LoopState<double> loop{run.start, DelayLine<double>(0)};
    const BoundedMeter<double> meter(inputs, bound);
    const LoopResult<double> result =
        run_metered_loop<double>(run.plant, law, loop, inputs, meter, [](int, auto&&...) {});
    EXPECT_EQ(result.completed, bound == 0 ? 31 : inputs.samples);
  }
}

}  // namespace
}  // namespace nfopidn::test
