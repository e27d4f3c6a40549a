// The law against the textbook and against a literal transcription of its equations.
#include <type_traits>

#include "nfopidn/control/controller.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Scalar>
class Law : public ::testing::Test {
 protected:
  using Number = Scalar;
  using Controlled = Controller<Scalar, Fir<Scalar, 7, 3>>;
  // Both sides round a dozen products of numbers of order 1; in the incremental form these add up.
  static constexpr Real tolerance = 2000 * unit<Scalar>;

  static Controlled make(const ControllerSettings<Scalar>& settings,
                         const ControlLimits<Scalar>& limits = {}) {
    Controlled law;
    EXPECT_EQ(law.configure(settings, limits), Status::ok);
    return law;
  }

  // Errors given straight to the channels: world frame, the robot at the origin.
  static ReferenceSample<Scalar> error_sample(Scalar x, Scalar y, Scalar theta) {
    return {x, y, theta, 0, 0, 0, 0, false};
  }
  static constexpr Measurement<Scalar> origin = {0, 0, 0, 0, 0};

  void expect_literal(const ControllerSettings<Scalar>& settings,
                      const ControlLimits<Scalar>& limits = {}, int samples = 30) {
    Controlled law = make(settings, limits);
    LiteralLaw<Scalar> literal{settings, limits};
    for (int k = 0; k < samples; ++k) {
      const auto measured = random_measurement<Scalar>(draw);
      const auto reference = random_reference<Scalar>(draw);
      const TorquePair<Scalar> torque = law.step(measured, reference);
      const std::array<Real, 2> expected = literal.step(measured, reference);
      ASSERT_TRUE(near(torque.left, expected[0], tolerance)) << "left, sample " << k;
      ASSERT_TRUE(near(torque.right, expected[1], tolerance)) << "right, sample " << k;
      ASSERT_TRUE(near(law.feedback().left, literal.feedback[0], tolerance)) << "sample " << k;
      ASSERT_TRUE(near(law.feedback().right, literal.feedback[1], tolerance)) << "sample " << k;
    }
  }

  Draws draw{31};
};
TYPED_TEST_SUITE(Law, Scalars);

TYPED_TEST(Law, WholeOrdersGiveTheTextbookPid) {
  ControllerSettings<TypeParam> settings;
  settings.generator = Generator::gl;
  settings.activation = Activation::linear;
  settings.frame = Frame::world;
  settings.lateral = Lateral::plain;
  settings.allocation = {{{1, 0, 0}, {0, 1, 0}}};  // a channel a wheel
  for (int channel = 0; channel < channel_count; ++channel) {
    settings.alpha[channel] = settings.sigma[channel] = 1;
  }
  const TypeParam kp[2] = {TypeParam(0.8), TypeParam(-0.4)};
  const TypeParam ki[2] = {TypeParam(0.11), TypeParam(0.07)};
  const TypeParam kd[2] = {TypeParam(0.35), TypeParam(0.6)};
  for (int wheel = 0; wheel < 2; ++wheel) {
    settings.gains[wheel][0] = kp[wheel];
    settings.gains[wheel][1] = ki[wheel];
    settings.gains[wheel][2] = kd[wheel];
  }
  const ControlLimits<TypeParam> unlimited = {TypeParam(1e6), 1};
  settings.form = Form::incremental;
  auto incremental = this->make(settings, unlimited);
  settings.form = Form::positional;
  auto positional = this->make(settings, unlimited);

  Real sum[2] = {0, 0};
  Real last_error[2] = {0, 0};
  Real last_output[2] = {0, 0};
  for (int k = 0; k < 60; ++k) {
    const auto x = this->draw.template scalar<TypeParam>(-1, 1);
    const auto y = this->draw.template scalar<TypeParam>(-1, 1);
    const auto sample = this->error_sample(x, y, 0);
    const auto whole = incremental.step(TestFixture::origin, sample);
    const auto change = positional.step(TestFixture::origin, sample);
    const Real error[2] = {x, y};
    const TypeParam outputs[2] = {whole.left, whole.right};
    const TypeParam changes[2] = {change.left, change.right};
    for (int wheel = 0; wheel < 2; ++wheel) {
      sum[wheel] += error[wheel];
      const Real pid = kp[wheel] * error[wheel] + ki[wheel] * sum[wheel] +
                       kd[wheel] * (error[wheel] - last_error[wheel]);
      ASSERT_TRUE(near(outputs[wheel], pid, 100 * unit<TypeParam>)) << "sample " << k;
      ASSERT_TRUE(near(changes[wheel], pid - last_output[wheel], 20 * unit<TypeParam>)) << k;
      last_error[wheel] = error[wheel];
      last_output[wheel] = pid;
    }
  }
}

