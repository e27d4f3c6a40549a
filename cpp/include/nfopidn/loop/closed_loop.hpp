// L2. The closed loop: control, cost and motion, sample by sample.
#pragma once

#include "nfopidn/control/controller.hpp"
#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/loop/cost.hpp"
#include "nfopidn/loop/delay_line.hpp"
#include "nfopidn/loop/heading.hpp"
#include "nfopidn/loop/poll.hpp"
#include "nfopidn/plant/differential_drive.hpp"
#include "nfopidn/plant/plant.hpp"

namespace nfopidn {

// Where a loop stands between two samples, but for its law.
template <class Scalar>
struct LoopState {
  State<Scalar> robot;
  DelayLine<Scalar> delay;
};

namespace detail {

// Whether the law takes the measured pose's errors and heading, if the caller has them.
template <class Law, class Scalar, class = void>
constexpr bool takes_errors = false;
template <class Law, class Scalar>
constexpr bool
    takes_errors<Law, Scalar,
                 traits::void_t<decltype(traits::declval<Law&>().step(
                     traits::declval<Channels<Scalar>>(), traits::declval<Heading<Scalar>>(),
                     traits::declval<ReferenceSample<base_t<Scalar>>>()))>> = true;

template <class Scalar>
NFOPIDN_INLINE constexpr Measurement<Scalar> with_noise(const Measurement<Scalar>& exact,
                                                        const Measurement<base_t<Scalar>>& noise) {
  Measurement<Scalar> measured = exact;
  measured.x = measured.x + noise.x;
  measured.y = measured.y + noise.y;
  measured.theta = measured.theta + noise.theta;
  return measured;
}

// Whether a plant tells what it can give of a torque, and a law wants to know.
template <class Plant, class Scalar, class = void>
constexpr bool tells_available = false;
template <class Plant, class Scalar>
constexpr bool tells_available<
    Plant, Scalar,
    traits::void_t<decltype(traits::declval<const Plant&>().available(
        traits::declval<State<Scalar>>(), traits::declval<TorquePair<Scalar>>()))>> = true;
template <class Law, class Scalar, class = void>
constexpr bool learns_available = false;
template <class Law, class Scalar>
constexpr bool learns_available<
    Law, Scalar,
    traits::void_t<decltype(traits::declval<Law&>().learn_available(
        traits::declval<TorquePair<Scalar>>(), traits::declval<TorquePair<Scalar>>()))>> = true;

// Whether the inputs make each sample's noise when it is asked for: lanes that each have their own.
template <class Inputs, class = void>
constexpr bool makes_noise = false;
template <class Inputs>
constexpr bool
    makes_noise<Inputs, traits::void_t<decltype(traits::declval<Inputs&>().noise_at(0))>> = true;

// Whether the inputs tell what a measured pose has besides the true one.
template <class Inputs, class Scalar, class = void>
constexpr bool senses_pose = false;
template <class Inputs, class Scalar>
constexpr bool senses_pose<Inputs, Scalar,
                           traits::void_t<decltype(traits::declval<Inputs&>().error_at(
                               0, traits::declval<State<Scalar>>()))>> = true;

// The law's torque where the measurement is that noise away from the pose whose errors and heading
// are known.
template <class Scalar, class Law>
NFOPIDN_INLINE constexpr TorquePair<Scalar> step_with_noise(
    Law& law, const Channels<Scalar>& error, const Heading<Scalar>& heading,
    const Measurement<Scalar>& noise, const ReferenceSample<base_t<Scalar>>& shown) {
  const Heading<Scalar> turn = math<Scalar>::heading(noise.theta);
  const Channels<Scalar> measured = {error.x - noise.x, error.y - noise.y,
                                     math<Scalar>::wrap(error.theta - noise.theta)};
  const Heading<Scalar> facing = {heading.cosine * turn.cosine - heading.sine * turn.sine,
                                  heading.sine * turn.cosine + heading.cosine * turn.sine};
  return law.step(measured, facing, shown);
}

// The samples first .. last - 1. Returns `last`, or the sample at which every component had
// diverged; the robot's state then stays as it was. Without noise the true and the measured pose
// are one, and its cosine and sine are computed once.
template <bool noisy, class Scalar, class Plant, class Law, class Inputs, class Meter,
          class Observer>
constexpr int run_piece(const Plant& plant, Law& law, LoopState<Scalar>& loop, Inputs& inputs,
                        int first, int last, Meter& total, Observer& observe) {
  using Base = base_t<Scalar>;
  constexpr int bound_check_period = 32;  // a power of two
  // Copies, so that they never leave their registers.
  State<Scalar> state = loop.robot;
  Meter meter = total;
  HeadingTracker<Scalar> heading_tracker;
  for (int k = first; k < last; ++k) {
    const ReferenceSample<Base>& reference = inputs.reference[k];
    // Measure.
    const Measurement<Scalar> exact = {state.x, state.y, state.theta, state.v, state.omega};
    Channels<Scalar> error = plain_errors(exact, reference);
    // Diverged lanes count as being on the reference: the others keep their shorter way through.
    if (!meter.all_running()) {
      error = meter.of_running(error);
      if (plant.is_exact()) {
        state.v = meter.if_running(state.v, reference.v);
        state.omega = meter.if_running(state.omega, reference.omega);
      }
    }
    const Heading<Scalar> heading = heading_tracker.track(error.theta, state.theta, inputs, k);
    // Act.
    ReferenceSample<Base> shown = reference;
    if (!inputs.feedforward) shown.tau_left = shown.tau_right = Base(0);
    TorquePair<Scalar> torque;
    if constexpr (senses_pose<Inputs, Scalar>) {
      torque = law.step(with_noise(exact, inputs.error_at(k, state)), shown);
    } else if constexpr (takes_errors<Law, Scalar> && !noisy) {
      torque = law.step(error, heading, shown);
    } else if constexpr (makes_noise<Inputs>) {
      torque = step_with_noise(law, error, heading, inputs.noise_at(k), shown);
    } else if constexpr (noisy) {
      torque = law.step(with_noise(exact, inputs.noise[k]), shown);
    } else {
      torque = law.step(exact, shown);
    }
    // Cost.
    if (k % bound_check_period == bound_check_period - 1) meter.check_bound();
    if (!meter.add(error, torque, reference)) {
      total = meter;
      return k;
    }
    // Delay.
    const TorquePair<Scalar> applied = loop.delay.pass(torque);
    observe(k, state, torque, applied);
    // After the observer, which is shown the feedback that was commanded.
    if constexpr (tells_available<Plant, Scalar> && learns_available<Law, Scalar>) {
      if (plant.has_motors()) law.learn_available(torque, plant.available(state, torque));
    }
    // Move.
    plant.advance(state, heading, applied, inputs.disturbance_at(k));
  }
  loop.robot = state;
  total = meter;
  return last;
}

// A run that the poll stops has no result: what is returned means nothing.
template <bool noisy, class Scalar, class Plant, class Law, class Inputs, class Meter,
          class Observer, class SomePoll>
constexpr LoopResult<Scalar> run_loop(const Plant& plant, Law& law, LoopState<Scalar>& loop,
                                      Inputs& inputs, Meter meter, Observer& observe,
                                      const SomePoll& poll) {
  static_assert(is_plant<Plant, Scalar>, "plant.hpp tells what a plant has");
  const int samples = inputs.samples;
  int done = 0;
  while (done < samples && !poll.is_stopped()) {
    const int last = samples - done > poll.samples ? done + poll.samples : samples;
    done = run_piece<noisy, Scalar>(plant, law, loop, inputs, done, last, meter, observe);
    if (done < last) {
      meter.miss(samples - done - 1);
      break;
    }
  }
  return {meter.mean(samples), done};
}

}  // namespace detail

// As run_closed_loop() below, with another meter than a plain CostMeter, and in pieces between
// which a poll may end the run.
template <class Scalar, class Plant, class Law, class Meter, class Observer,
          class SomePoll = NoPoll>
constexpr LoopResult<Scalar> run_metered_loop(const Plant& plant, Law& law, LoopState<Scalar>& loop,
                                              const LoopInputs<base_t<Scalar>>& inputs,
                                              const Meter& meter, Observer&& observe,
                                              const SomePoll& poll = {}) {
  if (inputs.encoders != nullptr) {
    SensedInputs<Scalar> sensed(inputs, loop.robot);
    return detail::run_loop<true, Scalar>(plant, law, loop, sensed, meter, observe, poll);
  }
  return inputs.noise != nullptr
             ? detail::run_loop<true, Scalar>(plant, law, loop, inputs, meter, observe, poll)
             : detail::run_loop<false, Scalar>(plant, law, loop, inputs, meter, observe, poll);
}

// Runs `law` against `plant` from where `loop` stands, which is then where it ended; of a run that
// diverges the robot's state stays as it was. `observe(k, state, commanded, applied)` is called at
// each sample, before the robot moves; a run that diverges ends before it is called.
template <class Scalar, class Plant, class Law, class Observer, class SomePoll = NoPoll>
constexpr LoopResult<Scalar> run_closed_loop(const Plant& plant, Law& law, LoopState<Scalar>& loop,
                                             const LoopInputs<base_t<Scalar>>& inputs,
                                             Observer&& observe, const SomePoll& poll = {}) {
  return run_metered_loop<Scalar>(
      plant, law, loop, inputs, CostMeter<Scalar>(inputs.divergence_distance, inputs.cost_weights),
      observe, poll);
}

// The same from `state`, with no torque on its way to the wheels.
template <class Scalar, class Plant, class Law, class Observer, class SomePoll = NoPoll>
constexpr LoopResult<Scalar> run_closed_loop(const Plant& plant, Law& law,
                                             const State<Scalar>& state,
                                             const LoopInputs<base_t<Scalar>>& inputs,
                                             Observer&& observe, const SomePoll& poll = {}) {
  LoopState<Scalar> loop{state, DelayLine<Scalar>(inputs.delay)};
  return run_closed_loop<Scalar>(plant, law, loop, inputs, observe, poll);
}

}  // namespace nfopidn
