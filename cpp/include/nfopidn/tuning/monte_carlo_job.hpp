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

// What of a sample of a run is recorded: the state, the total torque and that of the feedback.
enum LaneColumn : int {
  lane_x,
  lane_y,
  lane_theta,
  lane_v,
  lane_omega,
  lane_torque_left,
  lane_torque_right,
  lane_feedback_left,
  lane_feedback_right,
  lane_column_count
};

// Most lanes of a block that records: the samples of so many fit the cache.
constexpr int most_recorded_lanes = 16;

// A block of lanes whose samples are recorded: those of runs[first] and of the count - 1 behind it.
// Column c of sample k of lane i is samples[(k * lane_column_count + c) * lanes + i].
struct RecordedLanes {
  const double* samples;
  int lanes;
  int first;
  int count;
  int completed;  // samples until the last lane diverged, or all
};

// Is given each block when it has run.
struct LaneRecorder {
  double* samples;  // room for inputs->samples of most_recorded_lanes
  void (*take)(void* owner, const RecordedLanes& block);
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
  const LaneRun* runs;  // with viscous friction or scrub all, or none
  int count;
  double* costs;  // [count]
  Poll poll;
  const LaneRecorder* recorder;  // set only for a recording
};

}  // namespace nfopidn
