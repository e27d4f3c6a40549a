// The closed loop of rivals over lanes, as kernel.hpp has that of the controller.
#pragma once

#include "lanes_motion.hpp"
#include "nfopidn/loop/closed_loop.hpp"
#include "nfopidn/math/dual.hpp"
#include "nfopidn/rivals/lqr_schedule.hpp"
#include "nfopidn/rivals/rival_job.hpp"
#include "nfopidn/rivals/samson.hpp"
#include "nfopidn/rivals/sliding_mode.hpp"
#include "nfopidn/rivals/takagi_sugeno.hpp"

namespace nfopidn {

template <class Law, class Meter, class Scalar>
inline LoopResult<Scalar> run_rival(const RivalJob& job, const Meter& meter, const Law& law,
                                    const Scalar* integral_numbers) {
  rivals::IntegralGains<Scalar> integral;
  rivals::take_parameters(integral_numbers, integral);
  rivals::Rival<Law, true> rival(law, job.model, job.torque_limit, job.speeds, integral);
  const State<Scalar> start = {Scalar(job.start->x), Scalar(job.start->y), Scalar(job.start->theta),
                               Scalar(job.start->v), Scalar(job.start->omega)};
  LoopState<Scalar> loop = {start, DelayLine<Scalar>(job.inputs->delay)};
  const auto ignore = [](int, const State<Scalar>&, const TorquePair<Scalar>&,
                         const TorquePair<Scalar>&) {};
  return detail::run_loop<true, Scalar>(*job.plant, rival, loop, *job.inputs, meter, ignore,
                                        job.poll);
}

template <class Law, class Meter, class Scalar>
inline LoopResult<Scalar> run_settings(const RivalJob& job, const Meter& meter,
                                       const Scalar* numbers) {
  typename Law::Settings settings;
  static_assert(rivals::parameter_count<typename Law::Settings> + 2 <= most_rival_numbers);
  const Scalar* const integral = rivals::take_parameters(numbers, settings);
  return run_rival(job, meter, Law(settings, job.model), integral);
}

// get(i) gives number i of the candidates.
template <class Scalar, class Meter, class Get>
inline LoopResult<Scalar> run_regulator(const RivalJob& job, const Meter& meter, const Get& get) {
  rivals::LqrGains<Scalar> table[most_table_entries];
  constexpr int loop_numbers = 4;  // of the velocity loop, and of the integral action
  Scalar numbers[loop_numbers];
  for (int i = 0; i < loop_numbers; ++i) numbers[i] = get(i);
  for (int i = 0; i < job.table_size; ++i) {
    const int first = loop_numbers + 3 * i;
    table[i] = {get(first), get(first + 1), get(first + 2)};
  }
  using Schedule = rivals::LqrSchedule<Scalar>;
  const rivals::VelocityLoop<Schedule> law(Schedule{table, job.table_size, job.table_spacing},
                                           numbers[0], numbers[1]);
  return run_rival(job, meter, law, numbers + 2);
}

template <class Scalar, class Meter, class Get>
inline LoopResult<Scalar> run_lane_law(const RivalJob& job, const Meter& meter, const Get& get) {
  if (job.law == LaneLaw::lqr) return run_regulator<Scalar>(job, meter, get);
  Scalar numbers[most_rival_numbers];
  for (int i = 0; i < job.number_count; ++i) numbers[i] = get(i);
  switch (job.law) {
    case LaneLaw::samson:
      return run_settings<rivals::VelocityLoop<rivals::Samson<Scalar>>>(job, meter, numbers);
    case LaneLaw::takagi_sugeno:
      return run_settings<rivals::VelocityLoop<rivals::TakagiSugeno<Scalar>>>(job, meter, numbers);
    default:
      return run_settings<rivals::SlidingMode<Scalar>>(job, meter, numbers);
  }
}

// As run_lanes().
template <class Wide>
inline void run_rival_lanes(const RivalJob& job, int first) {
  const double* sources[Wide::size];
  Wide bound(no_bound);
  for (int lane = 0; lane < Wide::size; ++lane) {
    const int candidate = first + lane < job.candidates ? first + lane : job.candidates - 1;
    if (job.bounds != nullptr) bound.set(lane, job.bounds[candidate]);
    sources[lane] = job.numbers + static_cast<long>(candidate) * job.number_count;
  }
  const auto get = [&](int i) {
    Wide number;
    for (int lane = 0; lane < Wide::size; ++lane) number.set(lane, sources[lane][i]);
    return number;
  };
  const BoundedMeter<Wide> meter(*job.inputs, bound);
  const LoopResult<Wide> result = run_lane_law<Wide>(job, meter, get);
  for (int lane = 0; lane < Wide::size && first + lane < job.candidates; ++lane) {
    job.costs[first + lane] = result.cost.get(lane);
  }
}

// As run_dual().
template <class Wide>
inline void run_rival_dual(const RivalGradientJob& gradient, int first) {
  using Scalar = Dual<double, Wide>;
  const RivalJob& job = gradient.batch;
  const auto get = [&](int i) {
    Scalar number;
    number.value = job.numbers[i];
    number.slope = Wide(0.0);
    for (int lane = 0; lane < Wide::size && first + lane < gradient.directions; ++lane) {
      number.slope.set(lane,
                       gradient.slopes[static_cast<long>(first + lane) * job.number_count + i]);
    }
    return number;
  };
  const CostMeter<Scalar> meter(job.inputs->divergence_distance, job.inputs->cost_weights);
  const LoopResult<Scalar> result = run_lane_law<Scalar>(job, meter, get);
  job.costs[0] = result.cost.value;
  for (int lane = 0; lane < Wide::size && first + lane < gradient.directions; ++lane) {
    gradient.gradient[first + lane] = result.cost.slope.get(lane);
  }
}

// Two vectors a block, or one where that is enough.
template <int width>
inline void run_rival_batch(const RivalJob& job) {
  int first = 0;
  for (; job.candidates - first > width; first += 2 * width) {
    run_rival_lanes<Lanes<width, 2>>(job, first);
  }
  if (first < job.candidates) run_rival_lanes<Lanes<width, 1>>(job, first);
}

template <int width>
inline void run_rival_gradient(const RivalGradientJob& job) {
  for (int first = 0; first < job.directions; first += width) {
    run_rival_dual<Lanes<width, 1>>(job, first);
  }
}

}  // namespace nfopidn
