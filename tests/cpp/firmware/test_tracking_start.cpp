// The tracking law where poses are missing: at the start, after a pause, and between two samples. A
// robot that is exactly where its reference is, and moves as it does, needs no feedback.
#include "nfopidn/firmware.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
ControllerSettings<Scalar> tracking_settings() {
  ControllerSettings<Scalar> settings;
  for (auto& row : settings.gains) row[0] = row[1] = row[2] = 0;
  settings.gains[0][0] = 2;
  settings.gains[1][0] = Scalar(0.3);
  settings.gains[2][0] = 1;
  settings.allocation = Allocation<Scalar>::decoupled();
  settings.net = Net::speed_errors;
  settings.lateral = Lateral::scheduled;
  settings.speed_gain_x = 12;
  settings.speed_gain_theta = 3;
  settings.amplitude_x = Scalar(0.65);
  settings.integral_x = Scalar(0.02);
  settings.pole_x = Scalar(0.1);
  settings.sample_time = Scalar(0.2);
  return settings;
}

template <class Scalar>
class TrackingStart : public testing::Test {
 public:
  using Fixed =
      FixedVariant<Scalar, Form::positional, AllocationKind::decoupled, Lateral::scheduled>;
  using Law = Controller<Scalar, Fir<Scalar, 7>, FixedTrackingVariant<Scalar, Fixed>>;
  using AnyLaw = Controller<Scalar, Fir<Scalar, 7>, TrackingVariant<Scalar>>;
  static constexpr Scalar speed = Scalar(0.3);

  TrackingStart() { EXPECT_EQ(law.configure(tracking_settings<Scalar>()), Status::ok); }

  // Sample k of a reference along x, and the pose of a robot on it.
  static ReferenceSample<Scalar> reference(int k) {
    return {speed * Scalar(0.2) * Scalar(k), 1, 0, speed, 0, 0, 0, false};
  }
  static Measurement<Scalar> on_it(int k) { return {reference(k).x, 1, 0, 0, 0}; }

  static void expect_none(const TorquePair<Scalar>& torque) {
    EXPECT_NEAR(torque.left, 0, 2e-5);
    EXPECT_NEAR(torque.right, 0, 2e-5);
  }
  // Of a speed error of the whole reference speed.
  static constexpr double kick = 0.3;

  Law law;
};
TYPED_TEST_SUITE(TrackingStart, Scalars);

TYPED_TEST(TrackingStart, KicksARobotAtRestAndNoneInMotion) {
  EXPECT_GT(this->law.step(this->on_it(0), this->reference(0)).left, this->kick);
  this->law.reset();
  EXPECT_GT(this->law.step(this->on_it(0), this->reference(0)).left, this->kick);
  this->law.reset_to(this->on_it(5), this->reference(5));
  for (int k = 5; k < 9; ++k) this->expect_none(this->law.step(this->on_it(k), this->reference(k)));
  this->law.reset_in_motion();
  for (int k = 2; k < 9; ++k) this->expect_none(this->law.step(this->on_it(k), this->reference(k)));
}

TYPED_TEST(TrackingStart, SharesOutTheWayOverMissedSamples) {
  for (const bool repeats : {false, true}) {
    this->law.reset_in_motion();
    int k = 0;
    for (const int missed : {0, 1, 3}) {
      this->expect_none(this->law.step(this->on_it(k), this->reference(k)));
      ++k;
      for (int i = 0; i < missed; ++i, ++k) {
        if (repeats) this->expect_none(this->law.repeat(this->reference(k)));
        if (!repeats) this->law.miss();
      }
    }
    this->expect_none(this->law.step(this->on_it(k), this->reference(k)));
    // And none of it is left for the next one.
    EXPECT_LT(this->law.step(this->on_it(k + 2), this->reference(k + 1)).left, -0.1);
  }
}

TYPED_TEST(TrackingStart, MissesBeforeTheFirstPoseDoNotCount) {
  this->law.reset_in_motion();
  this->law.miss();
  for (int k = 3; k < 6; ++k) this->expect_none(this->law.step(this->on_it(k), this->reference(k)));
}

TYPED_TEST(TrackingStart, IsGuardedWithEitherBridge) {
  using Smooth = Bumpless<typename TestFixture::Law, TypeParam>;
  for (const Bridge bridge : {Bridge::hold, Bridge::repeat}) {
    Smooth smooth(this->law, 3);
    Guarded<Smooth, TypeParam> guarded(smooth, 3, bridge);
    guarded.reset_to(this->on_it(0), this->reference(0));
    auto bad = this->on_it(0);
    bad.x = not_a_number<TypeParam>;
    auto turning = this->reference(0);
    turning.omega = not_a_number<TypeParam>;
    for (int k = 0; k < 30; ++k) {
      const auto step = [&] {
        if (k % 7 == 4) return guarded.step(bad, this->reference(k));
        if (k % 7 == 5) return guarded.step(this->on_it(k), turning);
        if (k % 7 == 6) return guarded.missed(turning);
        return guarded.step(this->on_it(k), this->reference(k));
      };
      this->expect_none(step());
      EXPECT_EQ(guarded.fault(), k % 7 < 4 ? Fault::none : Fault::held);
    }
  }
}

// A law that does not read the turn rate is not stopped by a bad one.
TYPED_TEST(TrackingStart, TurnRatesMatterToTheTrackingLawAlone) {
  Controller<TypeParam, Fir<TypeParam, 7>> other;
  Guarded<decltype(other), TypeParam> guarded(other, 0);
  auto turning = this->reference(0);
  turning.omega = not_a_number<TypeParam>;
  guarded.step(this->on_it(0), turning);
  EXPECT_EQ(guarded.fault(), Fault::none);
}

TYPED_TEST(TrackingStart, ForgetsTheLastError) {
  auto off = this->on_it(0);
  off.x -= 1;
  this->law.step(off, this->reference(0));
  this->law.reset();
  this->expect_none(this->law.repeat(this->reference(0)));
  this->law.reset_to(off, this->reference(0));
  EXPECT_GT(this->law.repeat(this->reference(1)).left, 0.1);
}

TYPED_TEST(TrackingStart, IsTheSameChosenInTheTypeOrAtRunTime) {
  typename TestFixture::AnyLaw other;
  ASSERT_EQ(other.configure(tracking_settings<TypeParam>()), Status::ok);
  Draws draw(3);
  for (int k = 0; k < 200; ++k) {
    const auto m = random_measurement<TypeParam>(draw);
    const auto r = random_reference<TypeParam>(draw);
    const auto ours = k % 5 == 3 ? this->law.repeat(r) : this->law.step(m, r);
    const auto theirs = k % 5 == 3 ? other.repeat(r) : other.step(m, r);
    ASSERT_EQ(ours.left, theirs.left);
    ASSERT_EQ(ours.right, theirs.right);
  }
  auto settings = tracking_settings<TypeParam>();
  using Whole = FixedTrackingVariant<TypeParam, typename TestFixture::Fixed, Net::whole>;
  EXPECT_FALSE(Whole::offers(settings));
  settings.lateral = Lateral::plain;
  EXPECT_EQ(this->law.configure(settings), Status::inconsistent);
}

}  // namespace
}  // namespace nfopidn::test
