// Long memory as modes: against the plain sums.
#include <gtest/gtest.h>

#include <random>

#include "nfopidn/analysis/conversion.hpp"
#include "nfopidn/analysis/rational.hpp"
#include "nfopidn/simulation/simulate.hpp"
#include "support.hpp"

namespace nfopidn {
namespace {

using test::Draws;
using test::Real;

std::vector<double> noise(int count) {
  std::mt19937 engine(7);
  std::vector<double> samples(static_cast<std::size_t>(count));
  for (double& sample : samples) sample = static_cast<double>(engine() >> 8) / 8388608.0 - 1;
  return samples;
}

// sum_j c_j u_{k-j}, j up to memory.
long double direct(const std::vector<double>& weights, const std::vector<double>& samples, int k) {
  long double sum = 0;
  for (int j = 0; j < static_cast<int>(weights.size()) && j <= k; ++j) {
    sum += static_cast<long double>(weights[static_cast<std::size_t>(j)]) *
           samples[static_cast<std::size_t>(k - j)];
  }
  return sum;
}

class SeriesFilter : public testing::TestWithParam<std::tuple<double, double, int>> {};

TEST_P(SeriesFilter, EqualsThePlainSum) {
  const auto [order, pole, memory] = GetParam();
  std::vector<double> weights(static_cast<std::size_t>(memory) + 1);
  series_weights(pole, order, memory, weights.data());
  double total = 0;
  for (const double weight : weights) total += std::abs(weight);
  const std::vector<double> samples = noise(3 * memory);
  FractionalFilter filter(order, {pole, 1, 0}, memory);
  for (int k = 0; k < static_cast<int>(samples.size()); ++k) {
    const double out = filter.step(samples[static_cast<std::size_t>(k)]) / filter.gain();
    if (k % 37 != 0 && k != memory && k != memory + 1) continue;
    const auto wanted = static_cast<double>(direct(weights, samples, k));
    ASSERT_NEAR(out, wanted, 1e-12 * total) << k;
  }
}
INSTANTIATE_TEST_SUITE_P(Orders, SeriesFilter,
                         testing::Combine(testing::Values(0.5, -0.3, 0.97, -0.999),
                                          testing::Values(1.0, 0.0, 1.0 / 7),
                                          testing::Values(0, 1, 40, 192, 193, 500, 1001)));

TEST(FractionalFilter, IsCertifiedOverItsHorizon) {
  for (const double order : {0.01, 0.5, 0.99, -0.5, -0.9999}) {
    for (const double pole : {1.0, 0.0, 1.0 / 7}) {
      const FractionalFilter filter(order, {pole, 1, 0}, infinite_memory, 50'000);
      EXPECT_LT(filter.certificate(), 1e-12) << order << " " << pole;
      EXPECT_LE(filter.kernel().mode_count(), 160);
      EXPECT_GT(filter.kernel().mode_count(), 20);
    }
  }
}

TEST(FractionalFilter, RunsTheWholePartOfAnOrderAsARecursion) {
  const std::vector<double> samples = noise(300);
  for (const double whole : {1.0, -1.0}) {
    FractionalFilter both(whole * 1.4, {1, 0.1, 0}, infinite_memory);
    FractionalFilter rest(whole * 0.4, {1, 0.1, 0}, infinite_memory);
    FractionalFilter one(whole, {1, 0.1, 0}, infinite_memory);
    double scale = 0;
    for (const double sample : samples) {
      const double wanted = one.step(rest.step(sample));
      scale = std::max(scale, std::abs(wanted));
      EXPECT_NEAR(both.step(sample), wanted, 1e-13 * scale);
    }
  }
}

TEST(FractionalFilter, WholeOrdersAreTheRule) {
  const double dt = 0.1;
  FractionalFilter difference(1, {0, dt, 0}, 5);
  FractionalFilter sum(-1, {1, dt, 0}, 5);
  FractionalFilter nothing(0, {1, dt, 0}, 5);
  double last = 0;
  double area = 0;
  for (const double sample : noise(50)) {
    area += dt * (sample + last) / 2;  // trapezoids, from a sample of 0
    EXPECT_NEAR(difference.step(sample), (sample - last) / dt, 1e-12);
    EXPECT_NEAR(sum.step(sample), area, 1e-12);
    EXPECT_EQ(nothing.step(sample), sample);
    last = sample;
  }
}

TEST(FractionalFilter, ResetForgets) {
  FractionalFilter filter(0.5, {1, 1, 0}, infinite_memory);
  const std::vector<double> samples = noise(100);
  std::vector<double> first;
  for (const double sample : samples) first.push_back(filter.step(sample));
  filter.reset();
  for (std::size_t i = 0; i < samples.size(); ++i) EXPECT_EQ(filter.step(samples[i]), first[i]);
}

// Sums of every length up to the longest, in both widths and term by term.
TEST(WideLoops, GiveTheSameBitsInEveryWidth) {
  Draws draws(11);
  std::vector<double> a(200), b(200);
  for (double& number : a) number = draws.between(-1, 1);
  for (double& number : b) number = draws.between(-1, 1);
  for (long count = 0; count <= 192; count += 8) {
    for (long shift : {0L, 1L, 5L}) {
      const double fastest = wide::loops().dot(a.data(), b.data() + shift, count);
      EXPECT_EQ(wide::plain.dot(a.data(), b.data() + shift, count), fastest);
      Real sum = 0;
      for (long i = 0; i < count; ++i) {
        sum += Real(a[static_cast<std::size_t>(i)]) * b[static_cast<std::size_t>(i + shift)];
      }
      EXPECT_TRUE(test::near(fastest, sum, 1e-14L));
    }
  }
}

TEST(WideLoops, AdvanceModesAlikeInEveryWidth) {
  Draws draws(12);
  std::vector<wide::Modes> one(5);
  for (wide::Modes& block : one) {
    for (std::size_t k = 0; k < 8; ++k) {
      block.decay[k] = draws.between(0, 1);
      block.residue[k] = draws.between(-1, 1);
      block.end[k] = draws.between(-1, 1);
      block.state[k] = draws.between(-1, 1);
    }
  }
  std::vector<wide::Modes> other = one;
  const std::vector<wide::Modes> before = one;
  const double sum = wide::loops().advance(one.data(), 5, 2, 0.3, -0.7);
  EXPECT_EQ(wide::plain.advance(other.data(), 5, 2, 0.3, -0.7), sum);
  Real total = 0;
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t k = 0; k < 8; ++k) {
      EXPECT_EQ(one[i].state[k], other[i].state[k]);
      const wide::Modes& m = before[i];
      const Real leaving = i < 2 ? -0.7L * m.end[k] : 0;
      const Real expected = (1 - Real(m.decay[k])) * m.state[k] + 0.3L * m.residue[k] - leaving;
      EXPECT_TRUE(test::near(one[i].state[k], expected, 1e-15L));
      total += expected;
    }
  }
  EXPECT_TRUE(test::near(sum, total, 1e-14L));
}

TEST(LongController, EqualsThePlainFilter) {
  const Scenario scenario = Scenario::published();
  const PreparedRun run = prepare(scenario);
  const auto ignore = [](int, auto&&...) {};
  for (const Generator generator : {Generator::tustin, Generator::gl}) {
    for (const int memory : {193, 300, 301}) {  // the run's 751 samples go past their ends
      ControllerDesign design;
      design.generator = generator;
      design.memory = memory;
      LongController law = long_controller(design, run.limits);
      const auto result = run_closed_loop<double>(run.plant, law, run.start, run.inputs(), ignore);
      const double plain = simulate(scenario, design).metrics.cost;
      EXPECT_NEAR(result.cost, plain, 1e-12 * plain) << memory;
    }
  }
}

TEST(LongController, ServesMemoriesThatNoPlainFilterHolds) {
  const Scenario scenario = Scenario::published();
  ControllerDesign design;
  design.memory = 1000;  // longer than the run
  const double plain = simulate(scenario, design).metrics.cost;
  for (const int memory : {maximum_memory + 1, 100'000, infinite_memory}) {
    design.memory = memory;
    EXPECT_NEAR(simulate(scenario, design).metrics.cost, plain, 1e-12) << memory;
  }
}

TEST(ContinuedFraction, AgreesWithTheSeriesWhereThatConverges) {
  const double w = 0.3;  // 1/z
  for (const double order : {0.5, -0.7, 1.5, -1.2}) {
    for (const double pole : {1.0, 1.0 / 7}) {
      const ZerosPoles model = continued_fraction(order, {pole, 1, 0}, 12);
      double value = model.gain;
      for (const double zero : model.zeros) value *= 1 / w - zero;
      for (const double root : model.poles) value /= 1 / w - root;
      const double wanted = std::pow((1 + pole) * (1 - w) / (1 + pole * w), order);
      EXPECT_NEAR(value, wanted, 1e-12) << order << " " << pole;
    }
  }
}

// eq. 25
TEST(GainFactors, AreThoseOfEq25) {
  const auto tustin = gain_factors(Generator::tustin, 0.1078, 0.8161, 0.2);
  const double scale = 15 / std::tan(1.5);
  EXPECT_NEAR(tustin[1], std::pow(scale, -0.8161), 1e-14);
  EXPECT_NEAR(tustin[2], std::pow(scale, 0.1078), 1e-14);
  EXPECT_EQ(tustin[0], 1);
  EXPECT_NEAR(gain_factors(Generator::gl, 1, 1, 0.2)[2], 5, 1e-14);
}

TEST(Memory, InfinityIsWithinEveryRange) {
  ControllerSettings<double> settings;
  settings.memory = infinite_memory;
  EXPECT_EQ(settings.validate(), Status::ok);
  settings.memory = maximum_long_memory + 1;
  EXPECT_EQ(settings.validate(), Status::out_of_range);
  settings.memory = -1;
  EXPECT_EQ(settings.validate(), Status::out_of_range);
}

}  // namespace
}  // namespace nfopidn
