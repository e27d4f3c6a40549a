// L3. The cost and the metrics of a run that took place elsewhere: in a physics engine, on a robot.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn {

// What was recorded at a sample, before the robot moves on.
struct RecordedSample {
  State<double> state;          // the true one
  TorquePair<double> torque;    // total, after the limit, in the paper's sign [N m]
  TorquePair<double> feedback;  // what of it is not the reference's [N m]
};

// The run as simulate() would have recorded it. Samples that are missing at the end, or that follow
// the one at which the rule of CostMeter finds the run diverged, cost the divergence distance
// squared each. The scenario must be valid; samples beyond its last one do not count.
NFOPIDN_HOST SimulationResult score(const Scenario& scenario,
                                    const std::vector<RecordedSample>& samples);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST SimulationResult score(const Scenario& scenario,
                                    const std::vector<RecordedSample>& samples) {
  const StandardArithmetic arithmetic;
  const PreparedRun run = prepare(scenario);
  const LoopInputs<double> in = run.inputs();
  CostMeter<double> meter(in.divergence_distance, in.cost_weights);
  detail::Recording recording(run);
  const int recorded = std::min(in.samples, static_cast<int>(samples.size()));
  int k = 0;
  bool running = true;
  for (; k < recorded && running; ++k) {
    const auto& [state, torque, feedback] = samples[static_cast<std::size_t>(k)];
    const Measurement<double> exact = {state.x, state.y, state.theta, state.v, state.omega};
    running = meter.add(world_errors(exact, run.reference[static_cast<std::size_t>(k)]), torque,
                        run.reference[static_cast<std::size_t>(k)]);
    if (running) recording.add(k, state, torque, feedback);
  }
  meter.miss(in.samples - k);
  return recording.finish({meter.mean(in.samples), running ? k : k - 1});
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
