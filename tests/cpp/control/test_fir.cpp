// The ring-memory filter against a plain convolution.
#include "nfopidn/control/tap_filter.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

template <class Kind>
struct Traits;
template <class Scalar, int Capacity, int Slack>
struct Traits<Fir<Scalar, Capacity, Slack>> {
  using Number = Scalar;
  static constexpr int slack = Slack;
};

template <class Filter>
class FirFilter : public ::testing::Test {
 protected:
  using Number = typename Traits<Filter>::Number;
  static constexpr int capacity = Filter::capacity;
  static constexpr int slack = Traits<Filter>::slack;
  // Long enough that the history moves several times.
  static constexpr int samples = 3 * (capacity + slack) + 40;
  using Taps = std::vector<Number>;

  Taps random_taps(int count) {
    Taps taps;
    for (int j = 0; j < count; ++j) taps.push_back(draw.scalar<Number>(-1, 1));
    return taps;
  }
  void use_random_taps(int count) {
    for (Taps& taps : all_taps) taps = random_taps(count);
    filter.set_taps(
        Channels<const Number*>{all_taps[0].data(), all_taps[1].data(), all_taps[2].data()},
        {scale[0], scale[1], scale[2]}, count);
  }
  Channels<Number> next_error() {
    const Channels<Number> error = {draw.scalar<Number>(-1, 1), draw.scalar<Number>(-1, 1),
                                    draw.scalar<Number>(-1, 1)};
    errors[0].push_back(error.x);
    errors[1].push_back(error.y);
    errors[2].push_back(error.theta);
    return error;
  }
  void expect_convolution(int channel, Number net) {
    const Taps& taps = all_taps[channel];
    const auto& past = errors[channel];
    Real sum = 0;
    for (std::size_t j = 0; j < taps.size() && j < past.size(); ++j) {
      sum += Real(taps[j]) * scale[channel] * past[past.size() - 1 - j];
    }
    const Real bound = 4 * unit<Number> * Real(taps.size() + 2);
    ASSERT_TRUE(near(net, sum, bound)) << "channel " << channel << " after " << past.size();
  }
  void run(int count) {
    for (int k = 0; k < count; ++k) {
      const Channels<Number> net = filter.step(next_error());
      expect_convolution(0, net.x);
      expect_convolution(1, net.y);
      expect_convolution(2, net.theta);
      if (this->HasFatalFailure()) return;
    }
  }

  Draws draw{21};
  Filter filter;
  Taps all_taps[channel_count];
  Number scale[channel_count] = {1, Number(0.5), -2};
  std::vector<Number> errors[channel_count];
};
using Filters =
    ::testing::Types<Fir<double, 2>, Fir<double, 2, 1>, Fir<double, 7>, Fir<double, 7, 3>,
                     Fir<float, 7, 4>, Fir<double, 10>, Fir<double, 10, 57>, Fir<float, 16, 2>,
                     Fir<double, 17>, Fir<double, 40, 5>, Fir<double, 300, 290>>;
TYPED_TEST_SUITE(FirFilter, Filters);

TYPED_TEST(FirFilter, IsAConvolution) {
  this->use_random_taps(TestFixture::capacity);
  this->run(TestFixture::samples);
}

TYPED_TEST(FirFilter, KnowsTheNewestErrors) {
  for (int k = 0; k < this->samples; ++k) {
    const auto error = this->next_error();
    this->filter.step(error);
    const auto newest = this->filter.newest();
    EXPECT_EQ(newest.x, error.x);
    EXPECT_EQ(newest.y, error.y);
    EXPECT_EQ(newest.theta, error.theta);
  }
}

TYPED_TEST(FirFilter, MayHaveFewerTapsThanItsCapacity) {
  this->use_random_taps(TestFixture::capacity);
  this->use_random_taps(2);  // the taps beyond go back to zero
  EXPECT_EQ(this->filter.count(), 2);
  this->run(TestFixture::samples);
}

TYPED_TEST(FirFilter, NewTapsKeepThePastErrors) {
  this->use_random_taps(2);
  this->run(TestFixture::capacity + TestFixture::slack / 2 + 3);
  this->use_random_taps(TestFixture::capacity);
  this->run(TestFixture::capacity + TestFixture::slack + 5);
  this->use_random_taps(TestFixture::capacity / 2 + 1);
  this->run(7);
}

TYPED_TEST(FirFilter, ShowsItsScaledTaps) {
  this->use_random_taps(TestFixture::capacity);
  EXPECT_EQ(this->filter.count(), TestFixture::capacity);
  for (int channel = 0; channel < channel_count; ++channel) {
    for (int j = 0; j < TestFixture::capacity; ++j) {
      const auto tap = this->all_taps[channel][static_cast<std::size_t>(j)];
      ASSERT_EQ(this->filter.tap(channel, j), tap * this->scale[channel]);
    }
  }
}

TYPED_TEST(FirFilter, ResetRepeatsToTheBit) {
  this->use_random_taps(TestFixture::capacity);
  std::vector<Channels<typename TestFixture::Number>> inputs;
  for (int k = 0; k < TestFixture::samples; ++k) inputs.push_back(this->next_error());
  std::vector<Channels<typename TestFixture::Number>> first;
  for (const auto& input : inputs) first.push_back(this->filter.step(input));
  this->filter.reset();
  for (std::size_t k = 0; k < inputs.size(); ++k) {
    ASSERT_TRUE(same_bits(this->filter.step(inputs[k]), first[k])) << "sample " << k;
  }
}

TYPED_TEST(FirFilter, ResetForgetsErrorsThatAreNotNumbers) {
  this->use_random_taps(TestFixture::capacity);
  constexpr auto nan = not_a_number<typename TestFixture::Number>;
  for (int k = 0; k < TestFixture::capacity; ++k) this->filter.step({nan, nan, nan});
  this->filter.reset();
  this->run(TestFixture::capacity + TestFixture::slack + 3);
}

TYPED_TEST(FirFilter, IsSilentBeforeItHasTaps) {
  const auto net = this->filter.step({1, 2, 3});
  EXPECT_EQ(net.x, 0);
  EXPECT_EQ(net.y, 0);
  EXPECT_EQ(net.theta, 0);
  EXPECT_EQ(this->filter.count(), 2);
}

// What a microcontroller has to keep: taps, the past errors, two numbers.
TEST(FirSize, IsTheLeastThereCanBe) {
  EXPECT_EQ(sizeof(Fir<float, 7>), 3 * (7 + 6) * sizeof(float) + 2 * sizeof(int));
  EXPECT_EQ(sizeof(Fir<float, 7, 3>), 3 * (7 + 7 + 3) * sizeof(float) + 2 * sizeof(int));
}

}  // namespace
}  // namespace nfopidn::test
