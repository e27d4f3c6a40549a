// Normal numbers by counter: pinned words, the method's own formula by libm, and the distribution.
#include <cmath>

#include "nfopidn/math/counter_noise.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

// The published outputs of SplitMix64 for the seed 1234567.
TEST(CounterNoise, MixesAsSplitMix64) {
  std::uint64_t state = 1234567;
  for (const std::uint64_t output :
       {6457827717110365317U, 3203168211198807973U, 9817491932198370423U, 4593380528125082431U,
        16408922859458223821U}) {
    state += counter_noise::golden;
    EXPECT_EQ(counter_noise::mixed<std::uint64_t>(state, 0), output);
  }
}

// Box and Muller's formula from the same bits.
TEST(CounterNoise, IsBoxAndMullersMethod) {
  const std::uint64_t seed = 99;
  const counter_noise::Key key(seed);
  const CounterNoise noise(seed);
  for (std::uint64_t pair = 0; pair < 20000; ++pair) {
    const std::uint64_t bits = counter_noise::pair_bits(key.first, key.second, pair);
    const double uniform = (std::ldexp(static_cast<double>(bits >> 32), 0) + 0.5) * 0x1p-32;
    const double part = (static_cast<double>(bits & 0x7FFFFFFF) + 0.5) * 0x1p-31 - 0.5;
    const bool turned = (bits >> 31 & 1) != 0;
    const double radius = std::sqrt(-2 * std::log(uniform)) * (turned ? -1 : 1);
    const double pi = std::acos(-1.0);
    EXPECT_NEAR(noise.normal(2 * pair), radius * std::cos(pi * part), 1e-9);
    EXPECT_NEAR(noise.normal(2 * pair + 1), radius * std::sin(pi * part), 1e-9);
  }
}

TEST(CounterNoise, IsStandardNormal) {
  const CounterNoise noise(5);
  constexpr int count = 400000;
  std::vector<double> draws(count);
  for (int i = 0; i < count; ++i) draws[i] = noise.normal(static_cast<std::uint64_t>(i));
  double sum = 0, square = 0, fourth = 0, neighbours = 0;
  for (int i = 0; i < count; ++i) {
    const double x = draws[i];
    sum += x;
    square += x * x;
    fourth += x * x * x * x;
    if (i > 0) neighbours += x * draws[i - 1];
  }
  // Five standard errors each.
  const double error = 5 / std::sqrt(count);
  EXPECT_NEAR(sum / count, 0, error);
  EXPECT_NEAR(square / count, 1, error * std::sqrt(2.0));
  EXPECT_NEAR(fourth / count, 3, error * std::sqrt(96.0));
  EXPECT_NEAR(neighbours / count, 0, error);
  // Kolmogorov and Smirnov's distance; 1.95/sqrt(n) at a level of 0.1 %.
  std::sort(draws.begin(), draws.end());
  double distance = 0;
  for (int i = 0; i < count; ++i) {
    const double share = 0.5 * std::erfc(-draws[i] / std::sqrt(2.0));
    distance = std::max({distance, std::fabs(share - static_cast<double>(i) / count),
                         std::fabs(share - static_cast<double>(i + 1) / count)});
  }
  EXPECT_LT(distance, 1.95 / std::sqrt(count));
}

// Runs' seeds are neighbours: their noise must not be.
TEST(CounterNoise, OfNeighbouringSeedsIsUnrelated) {
  constexpr int count = 100000;
  for (const std::uint64_t apart : {1U, 2U, 1024U}) {
    double related = 0;
    for (std::uint64_t run = 0; run < 100; ++run) {
      const CounterNoise one(run), other(run + apart);
      for (std::uint64_t i = 0; i < count / 100; ++i) related += one.normal(i) * other.normal(i);
    }
    EXPECT_NEAR(related / count, 0, 5 / std::sqrt(count)) << apart;
  }
}

}  // namespace
}  // namespace nfopidn::test