// eq. 33
TYPED_TEST(Law, TheNeuronIsTanhOfHalfTheNet) {
  ControllerSettings<TypeParam> settings;
  settings.frame = Frame::world;
  settings.allocation = {{{1, 0, 0}, {0, 0, 1}}};
  settings.activation = Activation::linear;
  const ControlLimits<TypeParam> unlimited = {TypeParam(1e6), 1};
  auto linear = this->make(settings, unlimited);
  settings.activation = Activation::sigmoid;
  auto sigmoid = this->make(settings, unlimited);
  for (int k = 0; k < 60; ++k) {
    const auto sample = this->error_sample(this->draw.template scalar<TypeParam>(-9, 9), 0,
                                           this->draw.template scalar<TypeParam>(-3, 3));
    const auto net = linear.step(TestFixture::origin, sample);
    const auto output = sigmoid.step(TestFixture::origin, sample);
    ASSERT_TRUE(near(output.left, std::tanh(Real(net.left) / 2), 2 * unit<TypeParam>));
    ASSERT_TRUE(near(output.right, std::tanh(Real(net.right) / 2), 2 * unit<TypeParam>));
  }
}

// eqs. 31-36
TYPED_TEST(Law, EveryStructureEqualsTheEquations) {
  for (const Form form : {Form::positional, Form::incremental}) {
    for (const Generator generator : {Generator::tustin, Generator::gl}) {
      for (const Activation activation : {Activation::sigmoid, Activation::linear}) {
        for (const Frame frame : {Frame::robot, Frame::world}) {
          for (const Lateral lateral : {Lateral::plain, Lateral::direction, Lateral::speed}) {
            auto settings = random_settings<TypeParam>(this->draw);
            settings.form = form;
            settings.generator = generator;
            settings.activation = activation;
            settings.frame = frame;
            settings.lateral = lateral;
            this->expect_literal(settings, {TypeParam(50), TypeParam(0.7)});
            if (this->HasFatalFailure()) return;
          }
        }
      }
    }
  }
}

TYPED_TEST(Law, EveryMemoryEqualsTheEquations) {
  for (int memory = 0; memory <= 5; ++memory) {
    auto settings = random_settings<TypeParam>(this->draw);
    settings.memory = memory;
    this->expect_literal(settings);
  }
}

// eqs. 31-32
TYPED_TEST(Law, NamedAllocationsAreThoseOfTheDesign) {
  const auto paper = Allocation<TypeParam>::paper();
  const auto decoupled = Allocation<TypeParam>::decoupled();
  const TypeParam expected_paper[2][3] = {{0, 1, 1}, {1, 1, 0}};
  const TypeParam expected_decoupled[2][3] = {{1, 1, 1}, {1, -1, -1}};
  for (int wheel = 0; wheel < 2; ++wheel) {
    for (int channel = 0; channel < channel_count; ++channel) {
      EXPECT_EQ(paper.matrix[wheel][channel], expected_paper[wheel][channel]);
      EXPECT_EQ(decoupled.matrix[wheel][channel], expected_decoupled[wheel][channel]);
    }
  }
}

// They have sums of their own instead of a matrix.
TYPED_TEST(Law, NamedAllocationsEqualTheEquations) {
  for (const auto& named : {Allocation<TypeParam>::paper(), Allocation<TypeParam>::decoupled()}) {
    ControllerSettings<TypeParam> settings = random_settings<TypeParam>(this->draw);
    settings.allocation = named;
    this->expect_literal(settings);
  }
}

TYPED_TEST(Law, TheSpeedScaleOfTheSettingsComesFirst) {
  auto settings = random_settings<TypeParam>(this->draw);
  settings.lateral = Lateral::speed;
  settings.speed_scale = TypeParam(0.3);
  this->expect_literal(settings, {TypeParam(50), TypeParam(2)});
  settings.speed_scale = 0;
  this->expect_literal(settings, {TypeParam(50), TypeParam(2)});
}

TYPED_TEST(Law, TotalTorqueIsLimitedAndFeedbackIsNot) {
  auto settings = random_settings<TypeParam>(this->draw);
  const TypeParam limit = TypeParam(0.25);
  auto law = this->make(settings, {limit, 1});
  int limited = 0;
  for (int k = 0; k < 100; ++k) {
    const auto reference = random_reference<TypeParam>(this->draw);
    const auto torque = law.step(random_measurement<TypeParam>(this->draw), reference);
    const TypeParam left = law.feedback().left + reference.tau_left;
    const TypeParam right = law.feedback().right + reference.tau_right;
    ASSERT_EQ(torque.left, std::max(-limit, std::min(left, limit)));
    ASSERT_EQ(torque.right, std::max(-limit, std::min(right, limit)));
    limited += (std::fabs(left) > limit) + (std::fabs(right) > limit);
  }
  EXPECT_GT(limited, 20);
}

