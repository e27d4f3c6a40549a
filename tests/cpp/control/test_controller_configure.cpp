// What configure() refuses, that a refusal changes nothing, and what reset() brings back.
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Value, class Use>
void for_each_number(Value& value, const Use& use) {
  if constexpr (std::is_array_v<Value>) {
    for (auto& element : value) for_each_number(element, use);
  } else if constexpr (std::is_same_v<Value, Memory>) {
    use(value.samples);
  } else if constexpr (std::is_same_v<Value, SampleTime<double>> ||
                       std::is_same_v<Value, SampleTime<float>>) {
    use(value.seconds);
  } else if constexpr (std::is_class_v<Value>) {
    for_each_number(value.matrix, use);
  } else if constexpr (std::is_arithmetic_v<Value>) {
    use(value);
  }
}

template <class Scalar>
class Configure : public ::testing::Test {
 protected:
  using Settings = ControllerSettings<Scalar>;
  using Controlled = Controller<Scalar, Fir<Scalar, 7, 2>>;

  struct Sample {
    Measurement<Scalar> measured;
    ReferenceSample<Scalar> reference;
  };
  static std::vector<Sample> random_samples(int count) {
    Draws draw(51);
    std::vector<Sample> samples;
    for (int k = 0; k < count; ++k) {
      const auto measured = random_measurement<Scalar>(draw);
      samples.push_back({measured, random_reference<Scalar>(draw)});
    }
    return samples;
  }
  static Settings incremental() {
    Settings settings;
    settings.form = Form::incremental;
    return settings;
  }
  // Settings that every number of the tracking law may be turned in.
  static Settings tracking() {
    Settings settings;
    for (auto& row : settings.gains) row[1] = row[2] = 0;
    settings.allocation = Allocation<Scalar>::decoupled();
    settings.net = Net::speed_errors;
    return settings;
  }
  static bool belongs_to_tracking_law(const std::string& field) {
    for (const char* start :
         {"speed_gain", "speed_order", "amplitude", "pole", "integral", "lateral_"}) {
      if (field.rfind(start, 0) == 0) return true;
    }
    return false;
  }
  static Controlled running() {
    Controlled law;
    EXPECT_EQ(law.configure(incremental()), Status::ok);
    for (const Sample& sample : random_samples(9)) law.step(sample.measured, sample.reference);
    return law;
  }
  static void expect_same_future(Controlled a, Controlled b, const std::string& what) {
    for (const Sample& sample : random_samples(12)) {
      const auto first = a.step(sample.measured, sample.reference);
      ASSERT_TRUE(same_bits(first, b.step(sample.measured, sample.reference))) << what;
      ASSERT_TRUE(same_bits(a.feedback(), b.feedback())) << what;
    }
  }
  static void expect_refusal(const Settings& settings, const ControlLimits<Scalar>& limits,
                             Status status, const std::string& what) {
    Controlled law = running();
    EXPECT_EQ(law.configure(settings, limits), status) << what;
    expect_same_future(law, running(), what);
  }

  // Calls expect(field, settings with one number of the field replaced) for every number.
  template <class Replace, class Expect>
  static void replace_every_number(const Replace& replace, const Expect& expect) {
    Settings::fields([&](const auto& field) {
      Settings settings = belongs_to_tracking_law(field.name) ? tracking() : Settings{};
      for_each_number(settings.*field.member, [&](auto& number) {
        const auto before = number;
        if (replace(field, number)) expect(field.name, settings);
        number = before;
      });
    });
  }
};
TYPED_TEST_SUITE(Configure, Scalars);

TYPED_TEST(Configure, RefusesWhatIsNotFinite) {
  int tried = 0;
  for (const TypeParam bad : {not_a_number<TypeParam>, infinite<TypeParam>, -infinite<TypeParam>}) {
    const auto replace = [&](const auto&, auto& number) {
      if constexpr (std::is_same_v<std::decay_t<decltype(number)>, TypeParam>) {
        number = bad;
        return true;
      }
      return false;
    };
    this->replace_every_number(replace, [&](const char* name, const auto& settings) {
      this->expect_refusal(settings, {}, Status::not_finite, name);
      ++tried;
    });
  }
  // Gains, orders, allocation, speed scale, sample time, the tracking law's.
  EXPECT_EQ(tried, 3 * (9 + 3 + 3 + 6 + 1 + 1 + 16));
}

TYPED_TEST(Configure, RefusesWhatIsOutOfRange) {
  for (const bool high : {false, true}) {
    const auto replace = [&](const auto& field, auto& number) {
      using Number = std::decay_t<decltype(number)>;
      if (high && std::isinf(field.range.high)) return false;
      const auto end = static_cast<Number>(high ? field.range.high : field.range.low);
      if constexpr (std::is_integral_v<Number>) {
        number = high ? end + 1 : end - 1;
      } else {
        number = std::nextafter(end, high ? infinite<Number> : -infinite<Number>);
      }
      return true;
    };
    this->replace_every_number(replace, [&](const char* name, const auto& settings) {
      this->expect_refusal(settings, {}, Status::out_of_range, name);
    });
  }
}

TYPED_TEST(Configure, AcceptsTheEndsOfTheRanges) {
  for (const bool high : {false, true}) {
    const auto replace = [&](const auto& field, auto& number) {
      if (high && std::isinf(field.range.high)) return false;
      number =
          static_cast<std::decay_t<decltype(number)>>(high ? field.range.high : field.range.low);
      using Number = std::decay_t<decltype(number)>;
      if constexpr (!std::is_integral_v<Number>) {  // an end that is no float is rounded inwards
        if (!field.range.contains(number)) number = std::nextafter(number, Number(high ? -1 : 1));
      }
      return true;
    };
    this->replace_every_number(replace, [&](const char* name, const auto& settings) {
      EXPECT_EQ(settings.validate(), Status::ok) << name;
    });
  }
}

