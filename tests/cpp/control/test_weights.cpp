// The generating functions' weights and their fusion into taps.
#include "nfopidn/control/operator_weights.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

constexpr double some_orders[] = {-1.5, -1, -0.8161, -0.5, 0, 0.1078, 0.1839, 0.5, 1, 1.37, 2};

template <class Scalar>
class Weights : public ::testing::Test {
 protected:
  static std::vector<Scalar> of(Generator generator, Scalar order, int memory) {
    std::vector<Scalar> weights(static_cast<std::size_t>(memory) + 1);
    generator_weights(generator, order, memory, weights.data());
    return weights;
  }
};
TYPED_TEST_SUITE(Weights, Scalars);

// eqs. 16-19
TEST(TustinWeights, EqualTheGoldenOnes) {
  const CsvTable golden = read_golden_csv("weights.csv");
  ASSERT_EQ(golden.names, (std::vector<std::string>{"order", "j", "f_j"}));
  ASSERT_GT(golden.rows.size(), 100U);
  std::map<double, std::vector<double>> series;
  for (const auto& row : golden.rows) {
    auto& weights = series[row[0]];
    ASSERT_EQ(row[1], static_cast<double>(weights.size()));
    weights.push_back(row[2]);
  }
  for (const auto& [order, expected] : series) {
    std::vector<double> weights(expected.size());
    series_weights(1.0, order, static_cast<int>(expected.size()) - 1, weights.data());
    for (std::size_t j = 0; j < expected.size(); ++j) {
      const double scale = expected[j] == 0 ? 1 : std::fabs(expected[j]);
      EXPECT_LE(std::fabs(weights[j] - expected[j]), 1e-13 * scale)
          << "order " << order << ", j " << j;
    }
  }
}

TYPED_TEST(Weights, EqualTheirClosedForms) {
  constexpr int memory = 40;
  for (const Generator generator : {Generator::tustin, Generator::gl}) {
    for (const double any_order : some_orders) {
      const auto order = static_cast<TypeParam>(any_order);
      const auto weights = this->of(generator, order, memory);
      for (int j = 0; j <= memory; ++j) {
        const Real expected = literal_weight(generator, order, j);
        EXPECT_TRUE(
            near(weights[static_cast<std::size_t>(j)], expected,
                 Real(j + 1) * 2 * unit<TypeParam> * std::max(Real(1), std::fabs(expected))))
            << any_order << ", j " << j;
      }
    }
  }
}

TYPED_TEST(Weights, OppositeOrdersConvolveToOne) {
  constexpr int memory = 30;
  for (const Generator generator : {Generator::tustin, Generator::gl}) {
    for (const double order : some_orders) {
      const auto plus = this->of(generator, static_cast<TypeParam>(order), memory);
      const auto minus = this->of(generator, static_cast<TypeParam>(-order), memory);
      for (std::size_t j = 0; j < plus.size(); ++j) {
        Real sum = 0;
        Real size = 0;
        for (std::size_t i = 0; i <= j; ++i) {
          const Real term = Real(plus[i]) * minus[j - i];
          sum += term;
          size += std::fabs(term);
        }
        EXPECT_TRUE(near(sum, j == 0 ? 1 : 0, 30 * unit<TypeParam> * size)) << order << ", j " << j;
      }
    }
  }
}

TYPED_TEST(Weights, WholeOrders) {
  using Series = std::vector<TypeParam>;
  EXPECT_EQ(this->of(Generator::tustin, 0, 4), (Series{1, 0, 0, 0, 0}));
  EXPECT_EQ(this->of(Generator::gl, 0, 4), (Series{1, 0, 0, 0, 0}));
  EXPECT_EQ(this->of(Generator::tustin, 1, 4), (Series{1, -2, 2, -2, 2}));
  EXPECT_EQ(this->of(Generator::gl, 1, 4), (Series{1, -1, 0, 0, 0}));
  EXPECT_EQ(this->of(Generator::gl, -1, 4), (Series{1, 1, 1, 1, 1}));
  EXPECT_EQ(this->of(Generator::gl, 2, 4), (Series{1, -2, 1, 0, 0}));
  EXPECT_EQ(this->of(Generator::tustin, 1, 0), (Series{1}));
  EXPECT_EQ(this->of(Generator::gl, 1, 0), (Series{1}));
}

TYPED_TEST(Weights, NothingIsWrittenPastTheMemory) {
  const auto order = static_cast<TypeParam>(0.3);
  for (const int memory : {0, 1, 2, 5}) {
    for (const Generator generator : {Generator::tustin, Generator::gl}) {
      std::vector<TypeParam> weights(10, TypeParam(77));
      generator_weights(generator, order, memory, weights.data());
      for (auto j = static_cast<std::size_t>(memory) + 1; j < weights.size(); ++j) {
        EXPECT_EQ(weights[j], TypeParam(77)) << "memory " << memory << ", j " << j;
      }
      std::vector<TypeParam> taps(10, TypeParam(77));
      fuse_taps<TypeParam>(generator, 1, 1, 1, order, order, memory, taps.data(), weights.data());
      for (auto j = static_cast<std::size_t>(memory) + 2; j < taps.size(); ++j) {
        EXPECT_EQ(taps[j], TypeParam(77)) << "memory " << memory << ", j " << j;
      }
    }
  }
}

// eq. 34
TYPED_TEST(Weights, FusedTapsEqualTheThreeSums) {
  Draws draw(11);
  for (const Generator generator : {Generator::tustin, Generator::gl}) {
    for (const int memory : {0, 1, 2, 5, 8, 40}) {
      for (int run = 0; run < 4; ++run) {
        TypeParam gains[3];
        for (TypeParam& gain : gains) gain = draw.scalar<TypeParam>(-3, 3);
        const TypeParam alpha = draw.scalar<TypeParam>(-1, 2);
        const TypeParam sigma = draw.scalar<TypeParam>(-1, 2);
        const auto size = static_cast<std::size_t>(memory) + 2;
        std::vector<TypeParam> taps(size, TypeParam(77));  // the taps are written, not added to
        std::vector<TypeParam> work(size);
        fuse_taps(generator, gains[0], gains[1], gains[2], alpha, sigma, memory, taps.data(),
                  work.data());
        std::vector<Real> errors;
        for (int k = 0; k < memory + 12; ++k) {
          errors.push_back(draw.between(-1, 1));
          Real filtered = 0;
          for (std::size_t j = 0; j < size && j < errors.size(); ++j) {
            filtered += taps[j] * errors[errors.size() - 1 - j];
          }
          const Real expected = literal_net(generator, gains, alpha, sigma, memory, errors);
          ASSERT_TRUE(near(filtered, expected, Real(memory + 5) * 60 * unit<TypeParam>))
              << "memory " << memory << ", k " << k;
        }
      }
    }
  }
}

}  // namespace
}  // namespace nfopidn::test
