// The reference on board.
#include "nfopidn/firmware/reference_table.hpp"
#include "nfopidn/simulation/trajectory.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

constexpr ReferenceSample<float> samples[] = {{0, 1, 2, 3, 4, 5, 6, false},
                                              {10, 11, 12, 13, 14, 15, 16, true},
                                              {20, 21, 22, 23, 24, 25, 26, true}};

TEST(ReferenceTables, EndAtRest) {
  constexpr ReferenceTable<float> table(samples, 3);
  static_assert(table.at(1).theta == 12, "the compiler can read it");
  EXPECT_EQ(table.count(), 3);
  for (unsigned long k = 0; k < 3; ++k) {
    EXPECT_EQ(table.at(k).tau_right, samples[k].tau_right);
    EXPECT_EQ(table.at(k).reverse, samples[k].reverse);
  }
  for (const unsigned long k : {3UL, 4UL, ~0UL}) {
    const auto rest = table.at(k);
    EXPECT_EQ(rest.x, 20);
    EXPECT_EQ(rest.y, 21);
    EXPECT_EQ(rest.theta, 22);
    EXPECT_EQ(rest.v, 0);
    EXPECT_EQ(rest.omega, 0);
    EXPECT_EQ(rest.tau_left, 0);
    EXPECT_EQ(rest.tau_right, 0);
    EXPECT_TRUE(rest.reverse);
  }
}

TEST(ReferenceTables, BeginAgainAfterALap) {
  constexpr ReferenceTable<float> closed(samples, 3, 2);
  constexpr ReferenceTable<float> whole(samples, 3, 3);
  for (unsigned long k = 0; k < 12; ++k) {
    EXPECT_EQ(closed.at(k).x, samples[k % 2].x);
    EXPECT_EQ(whole.at(k).tau_left, samples[k % 3].tau_left);
  }
}

// A robot that follows the table for three laps sees no jump where a lap ends.
TEST(ReferenceTables, LapsOfAClosedPathAreEven) {
  Scenario scenario;
  TrajectorySettings settings;
  settings.name = Curve::circle;
  settings.derivatives = Derivatives::analytic;
  scenario.trajectory = make(settings);
  const PreparedRun run = prepare(scenario);
  const int lap = static_cast<int>(run.reference.size()) - 1;
  const ReferenceTable<double> table(run.reference.data(), lap + 1, lap);
  const double step = std::hypot(table.at(1).x - table.at(0).x, table.at(1).y - table.at(0).y);
  for (unsigned long k = 0; k < 3UL * static_cast<unsigned long>(lap); ++k) {
    const auto now = table.at(k);
    const auto next = table.at(k + 1);
    EXPECT_NEAR(std::hypot(next.x - now.x, next.y - now.y), step, 1e-9) << k;
    EXPECT_NEAR(math<double>::wrap(next.theta - now.theta), table.at(1).theta - table.at(0).theta,
                1e-9);
  }
}

}  // namespace
}  // namespace nfopidn::test
