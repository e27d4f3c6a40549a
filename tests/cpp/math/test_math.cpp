// The kernels against the C library in long double.
#include "nfopidn/math/math.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

// Errors up to `bound` units in the last place of 1, for arguments up to `range`.
struct Band {
  double range;
  Real bound;
};

template <class Scalar>
class Math : public ::testing::Test {
 protected:
  static constexpr bool is_double = std::is_same_v<Scalar, double>;
  static constexpr int count = 50'000;

  // What separates two angles on the circle; the C library reduces any angle exactly.
  static Real separation(Scalar a, Scalar b) {
    const Real p = a;
    const Real q = b;
    return std::fabs(std::atan2(std::sin(p) * std::cos(q) - std::cos(p) * std::sin(q),
                                std::cos(p) * std::cos(q) + std::sin(p) * std::sin(q)));
  }
};
TYPED_TEST_SUITE(Math, Scalars);

TYPED_TEST(Math, HeadingIsCosineAndSine) {
  Draws draw(1);
  const std::vector<Band> bands =
      TestFixture::is_double
          ? std::vector<Band>{{0.8, 1.2L}, {4, 1.2L}, {1000, 1.2L}, {1.6e6, 1.2L}}
          : std::vector<Band>{{0.8, 1.1L}, {4, 1.1L}, {100, 1.1L}, {1e4, 1.6L}, {1e5, 10}};
  for (const Band& band : bands) {
    Real worst = 0;
    for (int i = 0; i < TestFixture::count; ++i) {
      const TypeParam angle = draw.scalar<TypeParam>(-band.range, band.range);
      const Heading<TypeParam> heading = math<TypeParam>::heading(angle);
      worst = std::max(worst, std::fabs(heading.cosine - std::cos(Real(angle))));
      worst = std::max(worst, std::fabs(heading.sine - std::sin(Real(angle))));
    }
    EXPECT_LE(worst, band.bound * unit<TypeParam>) << "range " << band.range;
  }
}

TYPED_TEST(Math, SmallSinesAreRelativelyAccurate) {
  Draws draw(2);
  for (int i = 0; i < TestFixture::count; ++i) {
    const TypeParam angle = static_cast<TypeParam>(std::pow(10.0, draw.between(-20, -0.2)));
    const Real sine = std::sin(Real(angle));
    ASSERT_LE(std::fabs(math<TypeParam>::heading(angle).sine - sine), 1.5L * unit<TypeParam> * sine)
        << angle;
  }
}

TYPED_TEST(Math, HeadingIsEvenAndOddToTheBit) {
  Draws draw(3);
  for (int i = 0; i < TestFixture::count; ++i) {
    const TypeParam angle = draw.scalar<TypeParam>(-50, 50);
    const Heading<TypeParam> plus = math<TypeParam>::heading(angle);
    const Heading<TypeParam> minus = math<TypeParam>::heading(-angle);
    ASSERT_EQ(plus.cosine, minus.cosine) << angle;
    ASSERT_EQ(plus.sine, -minus.sine) << angle;
  }
}

// The quarter turn of the call before is only a hint: whatever it was, the result is the same.
TYPED_TEST(Math, HeadingDoesNotDependOnTheOneBefore) {
  using M = math<TypeParam>;
  Draws draw(11);
  TypeParam quarter = M::Constants::round_magic;
  TypeParam angle = 0;
  for (int i = 0; i < TestFixture::count; ++i) {
    const bool far = i % 16 == 0;
    angle = far ? draw.scalar<TypeParam>(-1000, 1000) : angle + draw.scalar<TypeParam>(-1, 1);
    const Heading<TypeParam> expected = M::heading(angle);
    const Heading<TypeParam> hinted = M::heading(angle, quarter);
    ASSERT_EQ(hinted.cosine, expected.cosine) << angle;
    ASSERT_EQ(hinted.sine, expected.sine) << angle;
  }
  for (const TypeParam bad : {infinite<TypeParam>, not_a_number<TypeParam>}) {
    EXPECT_TRUE(std::isnan(M::heading(bad, quarter).cosine));
    EXPECT_EQ(M::heading(TypeParam(0.5), quarter).sine, M::heading(TypeParam(0.5)).sine);
  }
}

TYPED_TEST(Math, SmallNetsAreRelativelyAccurate) {
  Draws draw(12);
  for (int i = 0; i < TestFixture::count; ++i) {
    const TypeParam net = static_cast<TypeParam>(std::pow(10.0, draw.between(-20, -0.47)));
    const Real expected = std::tanh(Real(net) / 2);
    ASSERT_LE(std::fabs(math<TypeParam>::sigmoid(net) - expected),
              3 * unit<TypeParam> * std::fabs(expected))
        << net;
    ASSERT_EQ(math<TypeParam>::sigmoid(-net), -math<TypeParam>::sigmoid(net)) << net;
  }
}

