// Structures: fixed in the type, or chosen at run time, one law to the last bit.
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Fixed, class Base>
void expect_same_bits(const ControllerSettings<Base>& settings) {
  Controller<Base, Fir<Base, 7>> any;
  Controller<Base, Fir<Base, 7>, Fixed> fixed;
  ASSERT_EQ(any.configure(settings), Status::ok);
  ASSERT_EQ(fixed.configure(settings), Status::ok);
  Draws draw(1);
  for (int k = 0; k < 2000; ++k) {
    const auto measured = random_measurement<Base>(draw);
    const auto reference = random_reference<Base>(draw);
    ASSERT_TRUE(same_bits(any.step(measured, reference), fixed.step(measured, reference))) << k;
  }
}

template <class Scalar>
class Structures : public ::testing::Test {};
TYPED_TEST_SUITE(Structures, Scalars);

TYPED_TEST(Structures, FixedIsAnyToTheBit) {
  using Base = TypeParam;
  Draws draw(3);
  ControllerSettings<Base> settings = random_settings<Base>(draw);
  settings.allocation = Allocation<Base>::paper();
  expect_same_bits<FixedVariant<Base>>(settings);

  settings.allocation = Allocation<Base>::decoupled();
  settings.form = Form::incremental;
  settings.lateral = Lateral::speed;
  settings.anti_windup = AntiWindup::clamp;
  expect_same_bits<FixedVariant<Base, Form::incremental, AllocationKind::decoupled, Lateral::speed,
                                AntiWindup::clamp>>(settings);

  settings.lateral = Lateral::plain;
  settings.anti_windup = AntiWindup::hold;
  settings.activation = Activation::linear;
  settings.frame = Frame::world;
  expect_same_bits<FixedVariant<Base, Form::incremental, AllocationKind::decoupled, Lateral::plain,
                                AntiWindup::hold, Activation::linear, Frame::world>>(settings);
}

TYPED_TEST(Structures, FixedRefusesAnother) {
  using Base = TypeParam;
  Controller<Base, Fir<Base, 7>, FixedVariant<Base>> law;
  EXPECT_EQ(law.configure({}), Status::ok);
  const auto refused = [&](auto change) {
    ControllerSettings<Base> settings;
    change(settings);
    return law.configure(settings) == Status::inconsistent;
  };
  using S = ControllerSettings<Base>;
  EXPECT_TRUE(refused([](S& s) { s.form = Form::incremental; }));
  EXPECT_TRUE(refused([](S& s) { s.activation = Activation::linear; }));
  EXPECT_TRUE(refused([](S& s) { s.frame = Frame::world; }));
  EXPECT_TRUE(refused([](S& s) { s.lateral = Lateral::plain; }));
  EXPECT_TRUE(refused([](S& s) { s.anti_windup = AntiWindup::hold; }));
  EXPECT_TRUE(refused([](S& s) { s.allocation = Allocation<Base>::decoupled(); }));
  EXPECT_TRUE(refused([](S& s) { s.allocation.matrix[0][0] = Base(0.5); }));
}

// What is fixed needs no memory: taps, past errors, torques, limit and a few counters are all.
TEST(Structure, FixedIsSmaller) {
  EXPECT_LE(sizeof(Controller<float, Fir<float, 7>, FixedVariant<float>>), 192U);
  EXPECT_LE(sizeof(Controller<float, Fir<float, 7>>), 240U);
}

}  // namespace
}  // namespace nfopidn::test
