// What the incremental form does at the torque limit.
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class AntiWindupRules : public ::testing::Test {
 protected:
  using Controlled = Controller<Scalar, Fir<Scalar, 7>>;
  static constexpr Scalar limit = Scalar(0.5);

  // A gain of 1 on the error's change, per wheel: the error is the torque that `none` would hold.
  static ControllerSettings<Scalar> tracking(AntiWindup rule) {
    ControllerSettings<Scalar> settings;
    settings.form = Form::incremental;
    settings.activation = Activation::linear;
    settings.frame = Frame::world;
    settings.lateral = Lateral::plain;
    settings.allocation = {{{1, 0, 0}, {0, 1, 0}}};
    for (auto& gains : settings.gains) {
      gains[0] = 1;
      gains[1] = gains[2] = 0;
    }
    settings.anti_windup = rule;
    return settings;
  }
  static Controlled make(const ControllerSettings<Scalar>& settings) {
    Controlled law;
    EXPECT_EQ(law.configure(settings, {limit, 1}), Status::ok);
    return law;
  }
  // Feedback of the left wheel at each sample, the errors being its wished torque.
  static std::vector<double> feedback(AntiWindup rule, const std::vector<double>& wishes,
                                      const std::vector<double>& feedforward) {
    auto law = make(tracking(rule));
    std::vector<double> all;
    for (std::size_t k = 0; k < wishes.size(); ++k) {
      const auto wish = static_cast<Scalar>(wishes[k]);
      const auto torque = static_cast<Scalar>(feedforward[k]);
      law.step({0, 0, 0, 0, 0}, {wish, wish, 0, 0, 0, torque, torque, false});
      EXPECT_EQ(law.feedback().left, law.feedback().right);
      all.push_back(law.feedback().left);
    }
    return all;
  }
  static void expect_all_near(const std::vector<double>& values,
                              const std::vector<double>& expected) {
    ASSERT_EQ(values.size(), expected.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      EXPECT_TRUE(near(values[k], expected[k], 8 * unit<Scalar>)) << "sample " << k;
    }
  }
};
TYPED_TEST_SUITE(AntiWindupRules, Scalars);

TYPED_TEST(AntiWindupRules, NoneWindsUp) {
  const std::vector<double> wishes = {0.4, 0.9, 2, 0.1, -3};
  this->expect_all_near(this->feedback(AntiWindup::none, wishes, {0, 0, 0, 0, 0}), wishes);
}

TYPED_TEST(AntiWindupRules, HoldRefusesAWholeStepOutward) {
  // 0.9 and 2 are refused outright; the steps after them count from what was held.
  this->expect_all_near(
      this->feedback(AntiWindup::hold, {0.4, 0.9, 2, 1.9, -1, -1.2}, {0, 0, 0, 0, 0, 0}),
      {0.4, 0.4, 0.4, 0.3, 0.3, 0.1});
  // Beyond the limit because the feedforward moved: steps inward are taken, outward refused.
  this->expect_all_near(this->feedback(AntiWindup::hold, {0.4, 0.3, 0.35, 0.3}, {0, 0.9, 0.9, 0.9}),
                        {0.4, 0.3, 0.3, 0.25});
}

TYPED_TEST(AntiWindupRules, HoldAllowsTheLimitItself) {
  // All of them are binary fractions, so that the sums meet the limit exactly.
  this->expect_all_near(
      this->feedback(AntiWindup::hold, {0.25, 0.5, 0.75, -0.25, -0.5}, {0, 0, 0, 0, 0}),
      {0.25, 0.5, 0.5, -0.5, -0.5});
}

TYPED_TEST(AntiWindupRules, ClampStopsAtTheLimit) {
  this->expect_all_near(this->feedback(AntiWindup::clamp, {0.4, 0.9, 2, 1.8, -1}, {0, 0, 0, 0, 0}),
                        {0.4, 0.5, 0.5, 0.3, -0.5});
  // With feedforward 0.2 the feedback may reach 0.3 upwards and -0.7 downwards.
  this->expect_all_near(this->feedback(AntiWindup::clamp, {0.9, -3}, {0.2, 0.2}), {0.3, -0.7});
  // Beyond the limit because the feedforward moved: it stays there, and comes back by steps inward.
  this->expect_all_near(this->feedback(AntiWindup::clamp, {0.4, 0.45, 0.35}, {0, 0.9, 0.9}),
                        {0.4, 0.4, 0.3});
}