TYPED_TEST(Math, SigmoidIsTanhOfHalfTheNet) {
  // The float's straight line has a rounding or two more than the double's branches.
  const Real bound = TestFixture::is_double ? 1.4L : 2.3L;
  Draws draw(4);
  for (const double range : {0.01, 1.0, 20.0, 100.0}) {
    Real worst = 0;
    for (int i = 0; i < TestFixture::count; ++i) {
      const TypeParam net = draw.scalar<TypeParam>(-range, range);
      worst = std::max(worst, std::fabs(math<TypeParam>::sigmoid(net) - std::tanh(Real(net) / 2)));
    }
    EXPECT_LE(worst, bound * unit<TypeParam>) << "range " << range;
  }
  EXPECT_EQ(math<TypeParam>::sigmoid(0), TypeParam(0));
  for (const TypeParam net : {TypeParam(45), TypeParam(1e9), std::numeric_limits<TypeParam>::max(),
                              infinite<TypeParam>}) {
    EXPECT_EQ(math<TypeParam>::sigmoid(net), TypeParam(1)) << net;
    EXPECT_EQ(math<TypeParam>::sigmoid(-net), TypeParam(-1)) << net;
  }
}

// The roundings of log2 e and of its product with the argument are all that grows with it.
TYPED_TEST(Math, ExponentialIsRelativelyAccurate) {
  using M = math<TypeParam>;
  Draws draw(8);
  for (const double range : {0.1, 3.0, 80.0, TestFixture::is_double ? 700.0 : 85.0}) {
    for (int i = 0; i < TestFixture::count; ++i) {
      const TypeParam exponent = draw.scalar<TypeParam>(-range, range);
      const Real exact = std::exp(Real(exponent));
      const Real bound = (2 + std::fabs(Real(exponent))) * unit<TypeParam>;
      ASSERT_LE(std::fabs(M::exponential(exponent) / exact - 1), bound) << exponent;
    }
  }
  EXPECT_EQ(M::exponential(0), TypeParam(1));
  // Beyond the range of normal numbers it stays at the last of them.
  EXPECT_GT(M::exponential(infinite<TypeParam>), std::numeric_limits<TypeParam>::max() / 100);
  EXPECT_TRUE(M::is_finite(M::exponential(infinite<TypeParam>)));
  EXPECT_GT(M::exponential(-infinite<TypeParam>), TypeParam(0));
  EXPECT_LT(M::exponential(-infinite<TypeParam>), std::numeric_limits<TypeParam>::min() * 100);
  EXPECT_TRUE(std::isnan(M::exponential(not_a_number<TypeParam>)));
}

TYPED_TEST(Math, LogIsRelativelyAccurate) {
  Draws draw(5);
  const double decades = TestFixture::is_double ? 307 : 37;
  for (const double range : {0.1, 3.0, decades}) {
    Real worst = 0;
    for (int i = 0; i < TestFixture::count; ++i) {
      const auto value = static_cast<TypeParam>(std::pow(10.0, draw.between(-range, range)));
      const Real exact = std::log(Real(value));
      if (exact == 0) continue;
      worst = std::max(worst, std::fabs((math<TypeParam>::log(value) - exact) / exact));
    }
    EXPECT_LE(worst, 2.8L * unit<TypeParam>) << "decades " << range;
  }
  EXPECT_EQ(math<TypeParam>::log(1), TypeParam(0));
}

TYPED_TEST(Math, AngleOfIsAtan2) {
  Draws draw(6);
  Real worst = 0;
  for (int i = 0; i < TestFixture::count; ++i) {
    const auto size = [&] { return std::pow(10.0, draw.between(-9, 9)); };
    const auto x = static_cast<TypeParam>(draw.between(-1, 1) < 0 ? -size() : size());
    const auto y = static_cast<TypeParam>(draw.between(-1, 1) < 0 ? -size() : size());
    const Real exact = std::atan2(Real(y), Real(x));
    worst = std::max(worst, std::fabs((math<TypeParam>::angle_of(y, x) - exact) / exact));
  }
  for (int degree = 1; degree < 360; ++degree) {  // sizes alike, so every branch
    const auto x = static_cast<TypeParam>(std::cos(degree * pi / 180));
    const auto y = static_cast<TypeParam>(std::sin(degree * pi / 180));
    const Real exact = std::atan2(Real(y), Real(x));
    worst = std::max(worst, std::fabs((math<TypeParam>::angle_of(y, x) - exact) / exact));
  }
  EXPECT_LE(worst, 2.2L * unit<TypeParam>);
}

TYPED_TEST(Math, AngleOfTheAxes) {
  using M = math<TypeParam>;
  EXPECT_EQ(M::angle_of(0, 0), TypeParam(0));
  EXPECT_EQ(M::angle_of(0, 2), TypeParam(0));
  EXPECT_EQ(M::angle_of(2, 0), M::pi / 2);
  EXPECT_EQ(M::angle_of(0, -2), M::pi);
  EXPECT_EQ(M::angle_of(-2, 0), -M::pi / 2);
  EXPECT_EQ(M::angle_of(1, infinite<TypeParam>), TypeParam(0));
  EXPECT_EQ(M::angle_of(1, -infinite<TypeParam>), M::pi);
  EXPECT_EQ(M::angle_of(infinite<TypeParam>, 1), M::pi / 2);
  EXPECT_EQ(M::angle_of(-infinite<TypeParam>, 1), -M::pi / 2);
}

