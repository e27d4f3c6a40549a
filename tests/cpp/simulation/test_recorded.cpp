// Runs that took place elsewhere, scored as simulate() scores its own.
#include "nfopidn/simulation/recorded.hpp"
#include "support.hpp"

namespace nfopidn::test {
namespace {

std::vector<RecordedSample> samples_of(const RunTable& table) {
  std::vector<RecordedSample> samples;
  for (Eigen::Index k = 0; k < table.rows(); ++k) {
    const auto at = [&](int column) { return table(k, column); };
    samples.push_back(
        {{at(column_x), at(column_y), at(column_theta), at(column_v), at(column_omega)},
         {at(column_tau_left), at(column_tau_right)},
         {at(column_tau_fb_left), at(column_tau_fb_right)}});
  }
  return samples;
}

TEST(Recorded, ASimulatedRunScoresAsItDid) {
  const Scenario scenario = Scenario::published();
  const SimulationResult run = simulate(scenario, ControllerDesign{});
  const SimulationResult scored = score(scenario, samples_of(run.table));
  EXPECT_EQ(scored.metrics.cost, run.metrics.cost);
  EXPECT_EQ(scored.metrics.energy, run.metrics.energy);
  EXPECT_FALSE(scored.diverged);
  EXPECT_TRUE((scored.table == run.table).all());
}

// eq. 41: each sample that is missing costs the divergence distance squared.
TEST(Recorded, MissingSamplesCountAsLost) {
  const Scenario scenario = Scenario::published();
  const SimulationResult run = simulate(scenario, ControllerDesign{});
  std::vector<RecordedSample> samples = samples_of(run.table);
  samples[700].state.x += 1000;
  const SimulationResult far = score(scenario, samples);
  samples.resize(700);
  const SimulationResult cut = score(scenario, samples);
  EXPECT_EQ(far.metrics.cost, cut.metrics.cost);
  EXPECT_GT(cut.metrics.cost, 51 * 100.0 / 751);
  EXPECT_LT(cut.metrics.cost, 51 * 100.0 / 751 + run.metrics.cost);
  for (const SimulationResult* one : {&far, &cut}) {
    EXPECT_TRUE(one->diverged);
    EXPECT_NEAR(one->diverged_at, 140, 1e-12);
    EXPECT_EQ(one->table.rows(), 700);
  }
}

}  // namespace
}  // namespace nfopidn::test
