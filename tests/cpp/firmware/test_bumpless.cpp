// New gains, another reference, another controller: the torques glide.
#include "guarded_rig.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class BumplessLaw : public ::testing::Test {
 protected:
  static constexpr Scalar limit = ControlLimits<Scalar>{}.torque;

  static ControllerSettings<Scalar> other_gains() {
    ControllerSettings<Scalar> settings;
    for (auto& gains : settings.gains) gains[0] = gains[2] = Scalar(0.05);
    return settings;
  }
  // last + (own - last) i / samples, in long double.
  static Real between(Scalar begin_offset, Scalar own, int i, int samples) {
    const Real glided = Real(own) + Real(begin_offset) * (samples - i) / samples;
    return std::min(std::max(glided, -Real(limit)), Real(limit));
  }
};
TYPED_TEST_SUITE(BumplessLaw, Scalars);

TYPED_TEST(BumplessLaw, AddsNothingWithoutAChange) {
  Rig<TypeParam> rig;
  Bumpless<decltype(rig.law), TypeParam> smooth(rig.law, this->limit);
  for (int k = 0; k < 10; ++k) {
    const auto m = rig.measured();
    const auto r = rig.reference();
    ASSERT_TRUE(same_bits(smooth.step(m, r), rig.plain.step(m, r)));
    if (k == 5) smooth.begin(0);
    ASSERT_FALSE(smooth.gliding());
  }
}

TYPED_TEST(BumplessLaw, GlidesFromTheLastTorqueToTheNewGains) {
  for (const int samples : {1, 2, 5, 20}) {
    Rig<TypeParam> rig;
    Bumpless<decltype(rig.law), TypeParam> smooth(rig.law, this->limit);
    TorquePair<TypeParam> last = {};
    for (int k = 0; k < 4; ++k) {
      const auto m = rig.measured();
      const auto r = rig.reference();
      last = smooth.step(m, r);
      rig.plain.step(m, r);
    }
    ASSERT_EQ(rig.law.configure(this->other_gains()), Status::ok);
    ASSERT_EQ(rig.plain.configure(this->other_gains()), Status::ok);
    smooth.begin(samples);
    TorquePair<TypeParam> offset = {};
    for (int i = 0; i < samples + 3; ++i) {
      const auto m = rig.measured();
      const auto r = rig.reference();
      EXPECT_EQ(smooth.gliding(), i < samples);
      const auto torque = smooth.step(m, r);
      const auto own = rig.plain.step(m, r);
      if (i == 0) {
        offset = {last.left - own.left, last.right - own.right};
        EXPECT_TRUE(same_bits(torque, last));
      }
      if (i >= samples) {
        EXPECT_TRUE(same_bits(torque, own));
        continue;
      }
      const Real slack = 16 * unit<TypeParam>;
      EXPECT_TRUE(near(torque.left, this->between(offset.left, own.left, i, samples), slack)) << i;
      EXPECT_TRUE(near(torque.right, this->between(offset.right, own.right, i, samples), slack));
    }
    smooth.begin(-3);
    const auto m = rig.measured();
    const auto r = rig.reference();
    EXPECT_TRUE(same_bits(smooth.step(m, r), rig.plain.step(m, r)));
  }
}

// The reference jumps by metres: without the glide, so does the torque.
TYPED_TEST(BumplessLaw, GlidesToAnotherReference) {
  Rig<TypeParam> rig;
  Bumpless<decltype(rig.law), TypeParam> smooth(rig.law, this->limit);
  const Measurement<TypeParam> m = {};
  ReferenceSample<TypeParam> r = {};
  for (int k = 0; k < 8; ++k) smooth.step(m, r);
  r.x = 2;
  r.theta = -1;
  constexpr int samples = 10;
  smooth.begin(samples);
  TorquePair<TypeParam> last = {};
  TypeParam kick = 0;
  for (int i = 0; i < 2 * samples; ++i) {
    const auto torque = smooth.step(m, r);
    const auto own = i < 8 ? rig.plain.step(m, r) : torque;
    kick = std::max(kick, std::fabs(own.left));
    if (i == 0) {
      EXPECT_TRUE(same_bits(torque, no_torque<TypeParam>()));
    }
    EXPECT_LE(std::fabs(torque.left - last.left), TypeParam(0.5)) << i;
    last = torque;
  }
  EXPECT_GT(kick, TypeParam(0.7));
}

