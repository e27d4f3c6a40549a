// Random draws: the same everywhere, and of the right distribution.
#include <random>

#include "nfopidn/math/random.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

// From an implementation of the 64-bit Mersenne twister of its own, in Python.
TEST(RandomDraws, ArePinned) {
  const std::map<std::uint64_t, std::vector<double>> pinned = {
      {0, {0.1597933633704608, 0.9921452096298288, 0.03956902584486566, 0.5974946626946717}},
      {1, {0.13387664401253263, 0.13640703636619722, 0.4512149038445381, 0.02102422841672702}},
      {12345, {0.35762972288842587, 0.40044261704406114, 0.6893833170027684, 0.5597355706411156}}};
  for (const auto& [seed, draws] : pinned) {
    Random random(seed);
    for (const double draw : draws) EXPECT_EQ(random.uniform(), draw) << "seed " << seed;
  }
  Random random(7);
  for (const double draw :
       {1.5913998756469563, 0.3889032347053571, 0.5191723646028278, 1.5343549480559588}) {
    EXPECT_NEAR(random.normal(), draw, 1e-14);
  }
}

// Blocks of 312 and the turns from one to the next.
TEST(RandomDraws, AreThoseOfTheStandardLibrarysTwister) {
  for (const std::uint64_t seed : {std::uint64_t{0}, std::uint64_t{5489}, ~std::uint64_t{0}}) {
    MersenneTwister own(seed);
    std::mt19937_64 standard(seed);
    for (int i = 0; i < 2000; ++i) ASSERT_EQ(own(), standard()) << "seed " << seed << ", " << i;
  }
}

TEST(RandomDraws, SeedsRepeatAndDiffer) {
  Random a(3);
  Random b(3);
  Random c(4);
  int same = 0;
  for (int i = 0; i < 100; ++i) {
    const double draw = a.normal();
    EXPECT_EQ(draw, b.normal());
    same += draw == c.normal() ? 1 : 0;
  }
  EXPECT_EQ(same, 0);
}

TEST(RandomDraws, UniformFillsItsInterval) {
  Random random(5);
  constexpr int count = 100'000;
  double sum = 0;
  double square = 0;
  double least = 1;
  double most = 0;
  for (int i = 0; i < count; ++i) {
    const double draw = random.uniform();
    ASSERT_GE(draw, 0);
    ASSERT_LT(draw, 1);
    sum += draw;
    square += draw * draw;
    least = std::min(least, draw);
    most = std::max(most, draw);
  }
  // Four standard errors.
  EXPECT_NEAR(sum / count, 0.5, 4 * std::sqrt(1.0 / 12 / count));
  EXPECT_NEAR(square / count, 1.0 / 3, 4 * std::sqrt(4.0 / 45 / count));
  EXPECT_LT(least, 2e-4);
  EXPECT_GT(most, 1 - 2e-4);
}

TEST(RandomDraws, UniformBetweenBounds) {
  Random unit_draws(6);
  Random draws(6);
  for (int i = 0; i < 100; ++i) {
    EXPECT_NEAR(draws.uniform(-3, 5), -3 + 8 * unit_draws.uniform(), 1e-15);
  }
}

TEST(RandomDraws, NormalHasMeanZeroAndVarianceOne) {
  Random random(8);
  constexpr int count = 200'000;
  double moments[5] = {};
  int beyond_two = 0;
  for (int i = 0; i < count; ++i) {
    const double draw = random.normal();
    double power = 1;
    for (double& moment : moments) {
      moment += power / count;
      power *= draw;
    }
    beyond_two += std::fabs(draw) > 2 ? 1 : 0;
  }
  // Four standard errors.
  EXPECT_NEAR(moments[1], 0, 4 * std::sqrt(1.0 / count));
  EXPECT_NEAR(moments[2], 1, 4 * std::sqrt(2.0 / count));
  EXPECT_NEAR(moments[3], 0, 4 * std::sqrt(15.0 / count));
  EXPECT_NEAR(moments[4], 3, 4 * std::sqrt(96.0 / count));
  EXPECT_NEAR(static_cast<double>(beyond_two) / count, 0.0455, 0.002);
}

TEST(RandomDraws, BellHasMeanZeroAndVarianceOne) {
  Random random(9);
  constexpr int count = 200'000;
  double mean = 0, square = 0, fourth = 0, most = 0;
  for (int i = 0; i < count; ++i) {
    const double draw = random.bell();
    mean += draw / count;
    square += draw * draw / count;
    fourth += draw * draw * draw * draw / count;
    most = std::max(most, std::fabs(draw));
  }
  // Four standard errors. A sum of four uniform numbers has a fourth moment of 2.7.
  EXPECT_NEAR(mean, 0, 4 * std::sqrt(1.0 / count));
  EXPECT_NEAR(square, 1, 4 * std::sqrt(1.7 / count));
  EXPECT_NEAR(fourth, 2.7, 0.1);
  EXPECT_LT(most, 3.465);
}

TEST(RandomDraws, PairsAreUniformAndIndependent) {
  Random random(10);
  constexpr int count = 84'000;
  int seen[3][7] = {};
  for (int i = 0; i < count; ++i) {
    const auto [a, b] = random.pair(3, 7);
    ASSERT_TRUE(a >= 0 && a < 3 && b >= 0 && b < 7) << a << " " << b;
    ++seen[a][b];
  }
  for (const auto& row : seen) {
    for (const int times : row) EXPECT_NEAR(times, count / 21, 5 * std::sqrt(count / 21.0));
  }
}

}  // namespace
}  // namespace nfopidn::test
