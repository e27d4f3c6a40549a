// L4. What runs in lanes have in common, and which runs may go there.
#pragma once

#include <algorithm>
#include <memory>
#include <vector>

#include "nfopidn/tuning/batch.hpp"
#include "nfopidn/tuning/monte_carlo_job.hpp"
#include "nfopidn/tuning/structures.hpp"

namespace nfopidn {

// The numbers of a controller's law as the lanes take them: taps, and LawParameters if any.
inline std::vector<double> lane_law_of(const ControllerDesign& design) {
  const Structure structure = {design, parameter_set_of(design)};
  const auto size = static_cast<std::size_t>(law_size(design, design.memory + 2));
  std::vector<double> numbers(size);
  parameters_to_law(structure, parameters_of(structure.parameters, design), numbers.data());
  return numbers;
}

// Whether lanes can run it: memory up to 5, a measured pose, no disturbance by the sample.
inline bool runs_in_lanes(const Scenario& scenario, const ControllerDesign& design) {
  if (design.memory.is_long() || design.memory + 2 > small_capacity) return false;
  return scenario.disturbance.size() == 1 && scenario.encoder_counts == 0;
}

// What runs in lanes have in common: the path, and a controller.
class LaneSetting {
 public:
  // What LaneRun has of its own may be any other.
  LaneSetting(Scenario scenario, const ControllerDesign& design)
      : structure_(design), law_(lane_law_of(design)), calm_(std::move(scenario)) {
    calm_.pose_noise = {0, 0};
    calm_.disturbance = {{0, 0}};
    run_ = std::make_unique<PreparedRun>(prepare(calm_));
    headings_ = run_->reference_headings();
  }

  LaneSetting(const LaneSetting&) = delete;
  LaneSetting& operator=(const LaneSetting&) = delete;

  const PreparedRun& run() const { return *run_; }

  static LaneRun own(const Scenario& s) {
    return {s.robot,         detail::friction_of(s), {s.disturbance[0][0], s.disturbance[0][1]},
            s.pose_noise[0], s.pose_noise[1],        detail::start_state(s),
            s.seed};
  }

  // use(job) for runs of one delay.
  template <class Use>
  // NOLINTNEXTLINE(readability-non-const-parameter): `use` writes to costs
  void with_job(const LaneRun* runs, int count, int delay, double* costs, const Use& use) const {
    LoopInputs<double> inputs = run_->inputs();
    inputs.headings = headings_.data();
    inputs.delay = delay;
    const MonteCarloJob job = {&inputs,
                               &structure_,
                               &run_->limits,
                               law_.data(),
                               structure_.memory + 2,
                               static_cast<int>(law_.size()),
                               calm_.initial_velocity.reference,
                               calm_.motor ? &*calm_.motor : nullptr,
                               calm_.integrator,
                               calm_.trajectory.dt(),
                               calm_.substeps,
                               runs,
                               count,
                               costs,
                               run_->poll(),
                               nullptr};
    use(job);
  }

 private:
  ControllerSettings<double> structure_;
  std::vector<double> law_;
  Scenario calm_;
  std::unique_ptr<PreparedRun> run_;
  std::vector<Heading<double>> headings_;  // of the reference
};

// A run that waits for others of its delay, and where its result goes.
template <class Result>
struct WaitingRun {
  int delay;
  Result* result;
  LaneRun run;

  bool is_braked() const { return run.friction.is_braked(); }
};

// Lanes have one delay, and all or none of them viscous friction or scrub: calls use(first, runs)
// for the runs of each kind, which are those from `first` on.
template <class Result, class Use>
void for_each_kind(std::vector<WaitingRun<Result>>& waiting, const Use& use) {
  using Waiting = WaitingRun<Result>;
  const auto less = [](const Waiting& a, const Waiting& b) {
    return a.delay != b.delay ? a.delay < b.delay : !a.is_braked() && b.is_braked();
  };
  std::stable_sort(waiting.begin(), waiting.end(), less);
  std::vector<LaneRun> runs;
  for (auto from = waiting.begin(); from != waiting.end();) {
    const auto until = std::upper_bound(from, waiting.end(), *from, less);
    runs.clear();
    for (auto one = from; one != until; ++one) runs.push_back(one->run);
    use(&*from, runs);
    from = until;
  }
}

// Whether simulate_as_drawn() has it in the arithmetic of lanes.
inline bool runs_as_drawn(const Scenario& scenario, const ControllerDesign& design) {
  return scenario.noise_source == NoiseSource::counter && runs_in_lanes(scenario, design) &&
         check_run(scenario, design) == Status::ok;
}

}  // namespace nfopidn