TYPED_TEST(BumplessLaw, TakesOverFromSomebodyElseWithinTheLimit) {
  Rig<TypeParam> rig;
  Bumpless<decltype(rig.law), TypeParam> smooth(rig.law, this->limit);
  const auto m = rig.measured();
  auto r = rig.reference();
  smooth.begin_from({TypeParam(1.25), TypeParam(-9)}, 4);
  const auto first = smooth.step(m, r);
  EXPECT_EQ(first.left, TypeParam(1.25));
  EXPECT_EQ(first.right, -this->limit);
  smooth.begin_from({9, 0}, 4);
  EXPECT_EQ(smooth.step(m, r).left, this->limit);
  // The feedforward, which comes on top, takes the sum beyond the limit.
  r.tau_left = r.tau_right = 9;
  smooth.begin_from({2, 2}, 4);
  smooth.step(m, {});
  const auto above = smooth.step(m, r);
  EXPECT_EQ(above.left, this->limit);
  EXPECT_EQ(above.right, this->limit);
}

TYPED_TEST(BumplessLaw, AFreshStartEndsTheGlide) {
  for (int kind = 0; kind < 2; ++kind) {
    Rig<TypeParam> rig;
    Bumpless<decltype(rig.law), TypeParam> smooth(rig.law, this->limit);
    const auto m = rig.measured();
    const auto r = rig.reference();
    smooth.begin_from({1, 1}, 4);
    if (kind == 0) {
      smooth.reset();
    } else {
      smooth.reset_to(m, r);
      rig.plain.reset_to(m, r);
    }
    EXPECT_FALSE(smooth.gliding());
    EXPECT_TRUE(same_bits(smooth.step(m, r), rig.plain.step(m, r)));
    kind == 0 ? smooth.reset() : smooth.reset_to(m, r);
    smooth.begin(2);
    EXPECT_TRUE(same_bits(smooth.step(m, r), no_torque<TypeParam>()));
  }
}

// With a Guarded around it: missed samples glide on, held ones wait, a stop is at once.
TYPED_TEST(BumplessLaw, StopsAtOnceUnderAGuard) {
  Rig<TypeParam> rig;
  using Smooth = Bumpless<decltype(rig.law), TypeParam>;
  Smooth smooth(rig.law, this->limit);
  Guarded<Smooth, TypeParam> guarded(smooth, 1);
  const auto r = rig.reference();
  guarded.step(rig.measured(), r);
  smooth.begin(10);
  const auto held = guarded.step({not_a_number<TypeParam>, 0, 0, 0, 0}, r);
  EXPECT_TRUE(smooth.gliding());
  EXPECT_TRUE(same_bits(guarded.step(rig.measured(), r), held));
  const auto own = Rig<TypeParam>().plain.step(rig.measured(), r);
  EXPECT_FALSE(same_bits(guarded.missed(r), own));
  EXPECT_TRUE(smooth.gliding());
  EXPECT_TRUE(same_bits(guarded.missed(r), no_torque<TypeParam>()));
  const auto m = rig.measured();
  const auto restarted = guarded.step(m, r);
  rig.plain.reset_to(m, r);
  EXPECT_TRUE(same_bits(restarted, rig.plain.step(m, r)));
}

// A torque that is no number would otherwise go to the wheels with its share of the glide.
TYPED_TEST(BumplessLaw, GlidesFromNoneWhereTheLastIsNoNumber) {
  constexpr TypeParam nan = std::numeric_limits<TypeParam>::quiet_NaN();
  constexpr TypeParam infinite = std::numeric_limits<TypeParam>::infinity();
  for (const TorquePair<TypeParam>& last : {TorquePair<TypeParam>{nan, 1}, {1, -infinite}}) {
    Rig<TypeParam> rig, other;
    Bumpless<decltype(rig.law), TypeParam> smooth(rig.law, this->limit);
    Bumpless<decltype(rig.law), TypeParam> from_none(other.law, this->limit);
    smooth.begin_from(last, 3);
    from_none.begin_from({0, 0}, 3);
    for (int k = 0; k < 5; ++k) {
      const auto m = rig.measured();
      const auto r = rig.reference();
      const auto torque = smooth.step(m, r);
      ASSERT_TRUE(std::isfinite(torque.left) && std::isfinite(torque.right)) << k;
      ASSERT_TRUE(same_bits(torque, from_none.step(m, r))) << k;
    }
  }
}

}  // namespace
}  // namespace nfopidn::test
