// The closed loop over lanes, for whatever instruction set the including unit is compiled for.
#pragma once

#include "lanes_math.hpp"
#include "nfopidn/batch_job.hpp"
#include "nfopidn/dual.hpp"
#include "nfopidn/loop.hpp"

namespace nfopidn {

// Spare history of a lanes' filter: enough to make its shift rare, little enough for the cache.
constexpr int lane_slack = 25;
constexpr int small_capacity = 7;  // memory 5, the paper's

template <bool noisy, class Scalar, class Meter, int capacity>
inline LoopResult<Scalar> run_law(const BatchJob& job, const Meter& meter,
                                  const Scalar (&taps)[channel_count][capacity]) {
  Controller<Scalar, Fir<Scalar, capacity, lane_slack>> law;
  law.configure_structure(*job.structure, *job.limits);
  law.set_taps(taps[0], taps[1], taps[2], job.tap_count);
  const State<Scalar> start = {Scalar(job.start->x), Scalar(job.start->y), Scalar(job.start->theta),
                               Scalar(job.start->v), Scalar(job.start->omega)};
  LoopState<Scalar> loop = {start, DelayLine<Scalar>(job.inputs->delay)};
  const auto ignore = [](int, const State<Scalar>&, const TorquePair<Scalar>&,
                         const TorquePair<Scalar>&) {};
  return detail::run_loop<noisy, Scalar>(*job.plant, law, loop, *job.inputs, meter, ignore,
                                         job.poll);
}

// Runs the candidates first .. first + Wide::size - 1; past the last one, the last one again.
template <class Wide, int capacity, bool noisy>
inline void run_lanes(const BatchJob& job, int first) {
  Wide taps[channel_count][capacity];
  Wide bound(no_bound);
  for (int lane = 0; lane < Wide::size; ++lane) {
    const int candidate = first + lane < job.candidates ? first + lane : job.candidates - 1;
    if (job.bounds != nullptr) bound.set(lane, job.bounds[candidate]);
    const double* source = job.taps + static_cast<long>(candidate) * channel_count * job.tap_count;
    for (int channel = 0; channel < channel_count; ++channel) {
      for (int j = 0; j < job.tap_count; ++j) {
        taps[channel][j].set(lane, source[channel * job.tap_count + j]);
      }
    }
  }
  const BoundedMeter<Wide> meter(job.inputs->divergence_distance, bound, job.inputs->samples);
  const LoopResult<Wide> result = run_law<noisy>(job, meter, taps);
  for (int lane = 0; lane < Wide::size && first + lane < job.candidates; ++lane) {
    job.costs[first + lane] = result.cost.get(lane);
  }
}

// The cost and its slopes in the directions first .. first + Wide::size - 1. The value is one
// number: only the slopes are lanes.
template <class Wide, int capacity, bool noisy>
inline void run_dual(const GradientJob& gradient, int first) {
  using Scalar = Dual<double, Wide>;
  const BatchJob& job = gradient.batch;
  Scalar taps[channel_count][capacity];
  for (int channel = 0; channel < channel_count; ++channel) {
    for (int j = 0; j < job.tap_count; ++j) {
      const int place = channel * job.tap_count + j;
      Scalar& tap = taps[channel][j];
      tap.value = job.taps[place];
      tap.slope = Wide(0.0);
      for (int lane = 0; lane < Wide::size && first + lane < gradient.directions; ++lane) {
        const long row = static_cast<long>(first + lane) * channel_count * job.tap_count;
        tap.slope.set(lane, gradient.slopes[row + place]);
      }
    }
  }
  const CostMeter<Scalar> meter(job.inputs->divergence_distance);
  const LoopResult<Scalar> result = run_law<noisy>(job, meter, taps);
  job.costs[0] = result.cost.value;
  for (int lane = 0; lane < Wide::size && first + lane < gradient.directions; ++lane) {
    gradient.gradient[first + lane] = result.cost.slope.get(lane);
  }
}

// The candidates from `first` on; what is left at the end in a narrower block, down to `least`
// vectors.
template <int width, int count, int least, int capacity, bool noisy>
inline void run_blocks(const BatchJob& job, int first) {
  constexpr int size = width * count;
  constexpr int narrower = count > least ? size - width : 0;
  for (; job.candidates - first > narrower; first += size) {
    run_lanes<Lanes<width, count>, capacity, noisy>(job, first);
  }
  if constexpr (count > least) {
    if (first < job.candidates) {
      run_blocks<width, count - 1, least, capacity, noisy>(job, first);
    }
  }
}

// Calls use(capacity, noisy). Each pair is compiled for each instruction set, so there are few: the
// paper's memory, and all else.
template <class Use>
inline void with_loop(const BatchJob& job, const Use& use) {
  if (job.inputs->noise != nullptr) {
    use(std::integral_constant<int, batch_capacity>(), std::true_type());
  } else if (job.tap_count > small_capacity) {
    use(std::integral_constant<int, batch_capacity>(), std::false_type());
  } else {
    use(std::integral_constant<int, small_capacity>(), std::false_type());
  }
}

// Up to `count` vectors a block.
template <int width, int count>
inline void run_batch(const BatchJob& job) {
  with_loop(job, [&](auto capacity, auto noisy) {
    constexpr int least = capacity() == small_capacity ? 1 : count;
    run_blocks<width, count, least, capacity(), noisy()>(job, 0);
  });
}

// Up to `count` vectors of directions at once, or half of them if that is enough.
template <int width, int count>
inline void run_gradient(const GradientJob& job) {
  constexpr int half = (count + 1) / 2;
  with_loop(job.batch, [&](auto capacity, auto noisy) {
    for (int first = 0; first < job.directions; first += width * count) {
      if (job.directions - first <= width * half) {
        run_dual<Lanes<width, half>, capacity(), noisy()>(job, first);
      } else {
        run_dual<Lanes<width, count>, capacity(), noisy()>(job, first);
      }
    }
  });
}

}  // namespace nfopidn
