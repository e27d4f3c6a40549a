// Bad, missing and late measurements, and fresh starts.
#include "guarded_rig.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class GuardedLaw : public ::testing::Test {};
TYPED_TEST_SUITE(GuardedLaw, Scalars);

template <class Scalar>
std::vector<Measurement<Scalar>> bad_measurements() {
  const Scalar nan = not_a_number<Scalar>;
  const Scalar inf = infinite<Scalar>;
  const Scalar far = std::numeric_limits<Scalar>::max();
  return {{nan, 0, 0, 0, 0},  {0, nan, 0, 0, 0},  {0, 0, nan, 0, 0},        {inf, 0, 0, 0, 0},
          {0, -inf, 0, 0, 0}, {0, 0, inf, 0, 0},  {far, 0, 0, 0, 0},        {0, -far, 0, 0, 0},
          {0, 0, far, 0, 0},  {-far, 0, 0, 0, 0}, {0, Scalar(2e6), 0, 0, 0}};
}

TYPED_TEST(GuardedLaw, AddsNothingToGoodMeasurements) {
  Rig<TypeParam> rig;
  Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 2);
  for (int k = 0; k < 20; ++k) {
    const auto m = rig.measured();
    const auto r = rig.reference();
    ASSERT_TRUE(same_bits(guarded.step(m, r), rig.plain.step(m, r)));
    ASSERT_EQ(guarded.fault(), Fault::none);
  }
}

TYPED_TEST(GuardedLaw, HoldsTheTorqueThenStops) {
  for (const auto& bad : bad_measurements<TypeParam>()) {
    Rig<TypeParam> rig;
    Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 3);
    auto m = rig.measured();
    auto r = rig.reference();
    const auto last = guarded.step(m, r);
    rig.plain.step(m, r);
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(same_bits(guarded.step(bad, rig.reference()), last));
      EXPECT_EQ(guarded.fault(), Fault::held);
    }
    // A good one in time: the law goes on where it was, and has three samples again.
    m = rig.measured();
    r = rig.reference();
    const auto next = guarded.step(m, r);
    EXPECT_TRUE(same_bits(next, rig.plain.step(m, r)));
    EXPECT_EQ(guarded.fault(), Fault::none);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(same_bits(guarded.step(bad, r), next));
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(same_bits(guarded.step(bad, r), no_torque<TypeParam>()));
      EXPECT_EQ(guarded.fault(), Fault::stopped);
    }
    // Afresh, without a kick.
    rig.plain.reset_to(m, r);
    EXPECT_TRUE(same_bits(guarded.step(m, r), rig.plain.step(m, r)));
    EXPECT_EQ(guarded.fault(), Fault::none);
  }
}

TYPED_TEST(GuardedLaw, HasNoTorqueBeforeTheFirstMeasurement) {
  Rig<TypeParam> rig;
  Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 3);
  const auto r = rig.reference();
  for (int round = 0; round < 2; ++round) {
    EXPECT_TRUE(same_bits(guarded.missed(r), no_torque<TypeParam>()));
    EXPECT_EQ(guarded.fault(), Fault::stopped);
    EXPECT_TRUE(
        same_bits(guarded.step({infinite<TypeParam>, 0, 0, 0, 0}, r), no_torque<TypeParam>()));
    guarded.step(rig.measured(), r);
    EXPECT_EQ(guarded.fault(), Fault::none);
    guarded.reset();
    EXPECT_EQ(guarded.fault(), Fault::none);
  }
}

TYPED_TEST(GuardedLaw, AMissedSampleRepeatsTheErrorUnderThePresentFeedforward) {
  for (const Form form : both_forms) {
    // A world in which the same measurement is the same error.
    Rig<TypeParam> rig(form);
    Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 2);
    const auto m = rig.measured();
    auto r = rig.reference();
    guarded.step(m, r);
    rig.plain.step(m, r);
    for (int k = 0; k < 2; ++k) {
      r.tau_left += TypeParam(0.25);
      EXPECT_TRUE(same_bits(guarded.missed(r), rig.plain.step(m, r)));
      EXPECT_EQ(guarded.fault(), Fault::held);
    }
    EXPECT_TRUE(same_bits(guarded.missed(r), no_torque<TypeParam>()));
    EXPECT_EQ(guarded.fault(), Fault::stopped);
  }
}