TYPED_TEST(AntiWindupRules, EachWheelIsJudgedByItself) {
  for (const AntiWindup rule : {AntiWindup::hold, AntiWindup::clamp}) {
    auto law = this->make(this->tracking(rule));
    law.step({0, 0, 0, 0, 0}, {2, TypeParam(0.25), 0, 0, 0, 0, 0, false});
    EXPECT_EQ(law.feedback().left, rule == AntiWindup::hold ? 0 : TestFixture::limit);
    EXPECT_EQ(law.feedback().right, TypeParam(0.25));
  }
}

TYPED_TEST(AntiWindupRules, EqualTheDesignOnRandomRuns) {
  Draws draw(41);
  for (const AntiWindup rule : {AntiWindup::none, AntiWindup::hold, AntiWindup::clamp}) {
    for (int run = 0; run < 8; ++run) {
      auto settings = random_settings<TypeParam>(draw);
      settings.form = Form::incremental;
      settings.anti_windup = rule;
      const ControlLimits<TypeParam> limits = {TestFixture::limit, 1};
      auto law = this->make(settings);
      LiteralLaw<TypeParam> literal{settings, limits};
      for (int k = 0; k < 40; ++k) {
        const auto measured = random_measurement<TypeParam>(draw);
        const auto reference = random_reference<TypeParam>(draw);
        const auto torque = law.step(measured, reference);
        const auto expected = literal.step(measured, reference);
        const Real tolerance = 1000 * unit<TypeParam>;
        ASSERT_TRUE(near(torque.left, expected[0], tolerance)) << "sample " << k;
        ASSERT_TRUE(near(torque.right, expected[1], tolerance)) << "sample " << k;
        ASSERT_TRUE(near(law.feedback().left, literal.feedback[0], tolerance)) << k;
        ASSERT_TRUE(near(law.feedback().right, literal.feedback[1], tolerance)) << k;
      }
    }
  }
}

TYPED_TEST(AntiWindupRules, DoNotTouchThePositionalForm) {
  Draws draw(42);
  auto settings = random_settings<TypeParam>(draw);
  auto plain = this->make(settings);
  settings.anti_windup = AntiWindup::clamp;
  auto clamped = this->make(settings);
  for (int k = 0; k < 20; ++k) {
    const auto measured = random_measurement<TypeParam>(draw);
    const auto reference = random_reference<TypeParam>(draw);
    ASSERT_TRUE(same_bits(plain.step(measured, reference), clamped.step(measured, reference)));
    ASSERT_TRUE(same_bits(plain.feedback(), clamped.feedback()));
  }
}

TYPED_TEST(AntiWindupRules, WhatTheMotorsCannotGiveIsSaturation) {
  for (const AntiWindup rule : {AntiWindup::none, AntiWindup::hold, AntiWindup::clamp}) {
    auto law = this->make(this->tracking(rule));
    const auto wish = [](double torque) {
      const auto given = static_cast<TypeParam>(torque);
      return ReferenceSample<TypeParam>{given, given, 0, 0, 0, 0, 0, false};
    };
    const TorquePair<TypeParam> commanded = law.step({0, 0, 0, 0, 0}, wish(0.4));
    law.learn_available(commanded, {TypeParam(0.3), commanded.right});
    law.step({0, 0, 0, 0, 0}, wish(0.35));
    const bool knows = rule != AntiWindup::none;
    EXPECT_TRUE(near(law.feedback().left, knows ? 0.25 : 0.35, 8 * unit<TypeParam>));
    EXPECT_TRUE(near(law.feedback().right, 0.35, 8 * unit<TypeParam>));
  }
}

}  // namespace
}  // namespace nfopidn::test
