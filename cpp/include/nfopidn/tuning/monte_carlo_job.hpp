// L4. What the units per instruction set are given of runs that each have their own robot, start
// and noise: raw pointers, borrowed.
#pragma once

#include <stdint.h>  // NOLINT(modernize-deprecated-headers): <cstdint> is not everywhere

#include "nfopidn/tuning/batch_job.hpp"

namespace nfopidn {

// What a run has of its own, as the loop takes it.
struct LaneRun {
  Robot<double> robot;
  Friction<double> friction;
  Disturbance<double> disturbance;  // for the whole run
  double position_noise;            // standard deviations [m], [rad]
  double heading_noise;
  State<double> start;
  uint64_t seed;
};

// Is told each sample of a run.
struct LaneRecorder {
  void (*record)(void* owner, int k, const State<double>& state, const TorquePair<double>& torque,
                 const TorquePair<double>& feedback);
  void* owner;
};

struct MonteCarloJob {
  const LoopInputs<double>* inputs;  // with headings, without noise and disturbance
  const ControllerSettings<double>* structure;
  const ControlLimits<double>* limits;
  const double* law;  // [law_size] of all runs, as in BatchJob
  int tap_count;      // at most small_capacity
  int law_size;
  bool in_motion;              // the robots start with the reference's speed
  const Motor<double>* motor;  // of all runs; may be null
  Integrator integrator;
  double sample_time;
  int substeps;
  const LaneRun* runs;  // with viscous friction all, or none of them
  int count;
  double* costs;  // [count]
  Poll poll;
  // Set only for a recording, which is of runs[0] alone.
  const LaneRecorder* recorder;
  int* completed;  // samples until it diverged, or all
};

}  // namespace nfopidn
