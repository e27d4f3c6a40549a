// L4. Runs in lanes with their samples: what each was, as simulate() gives it.
#pragma once

#include <functional>
#include <vector>

#include "nfopidn/tuning/lane_setting.hpp"

namespace nfopidn {

// Runs blocks of lanes and takes them apart again. Of one thread.
class LaneRecording {
 public:
  using Kernel = void (*)(const MonteCarloJob&);
  using Use = std::function<void(int run, const SimulationResult& result)>;

  explicit LaneRecording(const LaneSetting& setting)
      : setting_(setting), scenario_(*setting.run().scenario), run_(setting.run()) {
    run_.scenario = &scenario_;
    samples_.resize(run_.reference.size() * lane_column_count * most_recorded_lanes);
  }

  LaneRecording(const LaneRecording&) = delete;
  LaneRecording& operator=(const LaneRecording&) = delete;

  // Calls `use` with each of the runs, which have one delay.
  void run(const LaneRun* runs, int count, int delay, Kernel kernel, const Use& use) {
    runs_ = runs;
    use_ = &use;
    costs_.resize(static_cast<std::size_t>(count));
    const LaneRecorder recorder = {samples_.data(),
                                   [](void* owner, const RecordedLanes& block) {
                                     static_cast<LaneRecording*>(owner)->take(block);
                                   },
                                   this};
    setting_.with_job(runs, count, delay, costs_.data(), [&](MonteCarloJob job) {
      job.recorder = &recorder;
      kernel(job);
    });
  }

 private:
  void take(const RecordedLanes& block) {
    for (int lane = 0; lane < block.count; ++lane) {
      (*use_)(block.first + lane, result(block, lane));
    }
  }

  // Lanes go on after one of them has diverged; its samples end there by the meter's rule.
  SimulationResult result(const RecordedLanes& block, int lane) {
    const int run = block.first + lane;
    scenario_.robot = runs_[run].robot;
    detail::Recording recording(run_);
    const LoopInputs<double> inputs = run_.inputs();
    CostMeter<double> meter(inputs.divergence_distance, inputs.cost_weights);
    const auto lanes = static_cast<std::ptrdiff_t>(block.lanes);
    const std::ptrdiff_t row = lane_column_count * lanes;
    int k = 0;
    for (; k < block.completed; ++k) {
      const double* sample = block.samples + row * k + lane;
      const auto number = [&](LaneColumn column) { return sample[column * lanes]; };
      const State<double> state = {number(lane_x), number(lane_y), number(lane_theta),
                                   number(lane_v), number(lane_omega)};
      const TorquePair<double> torque = {number(lane_torque_left), number(lane_torque_right)};
      const ReferenceSample<double>& reference = run_.reference[static_cast<std::size_t>(k)];
      const Measurement<double> exact = {state.x, state.y, state.theta, state.v, state.omega};
      if (!meter.add(plain_errors(exact, reference), torque, reference)) break;
      recording.add(k, state, torque, {number(lane_feedback_left), number(lane_feedback_right)});
    }
    return recording.finish({costs_[static_cast<std::size_t>(run)], k});
  }

  const LaneSetting& setting_;
  Scenario scenario_;  // with the robot of the run that is taken
  PreparedRun run_;
  std::vector<double> samples_, costs_;
  const LaneRun* runs_ = nullptr;
  const Use* use_ = nullptr;
};

}  // namespace nfopidn