TYPED_TEST(GuardedLaw, BadMeasurementsMayCountAsMissed) {
  Rig<TypeParam> rig;
  Rig<TypeParam> twin;
  Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 2, Bridge::repeat);
  Guarded<decltype(rig.law), TypeParam> other(twin.law, 2);
  const auto m = rig.measured();
  auto r = rig.reference();
  guarded.step(m, r);
  other.step(m, r);
  for (int k = 0; k < 3; ++k) {
    r = rig.reference();
    const auto torque = guarded.step({0, infinite<TypeParam>, 0, 0, 0}, r);
    EXPECT_TRUE(same_bits(torque, other.missed(r)));
    EXPECT_EQ(guarded.fault(), other.fault());
  }
}

TYPED_TEST(GuardedLaw, TheFilterOfManySlackSamplesRepeatsToo) {
  Controller<TypeParam, Fir<TypeParam, 7, 3>> slack;
  Rig<TypeParam> rig;
  ASSERT_EQ(slack.configure({}), Status::ok);
  for (int k = 0; k < 20; ++k) {
    const auto m = rig.measured();
    const auto r = rig.reference();
    if (k == 8) {
      slack.reset_to(m, r);
      rig.law.reset_to(m, r);
    }
    const auto torque = k % 3 == 2 ? slack.repeat(r) : slack.step(m, r);
    const auto expected = k % 3 == 2 ? rig.law.repeat(r) : rig.law.step(m, r);
    ASSERT_TRUE(near(torque.left, expected.left, 4 * unit<TypeParam>)) << k;
    ASSERT_TRUE(near(torque.right, expected.right, 4 * unit<TypeParam>)) << k;
  }
}

// The literal equations with an error that has been there for ever: longer than the memory.
TYPED_TEST(GuardedLaw, AStartFromThePresentErrorDoesNotKick) {
  for (const Form form : both_forms) {
    Rig<TypeParam> rig(form);
    ControllerSettings<TypeParam> settings;
    settings.form = form;
    LiteralLaw<TypeParam> literal{settings, {}};
    const auto m = rig.measured();
    auto r = rig.reference();
    r.tau_left = r.tau_right = 0;
    for (int k = 0; k < 10; ++k) literal.step(m, r);
    literal.feedback = {0, 0};
    const auto expected = literal.step(m, r);
    Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 2);
    guarded.step(rig.measured(), rig.reference());
    guarded.reset_to(m, r);
    EXPECT_TRUE(same_bits(rig.law.feedback(), no_torque<TypeParam>()));
    EXPECT_EQ(guarded.fault(), Fault::none);
    const auto torque = guarded.step(m, r);
    EXPECT_TRUE(near(torque.left, expected[0], 16 * unit<TypeParam>));
    EXPECT_TRUE(near(torque.right, expected[1], 16 * unit<TypeParam>));
  }
}

// With proportional and derivative gains alone, all of the first torque is kick.
TYPED_TEST(GuardedLaw, NothingIsLeftOfTheKick) {
  for (const Form form : both_forms) {
    ControllerSettings<TypeParam> settings;
    settings.form = form;
    for (auto& gains : settings.gains) gains[1] = 0;
    Rig<TypeParam> rig;
    ASSERT_EQ(rig.law.configure(settings), Status::ok);
    const Measurement<TypeParam> m = {};
    const ReferenceSample<TypeParam> r = {
        TypeParam(0.25), TypeParam(0.25), TypeParam(0.25), 0, 0, 0, 0, false};
    EXPECT_GT(rig.law.step(m, r).left, TypeParam(0.2));
    rig.law.reset_to(m, r);
    for (int k = 0; k < 3; ++k) {
      const auto torque = rig.law.step(m, r);
      EXPECT_TRUE(near(torque.left, 0, 4 * unit<TypeParam>));
      EXPECT_TRUE(near(torque.right, 0, 4 * unit<TypeParam>));
    }
  }
}

