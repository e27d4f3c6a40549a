// What lanes compute otherwise than a single number, against long double; and that a lane's result
// does not depend on its neighbours.
#include "batch/lanes_math.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

using Wide = Lanes<2, 2>;
using LaneMath = math<Wide>;

struct Nets {
  Wide x, y, theta;
};

// To the last digit of a double.
double neuron(double net) {
  return static_cast<double>(std::tanh(static_cast<long double>(net) / 2));
}
double cosine(long double angle) { return static_cast<double>(std::cos(angle)); }
double sine(long double angle) { return static_cast<double>(std::sin(angle)); }

// Nets of every size: both ways to compute them, and saturation.
std::vector<double> numbers(double most, int count) {
  Random random(11);
  std::vector<double> all = {0, 0.53124, 0.53126, -0.53124, -0.53126};
  for (int i = 0; i < count; ++i) {
    const double size = most * std::exp(-8 * random.uniform());
    all.push_back(random.uniform() < 0.5 ? -size : size);
  }
  return all;
}

TEST(Lanes, NeuronsAreThoseOfLongDouble) {
  for (const double net : numbers(100, 20000)) {
    Nets nets = {Wide(net * LaneMath::net_scale), Wide(-net * LaneMath::net_scale),
                 Wide(net * 0.5 * LaneMath::net_scale)};
    LaneMath::sigmoids(nets);
    const double expected = neuron(net);
    ASSERT_NEAR(nets.x.get(0), expected, 2e-15 * std::fabs(expected)) << net;
    ASSERT_EQ(nets.y.get(3), -nets.x.get(0)) << net;
    ASSERT_NEAR(nets.theta.get(1), neuron(net / 2), 2e-15 * std::fabs(neuron(net / 2))) << net;
  }
}

TEST(Lanes, NeuronsDoNotDependOnTheirNeighbours) {
  for (const double net : numbers(4, 2000)) {
    Nets alone = {Wide(net), Wide(net), Wide(net)};
    LaneMath::sigmoids(alone);
    for (const double beside : {0.001, 0.3, 50.0}) {
      Nets nets = {Wide(beside), Wide(beside), Wide(beside)};
      for (Wide* channel : {&nets.x, &nets.y, &nets.theta}) channel->set(1, net);
      LaneMath::sigmoids(nets);
      ASSERT_EQ(nets.x.get(1), alone.x.get(1)) << net << " beside " << beside;
      ASSERT_EQ(nets.y.get(1), alone.y.get(1)) << net << " beside " << beside;
      ASSERT_EQ(nets.theta.get(1), alone.theta.get(1)) << net << " beside " << beside;
    }
  }
}

TEST(Lanes, HeadingBesideAKnownOne) {
  Random random(12);
  for (int i = 0; i < 20000; ++i) {
    const double first = random.uniform(-20, 20);
    const double range = i % 3 == 0 ? 0.4 : (i % 3 == 1 ? 4 : 20);
    const double between = random.uniform(-range, range);
    Wide difference(between);
    const Heading<Wide> heading =
        LaneMath::heading_relative_to(math<double>::heading(first), difference);
    const long double angle = static_cast<long double>(first) - between;
    ASSERT_NEAR(heading.cosine.get(0), cosine(angle), 2e-15) << first << " " << between;
    ASSERT_NEAR(heading.sine.get(3), sine(angle), 2e-15) << first << " " << between;
    ASSERT_LE(std::fabs(difference.get(1)), LaneMath::pi * (1 + 1e-15));
    const double turns = (between - difference.get(1)) / (2 * LaneMath::pi);
    ASSERT_NEAR(turns, std::round(turns), 1e-14);
  }
}

TEST(Lanes, HeadingDoesNotDependOnItsNeighbours) {
  const Heading<double> first = math<double>::heading(1.25);
  for (const double between : {0.0, 0.1, 0.3124, 0.3126, -0.3126, 3.1, 7.0}) {
    Wide alone(between);
    const Heading<Wide> expected = LaneMath::heading_relative_to(first, alone);
    for (const double other : {0.01, 2.0}) {
      Wide difference(other);
      difference.set(2, between);
      const Heading<Wide> heading = LaneMath::heading_relative_to(first, difference);
      EXPECT_EQ(heading.cosine.get(2), expected.cosine.get(2)) << between << " " << other;
      EXPECT_EQ(heading.sine.get(2), expected.sine.get(2)) << between << " " << other;
      EXPECT_EQ(difference.get(2), alone.get(2)) << between << " " << other;
    }
  }
}

// Lanes look at the limit only where their neurons reach it: under it, at it and over it the
// torques are those of a single number.
TEST(Lanes, TorquesAreLimitedAsThoseOfSingleNumbers) {
  ControllerSettings<double> settings;
  settings.allocation.matrix[0][0] = -1;  // shares of both signs: left takes up to 3
  settings.allocation.matrix[1][2] = 0.5;
  const double taps[channel_count][2] = {{4, 0}, {-3, 0.2}, {5, 0}};
  Draws draw(5);
  int limited = 0;
  for (int i = 0; i < 2000; ++i) {
    const double limit = draw.between(0.5, 5);
    const ControlLimits<double> limits = {limit, 1};
    Controller<Wide, Fir<Wide, 2, 3>> lanes;
    Controller<double, Fir<double, 2>> single;
    lanes.configure_structure(settings, limits);
    single.configure_structure(settings, limits);
    lanes.set_taps(taps[0], taps[1], taps[2], 2);
    single.set_taps(taps[0], taps[1], taps[2], 2);
    const ReferenceSample<double> reference = {
        0, 0, 0, 0.1, 0, draw.between(-3, 3), draw.between(-3, 3), false};
    const double x = draw.between(-2, 2), y = draw.between(-2, 2), theta = draw.between(-2, 2);
    const Heading<double> ahead = {1, 0};
    const auto one = single.step(Channels<double>{x, y, theta}, ahead, reference);
    const auto all = lanes.step(Channels<Wide>{Wide(x), Wide(y), Wide(theta)},
                                Heading<Wide>{Wide(1.0), Wide(0.0)}, reference);
    EXPECT_NEAR(all.left.get(1), one.left, 1e-14);
    EXPECT_NEAR(all.right.get(2), one.right, 1e-14);
    EXPECT_LE(std::fabs(all.left.get(0)), limit);
    limited += std::fabs(one.left) == limit ? 1 : 0;
  }
  EXPECT_GT(limited, 200);
  EXPECT_LT(limited, 1800);
}

TEST(Lanes, HeadingsAndWrapsOfAnyAngle) {
  for (double angle = -30; angle < 30; angle += 0.0137) {
    const Heading<Wide> heading = LaneMath::heading(Wide(angle));
    EXPECT_NEAR(heading.cosine.get(1), cosine(angle), 2e-15);
    EXPECT_NEAR(heading.sine.get(2), sine(angle), 2e-15);
    EXPECT_NEAR(LaneMath::wrap(Wide(angle)).get(0), math<double>::wrap(angle), 1e-14) << angle;
  }
}

}  // namespace
}  // namespace nfopidn::test
