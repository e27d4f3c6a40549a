// The basin of attraction: final errors against recorded runs, at any number of threads.
#include "nfopidn/analysis/basin.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

TEST(Basin, ErrorsAreThoseOfTheRunsLastSamples) {
  const Scenario scenario = short_scenario();
  const ControllerDesign design = steady_settings(Form::positional);
  const PreparedRun run = prepare(scenario);
  constexpr int last = 20;
  Draws draw(3);
  std::vector<double> poses;
  for (int i = 0; i < 12; ++i) {
    for (const double scale : {1.0, 1.0, 3.0}) poses.push_back(1.5 + draw.between(-scale, scale));
  }
  poses.insert(poses.end(), {40, 0, 0});  // further than the divergence distance
  std::vector<FinalErrors> errors(13);
  basin(run, design, poses.data(), 13, last, 1, errors.data());
  for (std::size_t i = 0; i < 12; ++i) {
    Scenario own = scenario;
    own.initial_pose = {poses[3 * i], poses[3 * i + 1], poses[3 * i + 2]};
    const SimulationResult simulated = simulate(own, design);
    if (simulated.diverged) {
      EXPECT_EQ(errors[i].position, infinite<double>);
      continue;
    }
    const auto tail = simulated.table.bottomRows(last);
    const double position =
        std::sqrt((tail.col(column_e_x).square() + tail.col(column_e_y).square()).mean());
    EXPECT_TRUE(near(errors[i].position, position, 1e-9)) << i;
    EXPECT_TRUE(near(errors[i].heading, std::sqrt(tail.col(column_e_theta).square().mean()), 1e-9))
        << i;
  }
  EXPECT_EQ(errors[12].position, infinite<double>);
  EXPECT_EQ(errors[12].heading, infinite<double>);

  std::vector<FinalErrors> threaded(13);
  basin(run, design, poses.data(), 13, last, 3, threaded.data());
  for (std::size_t i = 0; i < 13; ++i) EXPECT_TRUE(same_bits(errors[i], threaded[i])) << i;
}

}  // namespace
}  // namespace nfopidn::test