TYPED_TEST(GuardedLaw, AStartFromABadMeasurementIsAReset) {
  Rig<TypeParam> rig;
  Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 2);
  const auto m = rig.measured();
  const auto r = rig.reference();
  guarded.step(m, r);
  guarded.reset_to({not_a_number<TypeParam>, 0, 0, 0, 0}, r);
  EXPECT_TRUE(same_bits(guarded.step(m, r), rig.plain.step(m, r)));
}

// Finite, and yet their errors would be beyond every float, in the law's memory as well.
TYPED_TEST(GuardedLaw, NumbersBeyondAllMeasureAreBadInTheReferenceToo) {
  using M = Measurement<TypeParam>;
  using R = ReferenceSample<TypeParam>;
  for (const TypeParam bad :
       {not_a_number<TypeParam>, std::numeric_limits<TypeParam>::max(), TypeParam(-1.001e6)}) {
    for (const auto number : {&R::x, &R::y, &R::theta, &R::v, &R::tau_left, &R::tau_right}) {
      Rig<TypeParam> rig;
      Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 2);
      const M m = rig.measured();
      const R good = rig.reference();
      const auto torque = guarded.step(m, good);
      rig.plain.step(m, good);
      R reference = good;
      reference.*number = bad;
      EXPECT_TRUE(same_bits(guarded.step(m, reference), torque));
      EXPECT_EQ(guarded.fault(), Fault::held);
      EXPECT_TRUE(same_bits(guarded.missed(reference), torque));
      EXPECT_TRUE(same_bits(guarded.step(m, good), rig.plain.step(m, good)));
      EXPECT_EQ(guarded.fault(), Fault::none);
    }
  }
  Rig<TypeParam> rig;
  Guarded<decltype(rig.law), TypeParam> guarded(rig.law, 1);
  guarded.step({TypeParam(1e6), TypeParam(-1e6), TypeParam(1e6), 0, 0}, rig.reference());
  EXPECT_EQ(guarded.fault(), Fault::none);
}

// A fifth of the samples lost, or bad, in the closed loop.
template <class Law>
struct Lossy {
  Law& law;
  Guarded<Law, double> guarded;
  Draws draw;
  bool begun = false;

  TorquePair<double> step(const Measurement<double>& measured,
                          const ReferenceSample<double>& reference) {
    const bool lost = draw.between(0, 1) < 0.2 && begun;
    begun = true;
    return guarded.step(lost ? Measurement<double>{infinite<double>, 0, 0, 0, 0} : measured,
                        reference);
  }
};

double lossy_cost(Bridge bridge, std::uint64_t seed) {
  const Scenario scenario = short_scenario();
  const PreparedRun run = prepare(scenario);
  using Law = Controller<double, Fir<double, 7>>;
  Law law;
  EXPECT_EQ(law.configure(steady_settings(Form::incremental), run.limits), Status::ok);
  Lossy<Law> lossy{law, Guarded<Law, double>(law, 1000, bridge), Draws(seed)};
  const auto ignore = [](int, auto&&...) {};
  return run_closed_loop<double>(run.plant, lossy, run.start, run.inputs(), ignore).cost;
}

TEST(LostSamples, CostLessWhenTheLawRunsOnItsLastError) {
  const Scenario scenario = short_scenario();
  const double cost = evaluate(prepare(scenario), steady_settings(Form::incremental));
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const double repeated = lossy_cost(Bridge::repeat, seed);
    EXPECT_LT(repeated, 2 * cost) << seed;
    EXPECT_LT(repeated, lossy_cost(Bridge::hold, seed)) << seed;
  }
}

}  // namespace
}  // namespace nfopidn::test
