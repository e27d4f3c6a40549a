// The closed loop over lanes that are a run each: robot, friction, disturbance, start and noise of
// a lane are its own. kernel.hpp has lanes of one scenario.
#pragma once

#include "kernel.hpp"
#include "nfopidn/math/counter_noise.hpp"
#include "nfopidn/tuning/monte_carlo_job.hpp"

namespace nfopidn {

template <int width>
struct Words {
  using Word [[gnu::vector_size(8 * width)]] = std::uint64_t;
};

// The noise of lanes, sample by sample in order, as CounterNoise has it: three normals a sample
// are three pairs every second sample.
template <int width, int count>
class LaneNoise {
 public:
  using Scalar = Lanes<width, count>;
  using Real = typename Vectors<width>::Real;
  using Word = typename Words<width>::Word;

  void set(int lane, const LaneRun& run) {
    const counter_noise::Key key(run.seed);
    first_[lane / width][lane % width] = key.first;
    second_[lane / width][lane % width] = key.second;
    position_.set(lane, run.position_noise);
    heading_.set(lane, run.heading_noise);
  }

  NFOPIDN_INLINE Measurement<Scalar> at(int k) {
    Measurement<Scalar> noise;
    const auto sample = static_cast<std::uint64_t>(k);
    for (int i = 0; i < count; ++i) {
      const auto first = normals(i, (3 * sample + 1) / 2);
      Real x = first.cosine, y = first.sine, theta;
      if (k % 2 == 0) {
        const auto second = normals(i, (3 * sample) / 2 + 1);
        theta = second.cosine;
        spare_.part[i] = second.sine;
      } else {
        theta = y;
        y = x;
        x = spare_.part[i];
      }
      noise.x.part[i] = x * position_.part[i];
      noise.y.part[i] = y * position_.part[i];
      noise.theta.part[i] = theta * heading_.part[i];
    }
    return noise;
  }

 private:
  NFOPIDN_INLINE counter_noise::Pair<Real> normals(int i, std::uint64_t pair) const {
    return counter_noise::normals<Real>(counter_noise::pair_bits(first_[i], second_[i], pair),
                                        [](const Real& a) { return Instructions<width>::root(a); });
  }

  Word first_[count], second_[count];  // of the keys
  Scalar position_, heading_;          // standard deviations
  Scalar spare_;                       // the next sample's first normal, after an even one
};

// What acts on lanes from outside.
template <class Wide>
struct LaneInputs : LoopInputs<double> {
  Disturbance<Wide> steady;

  explicit LaneInputs(const LoopInputs<double>& common)
      : LoopInputs<double>(common), steady{Wide(0.0), Wide(0.0)} {}
  NFOPIDN_INLINE const Disturbance<Wide>* disturbance_at(int /*k*/) const { return &steady; }
};

template <class Wide, class Noise>
struct NoisyLaneInputs : LaneInputs<Wide> {
  Noise noise;

  using LaneInputs<Wide>::LaneInputs;
  NFOPIDN_INLINE Measurement<Wide> noise_at(int k) { return noise.at(k); }
};

// A robot, a law and a start a lane.
template <class Wide, bool tracking>
struct LaneRuns {
  Robot<Wide> robot;
  Friction<Wide> friction;
  State<Wide> start;
  Wide law[law_capacity<small_capacity, tracking>];