TYPED_TEST(Math, WrapAtItsEnds) {
  using M = math<TypeParam>;
  EXPECT_EQ(M::wrap(0), TypeParam(0));
  EXPECT_EQ(M::wrap(-M::pi), -M::pi);
  EXPECT_EQ(M::wrap(M::pi), -M::pi);
  const TypeParam inside = std::nextafter(M::pi, TypeParam(0));
  EXPECT_EQ(M::wrap(inside), inside);
  EXPECT_EQ(M::wrap(-inside), -inside);
  TypeParam outside = M::pi;
  for (int steps = 0; steps < 8; ++steps) {
    outside = std::nextafter(outside, infinite<TypeParam>);
    for (const TypeParam angle : {outside, -outside}) {
      const TypeParam wrapped = M::wrap(angle);
      EXPECT_GE(wrapped, -M::pi) << steps;
      EXPECT_LT(wrapped, M::pi) << steps;
      EXPECT_LE(TestFixture::separation(angle, wrapped), 2 * unit<TypeParam>) << steps;
    }
  }
  EXPECT_LT(M::wrap(outside), 0);
  EXPECT_GT(M::wrap(-outside), 0);
}

TYPED_TEST(Math, WrapKeepsTheAngleAndItsInterval) {
  using M = math<TypeParam>;
  Draws draw(7);
  const std::vector<Band> bands =
      TestFixture::is_double ? std::vector<Band>{{4, 1}, {100, 1.1L}, {1e4, 1.1L}, {1e7, 2}}
                             : std::vector<Band>{{4, 1}, {100, 1.1L}, {1e4, 2.5L}, {1e5, 10}};
  for (const Band& band : bands) {
    Real worst = 0;
    for (int i = 0; i < TestFixture::count; ++i) {
      const TypeParam angle = draw.scalar<TypeParam>(-band.range, band.range);
      const TypeParam wrapped = M::wrap(angle);
      ASSERT_GE(wrapped, -M::pi) << angle;
      ASSERT_LT(wrapped, M::pi) << angle;
      worst = std::max(worst, TestFixture::separation(angle, wrapped));
    }
    EXPECT_LE(worst, band.bound * unit<TypeParam>) << "range " << band.range;
  }
  for (int turns = -1000; turns <= 1000; ++turns) {  // about the seams
    for (const TypeParam side : {TypeParam(-1e-3), TypeParam(0), TypeParam(1e-3)}) {
      const TypeParam wrapped = M::wrap(static_cast<TypeParam>((2 * turns + 1) * pi) + side);
      ASSERT_GE(wrapped, -M::pi) << turns;
      ASSERT_LT(wrapped, M::pi) << turns;
    }
  }
}

TYPED_TEST(Math, NotANumberStaysSo) {
  using M = math<TypeParam>;
  for (const TypeParam bad : {not_a_number<TypeParam>, infinite<TypeParam>, -infinite<TypeParam>}) {
    EXPECT_TRUE(std::isnan(M::heading(bad).cosine)) << bad;
    EXPECT_TRUE(std::isnan(M::heading(bad).sine)) << bad;
    EXPECT_TRUE(std::isnan(M::wrap(bad))) << bad;
    EXPECT_FALSE(M::is_finite(bad)) << bad;
  }
  EXPECT_TRUE(std::isnan(M::sigmoid(not_a_number<TypeParam>)));
  EXPECT_TRUE(std::isnan(M::identity(not_a_number<TypeParam>)));
  EXPECT_TRUE(std::isnan(M::absolute(not_a_number<TypeParam>)));
}

TYPED_TEST(Math, SmallHelpers) {
  using M = math<TypeParam>;
  const auto number = [](double value) { return static_cast<TypeParam>(value); };
  EXPECT_EQ(M::minimum(1, 2), number(1));
  EXPECT_EQ(M::minimum(2, 1), number(1));
  EXPECT_EQ(M::maximum(1, 2), number(2));
  EXPECT_EQ(M::maximum(2, 1), number(2));
  EXPECT_EQ(M::absolute(-3), number(3));
  EXPECT_EQ(M::absolute(3), number(3));
  EXPECT_EQ(M::select(true, 1, 2), number(1));
  EXPECT_EQ(M::select(false, 1, 2), number(2));
  EXPECT_EQ(M::nearest(number(2.5)), number(2));
  EXPECT_EQ(M::nearest(number(3.5)), number(4));
  EXPECT_EQ(M::nearest(number(-2.6)), number(-3));
  EXPECT_EQ(M::identity(number(0.7)), number(0.7));
  EXPECT_TRUE(M::is_finite(std::numeric_limits<TypeParam>::max()));
  EXPECT_TRUE(M::all());
  EXPECT_TRUE(M::any(true));
  EXPECT_FALSE(M::any(false));
}

}  // namespace
}  // namespace nfopidn::test