TYPED_TEST(Configure, RangesAreThoseOfTheContract) {
  auto settings = this->incremental();
  settings.alpha[1] = TypeParam(2.5);
  this->expect_refusal(settings, {}, Status::out_of_range, "alpha");
  settings = this->incremental();
  settings.sigma[2] = TypeParam(-2.5);
  this->expect_refusal(settings, {}, Status::out_of_range, "sigma");
  settings = this->incremental();
  settings.memory = -1;
  this->expect_refusal(settings, {}, Status::out_of_range, "memory");
}

TYPED_TEST(Configure, RefusesAMemoryBeyondTheFilter) {
  auto settings = this->incremental();
  settings.memory = 6;
  this->expect_refusal(settings, {}, Status::out_of_range, "memory 6 in 7 taps");
  Controller<TypeParam, Fir<TypeParam, 8>> larger;
  EXPECT_EQ(larger.configure(settings), Status::ok);
  EXPECT_EQ(larger.filter().count(), 8);
}

TYPED_TEST(Configure, RefusesBadLimits) {
  for (const TypeParam bad : {TypeParam(0), TypeParam(-1), not_a_number<TypeParam>}) {
    this->expect_refusal(this->incremental(), {bad, 1}, Status::out_of_range, "torque limit");
    this->expect_refusal(this->incremental(), {1, bad}, Status::out_of_range, "speed scale");
  }
}

// 1/scale of a denormal scale is infinite, and infinity times an error of 0 is no number.
TYPED_TEST(Configure, TheLeastSpeedScaleGivesTorques) {
  ControllerSettings<TypeParam> settings;
  settings.lateral = Lateral::speed;
  const ControlLimits<TypeParam> limits = {TypeParam(3.078),
                                           std::numeric_limits<TypeParam>::denorm_min()};
  for (const TypeParam scale : {TypeParam(0), limits.speed_scale, TypeParam(least_speed_scale)}) {
    settings.speed_scale = scale;
    typename TestFixture::Controlled law;
    ASSERT_EQ(law.configure(settings, limits), Status::ok);
    ReferenceSample<TypeParam> reference = {};
    EXPECT_EQ(law.step(Measurement<TypeParam>{}, reference).left, 0) << scale;
    reference.y = TypeParam(0.1);
    reference.v = TypeParam(least_speed_scale) / 2;  // feeds half the error
    const auto torque = law.step(Measurement<TypeParam>{}, reference);
    settings.lateral = Lateral::plain;
    reference.y /= 2;
    typename TestFixture::Controlled plain;
    plain.configure(settings);
    settings.lateral = Lateral::speed;
    EXPECT_TRUE(near(torque.left, plain.step(Measurement<TypeParam>{}, reference).left,
                     8 * unit<TypeParam>))
        << scale;
  }
}

TYPED_TEST(Configure, KeepsPastErrorsAndTheLastTorque) {
  auto law = this->running();
  ASSERT_NE(law.feedback().left, 0);
  EXPECT_EQ(law.configure(this->incremental()), Status::ok);
  this->expect_same_future(law, this->running(), "configured again");
}

TYPED_TEST(Configure, GivenTapsAreAsGoodAsGains) {
  const auto settings = this->incremental();
  TypeParam taps[channel_count][7] = {};
  TypeParam work[7] = {};
  for (int channel = 0; channel < channel_count; ++channel) {
    const auto& gains = settings.gains[channel];
    fuse_taps(settings.generator, gains[0], gains[1], gains[2], settings.alpha[channel],
              settings.sigma[channel], settings.memory, taps[channel], work);
  }
  typename TestFixture::Controlled by_taps;
  by_taps.configure_structure(settings, {});
  by_taps.set_taps(taps[0], taps[1], taps[2], settings.memory + 2);
  typename TestFixture::Controlled by_gains;
  ASSERT_EQ(by_gains.configure(settings), Status::ok);
  this->expect_same_future(by_taps, by_gains, "taps");
}

TYPED_TEST(Configure, ResetRepeatsToTheBit) {
  typename TestFixture::Controlled fresh;
  ASSERT_EQ(fresh.configure(this->incremental()), Status::ok);
  auto used = this->running();
  used.reset();
  EXPECT_EQ(used.feedback().left, 0);
  EXPECT_EQ(used.feedback().right, 0);
  this->expect_same_future(used, fresh, "reset");
}

TYPED_TEST(Configure, DefaultsAreThePapers) {
  const ControllerSettings<TypeParam> settings;
  const double table3[3][3] = {
      {0.2797, 0.7614, 0.8477}, {0.7177, 0.2782, 0.3294}, {1.0707, 1.3720, 0.1827}};
  for (int channel = 0; channel < channel_count; ++channel) {
    for (int gain = 0; gain < 3; ++gain) {
      EXPECT_EQ(settings.gains[channel][gain], static_cast<TypeParam>(table3[channel][gain]));
    }
    EXPECT_EQ(settings.alpha[channel], static_cast<TypeParam>(0.1078));
    EXPECT_EQ(settings.sigma[channel], static_cast<TypeParam>(0.8161));
  }
  EXPECT_EQ(settings.memory, 5);
  EXPECT_EQ(settings.form, Form::positional);
  EXPECT_EQ(settings.activation, Activation::sigmoid);
  EXPECT_EQ(settings.frame, Frame::robot);
  EXPECT_EQ(settings.generator, Generator::tustin);
  EXPECT_EQ(settings.lateral, Lateral::direction);
  EXPECT_EQ(settings.anti_windup, AntiWindup::none);
}

}  // namespace
}  // namespace nfopidn::test
