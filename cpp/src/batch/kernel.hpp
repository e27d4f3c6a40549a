// The closed loop over lanes, for whatever instruction set the including unit is compiled for.
#pragma once

#include "lanes_motion.hpp"
#include "nfopidn/loop/closed_loop.hpp"
#include "nfopidn/math/dual.hpp"
#include "nfopidn/tuning/batch_job.hpp"

namespace nfopidn {

// Spare history of a lanes' filter: enough to make its shift rare, little enough for the cache.
constexpr int lane_slack = 25;

// Room for the numbers of a law.
template <int capacity, bool tracking>
constexpr int law_capacity = channel_count* capacity +
                             (tracking ? LawParameters<double>::count : 0);

template <bool tracking>
using LaneVariant = std::conditional_t<tracking, TrackingVariant<double>, RuntimeVariant<double>>;

// Sets a law as it is at the start of a run.
template <class Law, class Job, class Scalar>
NFOPIDN_INLINE void set_law_of_lanes(Law& law, const Job& job, const Scalar* numbers) {
  law.configure_structure(*job.structure, *job.limits);
  if constexpr (Law::Structure::has_tracking_law) {
    const Scalar* parameters = numbers + channel_count * job.tap_count;
    law.set_law(numbers, job.tap_count,
                law_parameters_from<Scalar>(parameters, [](const Scalar& n) { return n; }));
    if (job.in_motion) {
      law.reset_in_motion();
    } else {
      law.reset();
    }
  } else {
    const int row = job.tap_count;
    law.set_taps(numbers, numbers + row, numbers + 2 * row, row);
  }
}

template <bool noisy, bool tracking, int capacity, class Scalar, class Meter>
inline LoopResult<Scalar> run_law(const BatchJob& job, const Meter& meter, const Scalar* numbers) {
  Controller<Scalar, Fir<Scalar, capacity, lane_slack>, LaneVariant<tracking>> law;
  set_law_of_lanes(law, job, numbers);
  const State<Scalar> start = {Scalar(job.start->x), Scalar(job.start->y), Scalar(job.start->theta),
                               Scalar(job.start->v), Scalar(job.start->omega)};
  LoopState<Scalar> loop = {start, DelayLine<Scalar>(job.inputs->delay)};
  const auto ignore = [](int, const State<Scalar>&, const TorquePair<Scalar>&,
                         const TorquePair<Scalar>&) {};
  return detail::run_loop<noisy, Scalar>(*job.plant, law, loop, *job.inputs, meter, ignore,
                                         job.poll);
}

// Runs the candidates first .. first + Wide::size - 1; past the last one, the last one again.
template <class Wide, int capacity, bool noisy, bool tracking>
inline void run_lanes(const BatchJob& job, int first) {
  Wide law[law_capacity<capacity, tracking>];
  Wide bound(no_bound);
  for (int lane = 0; lane < Wide::size; ++lane) {
    const int candidate = first + lane < job.candidates ? first + lane : job.candidates - 1;
    if (job.bounds != nullptr) bound.set(lane, job.bounds[candidate]);
    const double* source = job.laws + static_cast<long>(candidate) * job.law_size;
    for (int i = 0; i < job.law_size; ++i) law[i].set(lane, source[i]);
  }
  const BoundedMeter<Wide> meter(*job.inputs, bound);
  const LoopResult<Wide> result = run_law<noisy, tracking, capacity>(job, meter, law);
  for (int lane = 0; lane < Wide::size && first + lane < job.candidates; ++lane) {
    job.costs[first + lane] = result.cost.get(lane);
  }
}

// The cost and its slopes in the directions first .. first + Wide::size - 1. The value is one
// number: only the slopes are lanes.
template <class Wide, int capacity, bool noisy, bool tracking>
inline void run_dual(const GradientJob& gradient, int first) {
  using Scalar = Dual<double, Wide>;
  const BatchJob& job = gradient.batch;
  Scalar law[law_capacity<capacity, tracking>];
  for (int i = 0; i < job.law_size; ++i) {
    law[i].value = job.laws[i];
    law[i].slope = Wide(0.0);
    for (int lane = 0; lane < Wide::size && first + lane < gradient.directions; ++lane) {
      law[i].slope.set(lane, gradient.slopes[static_cast<long>(first + lane) * job.law_size + i]);
    }
  }
  const CostMeter<Scalar> meter(job.inputs->divergence_distance, job.inputs->cost_weights);
  const LoopResult<Scalar> result = run_law<noisy, tracking, capacity>(job, meter, law);
  job.costs[0] = result.cost.value;
  for (int lane = 0; lane < Wide::size && first + lane < gradient.directions; ++lane) {
    gradient.gradient[first + lane] = result.cost.slope.get(lane);
  }
}

// The candidates from `first` on; what is left at the end in a narrower block, down to `least`
// vectors.
template <int width, int count, int least, int capacity, bool noisy, bool tracking>
inline void run_blocks(const BatchJob& job, int first) {
  constexpr int size = width * count;
  constexpr int narrower = count > least ? size - width : 0;
  for (; job.candidates - first > narrower; first += size) {
    run_lanes<Lanes<width, count>, capacity, noisy, tracking>(job, first);
  }
  if constexpr (count > least) {
    if (first < job.candidates) {
      run_blocks<width, count - 1, least, capacity, noisy, tracking>(job, first);
    }
  }
}

// Calls use(capacity, noisy, tracking). Each triple is compiled for each instruction set, so there
// are few: the paper's memory, and all else.
template <class Use>
inline void with_loop(const BatchJob& job, const Use& use) {
  const auto with_law = [&](auto tracking) {
    if (job.tap_count > small_capacity) {
      if (job.inputs->noise != nullptr) {
        use(std::integral_constant<int, batch_capacity>(), std::true_type(), tracking);
      } else {
        use(std::integral_constant<int, batch_capacity>(), std::false_type(), tracking);
      }
    } else if (job.inputs->noise == nullptr) {
      use(std::integral_constant<int, small_capacity>(), std::false_type(), tracking);
    } else if constexpr (tracking()) {
      use(std::integral_constant<int, small_capacity>(), std::true_type(), tracking);
    } else {
      use(std::integral_constant<int, batch_capacity>(), std::true_type(), tracking);
    }
  };
  if (job.structure->needs_tracking_law()) {
    with_law(std::true_type());
  } else {
    with_law(std::false_type());
  }
}

// Up to `count` vectors a block, of a short memory down to `fewest`.
template <int width, int count, int fewest = 1>
inline void run_batch(const BatchJob& job) {
  with_loop(job, [&](auto capacity, auto noisy, auto tracking) {
    constexpr int least = capacity() == small_capacity ? fewest : count;
    run_blocks<width, count, least, capacity(), noisy(), tracking()>(job, 0);
  });
}

// The directions from `first` on in as few of the counts of vectors as hold them, and of a run's
// value one run; more than the last count holds are left. Returns the first of those.
template <int width, int capacity, bool noisy, bool tracking, int count, int... more>
inline int run_directions(const GradientJob& job, int first) {
  if constexpr (sizeof...(more) > 0) {
    if (job.directions - first > width * count) {
      return run_directions<width, capacity, noisy, tracking, more...>(job, first);
    }
  }
  run_dual<Lanes<width, count>, capacity, noisy, tracking>(job, first);
  return first + width * count;
}

template <int width, int... counts>
inline void run_gradient(const GradientJob& job) {
  with_loop(job.batch, [&](auto capacity, auto noisy, auto tracking) {
    for (int first = 0; first < job.directions;) {
      first = run_directions<width, capacity(), noisy(), tracking(), counts...>(job, first);
    }
  });
}

}  // namespace nfopidn
