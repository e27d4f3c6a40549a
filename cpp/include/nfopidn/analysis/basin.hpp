// L4. The basin of attraction: from which initial poses a run ends on its path.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/parallel/thread_pool.hpp"
#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn {

// How far from the reference a run ends: root mean squares over its last samples, infinite for a
// run that diverges.
struct FinalErrors {
  double position = std::numeric_limits<double>::infinity();  // [m]
  double heading = std::numeric_limits<double>::infinity();   // [rad]
};

namespace detail {

template <class Law>
FinalErrors final_errors(const PreparedRun& run, Law& law, const State<double>& start,
                         int last_samples) {
  const LoopInputs<double> inputs = run.inputs();
  const int first = inputs.samples - last_samples;
  double position = 0;
  double heading = 0;
  const auto observe = [&](int k, const State<double>& state, auto&&...) {
    if (k < first) return;
    const Channels<double> error =
        world_errors(Measurement<double>{state.x, state.y, state.theta, 0, 0}, inputs.reference[k]);
    position += error.x * error.x + error.y * error.y;
    heading += error.theta * error.theta;
  };
  law.reset();
  const LoopResult<double> loop =
      run_closed_loop<double>(run.plant, law, start, inputs, observe, run.poll());
  if (loop.completed < inputs.samples) return {};
  return {std::sqrt(position / last_samples), std::sqrt(heading / last_samples)};
}

}  // namespace detail

// The final errors from each of `count` poses (x, y [m], theta [rad]), with the scenario's initial
// velocity. The result does not depend on the number of threads.
NFOPIDN_HOST void basin(const PreparedRun& run, const ControllerDesign& design, const double* poses,
                        std::ptrdiff_t count, int last_samples, int threads, FinalErrors* errors);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST void basin(const PreparedRun& run, const ControllerDesign& design, const double* poses,
                        std::ptrdiff_t count, int last_samples, int threads, FinalErrors* errors) {
  const StandardArithmetic arithmetic;
  // Every so many of them: neighbours take similar times.
  ThreadPool(threads).for_each_share(threads, 1, [&](std::ptrdiff_t from, std::ptrdiff_t shares) {
    with_controller(design, run.limits, [&](auto& law) {
      for (std::ptrdiff_t share = from; share < from + shares; ++share) {
        for (std::ptrdiff_t i = share; i < count; i += threads) {
          State<double> start = run.start;
          start.x = poses[3 * i];
          start.y = poses[3 * i + 1];
          start.theta = poses[3 * i + 2];
          errors[i] = detail::final_errors(run, law, start, last_samples);
        }
      }
    });
  });
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