  template <class Inputs>
  LaneRuns(const MonteCarloJob& job, int first, Inputs& inputs) {
    for (int lane = 0; lane < Wide::size; ++lane) {
      // Past the last one, the last one again.
      const LaneRun& run = job.runs[first + lane < job.count ? first + lane : job.count - 1];
      robot.mass.set(lane, run.robot.mass);
      robot.inertia.set(lane, run.robot.inertia);
      robot.track_width.set(lane, run.robot.track_width);
      robot.wheel_radius.set(lane, run.robot.wheel_radius);
      friction.viscous.set(lane, run.friction.viscous);
      friction.coulomb.set(lane, run.friction.coulomb);
      friction.scrub_viscous.set(lane, run.friction.scrub_viscous);
      friction.scrub_coulomb.set(lane, run.friction.scrub_coulomb);
      start.x.set(lane, run.start.x);
      start.y.set(lane, run.start.y);
      start.theta.set(lane, run.start.theta);
      start.v.set(lane, run.start.v);
      start.omega.set(lane, run.start.omega);
      inputs.steady.force.set(lane, run.disturbance.force);
      inputs.steady.moment.set(lane, run.disturbance.moment);
      if constexpr (detail::makes_noise<Inputs>) inputs.noise.set(lane, run);
    }
    for (int i = 0; i < job.law_size; ++i) law[i] = Wide(job.law[i]);
  }
};

// Writes each sample where the recorder wants it, if there is to be one.
template <bool recorded, class Wide, class Law>
NFOPIDN_INLINE auto observer_of(const MonteCarloJob& job, const Law& law) {
  return [&job, &law](int k, const State<Wide>& state, const TorquePair<Wide>& torque,
                      const TorquePair<Wide>& /*applied*/) {
    if constexpr (recorded) {
      static_assert(Wide::size <= most_recorded_lanes, "the recorder has no more room");
      const TorquePair<Wide> feedback = law.feedback();
      const Wide* const columns[lane_column_count] = {
          &state.x,     &state.y,      &state.theta,   &state.v,       &state.omega,
          &torque.left, &torque.right, &feedback.left, &feedback.right};
      double* place = job.recorder->samples + static_cast<long>(k) * lane_column_count * Wide::size;
      for (const Wide* column : columns) {
        __builtin_memcpy(place, column->part, sizeof column->part);
        place += Wide::size;
      }
    }
  };
}

template <class Wide, bool noisy, bool tracking, bool recorded, class Inputs>
inline void run_own_lanes(const MonteCarloJob& job, int first) {
  Inputs inputs(*job.inputs);
  const LaneRuns<Wide, tracking> runs(job, first, inputs);
  const RobotDrive<Wide> plant(runs.robot, runs.friction, job.motor, job.integrator,
                               job.sample_time, job.substeps);
  Controller<Wide, Fir<Wide, small_capacity, lane_slack>, LaneVariant<tracking>> law;
  set_law_of_lanes(law, job, runs.law);
  LoopState<Wide> loop = {runs.start, DelayLine<Wide>(inputs.delay)};
  const auto observe = observer_of<recorded, Wide>(job, law);
  const CostMeter<Wide> meter(inputs.divergence_distance, inputs.cost_weights);
  const LoopResult<Wide> result =
      detail::run_loop<noisy, Wide>(plant, law, loop, inputs, meter, observe, job.poll);
  const int count = job.count - first < Wide::size ? job.count - first : Wide::size;
  for (int lane = 0; lane < count; ++lane) job.costs[first + lane] = result.cost.get(lane);
  if constexpr (recorded) {
    const LaneRecorder& recorder = *job.recorder;
    recorder.take(recorder.owner, {recorder.samples, Wide::size, first, count, result.completed});
  }
}

template <int width, int count, bool tracking, bool recorded>
inline void run_own_blocks(const MonteCarloJob& job) {
  using Wide = Lanes<width, count>;
  for (int first = 0; first < job.count; first += Wide::size) {
    bool noisy = false;
    for (int i = first; i < first + Wide::size && i < job.count; ++i) {
      noisy = noisy || job.runs[i].position_noise > 0 || job.runs[i].heading_noise > 0;
    }
    if (noisy) {
      using Noise = LaneNoise<width, count>;
      run_own_lanes<Wide, true, tracking, recorded, NoisyLaneInputs<Wide, Noise>>(job, first);
    } else {
      run_own_lanes<Wide, false, tracking, recorded, LaneInputs<Wide>>(job, first);
    }
  }
}

template <int width, int count, bool recorded = false>
inline void run_monte_carlo(const MonteCarloJob& job) {
  if (job.structure->needs_tracking_law()) {
    run_own_blocks<width, count, true, recorded>(job);
  } else {
    run_own_blocks<width, count, false, recorded>(job);
  }
}

}  // namespace nfopidn