TYPED_TEST(Law, TheDefaultLimitIsThePapers) {
  EXPECT_EQ(ControlLimits<TypeParam>{}.torque, TypeParam(3.078));
  ControllerSettings<TypeParam> settings;
  settings.activation = Activation::linear;
  auto law = this->make(settings);
  const auto torque = law.step(TestFixture::origin, this->error_sample(100, 100, 3));
  EXPECT_EQ(torque.left, TypeParam(3.078));
  EXPECT_EQ(torque.right, TypeParam(3.078));
}

// Turning the whole world leaves what the robot sees of it.
TYPED_TEST(Law, RobotFrameDoesNotDependOnTheWorldsAxes) {
  auto settings = random_settings<TypeParam>(this->draw);
  settings.form = Form::incremental;
  auto here = this->make(settings, {TypeParam(50), 1});
  auto there = this->make(settings, {TypeParam(50), 1});
  settings.frame = Frame::world;
  auto unturned = this->make(settings, {TypeParam(50), 1});
  auto turned = this->make(settings, {TypeParam(50), 1});
  const double angle = 1.1;
  const auto turn = [&](auto pose) {
    const auto cosine = static_cast<TypeParam>(std::cos(angle));
    const auto sine = static_cast<TypeParam>(std::sin(angle));
    const TypeParam x = pose.x;
    pose.x = cosine * x - sine * pose.y;
    pose.y = sine * x + cosine * pose.y;
    pose.theta += static_cast<TypeParam>(angle);
    return pose;
  };
  TypeParam difference_in_world = 0;
  for (int k = 0; k < 20; ++k) {
    const auto measured = random_measurement<TypeParam>(this->draw);
    auto reference = random_reference<TypeParam>(this->draw);
    reference.theta = measured.theta + this->draw.template scalar<TypeParam>(-2, 2);
    const auto a = here.step(measured, reference);
    const auto b = there.step(turn(measured), turn(reference));
    ASSERT_TRUE(near(a.left, b.left, TestFixture::tolerance)) << k;
    ASSERT_TRUE(near(a.right, b.right, TestFixture::tolerance)) << k;
    const auto c = unturned.step(measured, reference);
    const auto d = turned.step(turn(measured), turn(reference));
    difference_in_world = std::max(difference_in_world, std::fabs(c.left - d.left));
  }
  EXPECT_GT(difference_in_world, TypeParam(0.05));
}

TYPED_TEST(Law, RotationIntoTheRobotAndBack) {
  for (int k = 0; k < 100; ++k) {
    const auto angle = this->draw.template scalar<TypeParam>(-7, 7);
    const Channels<TypeParam> world = {this->draw.template scalar<TypeParam>(-1, 1),
                                       this->draw.template scalar<TypeParam>(-1, 1),
                                       this->draw.template scalar<TypeParam>(-1, 1)};
    const auto robot = rotate_into_robot(world, math<TypeParam>::heading(angle));
    const auto back = rotate_into_robot(robot, math<TypeParam>::heading(-angle));
    ASSERT_TRUE(near(robot.x, std::cos(Real(angle)) * world.x + std::sin(Real(angle)) * world.y,
                     4 * unit<TypeParam>));
    ASSERT_TRUE(near(back.x, world.x, 6 * unit<TypeParam>));
    ASSERT_TRUE(near(back.y, world.y, 6 * unit<TypeParam>));
    ASSERT_EQ(back.theta, world.theta);
  }
}

TYPED_TEST(Law, NeverReadsSpeeds) {
  auto settings = random_settings<TypeParam>(this->draw);
  auto seeing = this->make(settings);
  auto blind = this->make(settings);
  for (int k = 0; k < 10; ++k) {
    auto measured = random_measurement<TypeParam>(this->draw);
    const auto reference = random_reference<TypeParam>(this->draw);
    const auto expected = seeing.step(measured, reference);
    measured.v = measured.omega = not_a_number<TypeParam>;
    ASSERT_TRUE(same_bits(blind.step(measured, reference), expected));
  }
}

TYPED_TEST(Law, TakesErrorsAndHeadingFromItsCaller) {
  auto settings = random_settings<TypeParam>(this->draw);
  auto own = this->make(settings);
  auto given = this->make(settings);
  for (int k = 0; k < 10; ++k) {
    const auto measured = random_measurement<TypeParam>(this->draw);
    const auto reference = random_reference<TypeParam>(this->draw);
    const auto heading = math<TypeParam>::heading(measured.theta);
    const auto error = world_errors(measured, reference);
    ASSERT_TRUE(same_bits(own.step(measured, reference), given.step(error, heading, reference)));
  }
}

TYPED_TEST(Law, IsPlainData) {
  EXPECT_TRUE(std::is_trivially_copyable_v<typename TestFixture::Controlled>);
  EXPECT_TRUE(std::is_aggregate_v<ControllerSettings<TypeParam>>);
  EXPECT_TRUE(noexcept(std::declval<typename TestFixture::Controlled&>().step(
      std::declval<Measurement<TypeParam>>(), std::declval<ReferenceSample<TypeParam>>())));
}

}  // namespace
}  // namespace nfopidn::test
