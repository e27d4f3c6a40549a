// L4. Costs of many candidates at once, on wide instructions chosen at run time.
#pragma once

#include <memory>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/math/dual.hpp"
#include "nfopidn/simulation/simulate.hpp"
#include "nfopidn/tuning/batch_job.hpp"

namespace nfopidn {

// generic: what the compiler makes of vectors of two on a processor that is not x86-64 (NEON on
// aarch64).
enum class InstructionSet : unsigned char { sse2, avx2, avx512, generic };

template <>
struct ChoiceNames<InstructionSet> {
  static constexpr const char* names[] = {"sse2", "avx2", "avx512", "generic"};
};

struct RivalJob;
struct RivalGradientJob;
struct MonteCarloJob;

struct BatchKernels {
  void (*costs)(const BatchJob&) = nullptr;
  void (*gradient)(const GradientJob&) = nullptr;
  void (*rival_costs)(const RivalJob&) = nullptr;
  void (*rival_gradient)(const RivalGradientJob&) = nullptr;
  void (*monte_carlo)(const MonteCarloJob&) = nullptr;
  // The same with its samples, to the same bits.
  void (*record)(const MonteCarloJob&) = nullptr;
};

// The widest instruction set of this processor, of those built in.
InstructionSet best_instruction_set() noexcept;

// One that every processor has, for a single run.
constexpr InstructionSet narrowest_instruction_set() noexcept {
#if defined(__x86_64__)
  return InstructionSet::sse2;
#else
  return InstructionSet::generic;
#endif
}

// Null pointers for one that this build or this processor does not have.
BatchKernels batch_kernels(InstructionSet set) noexcept;

// One scenario and structure, many candidates. The costs are the same to the last bit on every
// instruction set and in any company. Memories beyond 32 run one candidate at a time.
class BatchEvaluator {
 public:
  // The scenario behind `run` must outlive this.
  BatchEvaluator(PreparedRun run, const ControllerSettings<double>& structure);

  void set_instruction_set(InstructionSet set);

  int tap_count() const { return structure_.memory + 2; }
  // Numbers of a candidate's law.
  int law_size() const { return nfopidn::law_size(structure_, tap_count()); }
  const ControllerSettings<double>& structure() const { return structure_; }
  const PreparedRun& run() const { return run_; }

  // laws: [candidates][law_size], costs and bounds: [candidates]. A candidate that costs more
  // than its bound is given some cost over it, mostly for less work.
  void costs_of_laws(const double* laws, int candidates, double* costs,
                     const double* bounds = nullptr) const;

  // The cost of one candidate's law, [law_size], and its slopes in the directions in which its
  // numbers change by slopes, [directions][law_size].
  double gradient(const double* law, const double* slopes, int directions, double* result) const;

 private:
  BatchJob job(const LoopInputs<double>& inputs, const double* laws, int count, double* costs,
               const double* bounds) const {
    return {&run_.plant, &inputs,      &run_.start,
            &structure_, &run_.limits, laws,
            tap_count(), law_size(),   run_.scenario->initial_velocity.reference,
            count,       costs,        bounds,
            run_.poll()};
  }

  double directional(const double* numbers, const double* slopes, double& slope) const;

  template <class Law, class Number>
  void set_numbers(Law& law, const Number* numbers) const {
    const int row = tap_count();
    if constexpr (Law::Structure::has_tracking_law) {
      law.set_law(numbers, row,
                  law_parameters_from<Number>(numbers + channel_count * row,
                                              [](const Number& number) { return number; }));
    } else {
      law.set_taps(numbers, numbers + row, numbers + 2 * row, row);
    }
  }

  template <class Law>
  double slope_of(Law& law, const Dual<double>* numbers, double& slope) const {
    using Scalar = Dual<double>;
    law.configure_structure(structure_, run_.limits);
    set_numbers(law, numbers);
    detail::restart(law, *run_.scenario);
    const State<double>& s = run_.start;
    const State<Scalar> start = {Scalar(s.x), Scalar(s.y), Scalar(s.theta), Scalar(s.v),
                                 Scalar(s.omega)};
    const LoopResult<Scalar> result = run_closed_loop<Scalar>(
        run_.plant, law, start, run_.inputs(), [](int, auto&&...) {}, run_.poll());
    slope = result.cost.slope;
    return result.cost.value;
  }

  void run_one_by_one(const double* laws, int count, double* costs, const double* bounds) const;

  PreparedRun run_;
  ControllerSettings<double> structure_;
  std::vector<Heading<double>> headings_;  // of the reference
  BatchKernels kernels_;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_TUNING

namespace nfopidn {

NFOPIDN_HOST BatchEvaluator::BatchEvaluator(PreparedRun run,
                                            const ControllerSettings<double>& structure)
    : run_(std::move(run)), structure_(structure) {
  const StandardArithmetic arithmetic;
  headings_ = run_.reference_headings();
  set_instruction_set(best_instruction_set());
}

NFOPIDN_HOST void BatchEvaluator::set_instruction_set(InstructionSet set) {
  const bool has_lanes = tap_count() <= batch_capacity && !run_.encoders;
  kernels_ = has_lanes ? batch_kernels(set) : BatchKernels{};
}

NFOPIDN_HOST void BatchEvaluator::costs_of_laws(const double* laws, int candidates, double* costs,
                                                const double* bounds) const {
  const StandardArithmetic arithmetic;
  if (kernels_.costs == nullptr) {
    run_one_by_one(laws, candidates, costs, bounds);
    return;
  }
  LoopInputs<double> inputs = run_.inputs();
  inputs.headings = headings_.data();
  kernels_.costs(job(inputs, laws, candidates, costs, bounds));
}

NFOPIDN_HOST double BatchEvaluator::gradient(const double* law, const double* slopes,
                                             int directions, double* result) const {
  const StandardArithmetic arithmetic;
  double cost = 0;
  if (kernels_.gradient != nullptr) {
    const LoopInputs<double> inputs = run_.inputs();
    kernels_.gradient({job(inputs, law, 1, &cost, nullptr), slopes, directions, result});
    return cost;
  }
  for (int i = 0; i < directions; ++i) {
    const auto place = static_cast<std::ptrdiff_t>(i) * law_size();
    cost = directional(law, slopes + place, result[i]);
  }
  return cost;
}

NFOPIDN_HOST double BatchEvaluator::directional(const double* numbers, const double* slopes,
                                                double& slope) const {
  using Scalar = Dual<double>;
  using Filter = Fir<Scalar, maximum_memory + 2>;
  std::vector<Scalar> own(static_cast<std::size_t>(law_size()));
  for (std::size_t i = 0; i < own.size(); ++i) own[i] = {numbers[i], slopes[i]};
  if (structure_.needs_tracking_law()) {
    auto law = std::make_unique<Controller<Scalar, Filter, TrackingVariant<double>>>();
    return slope_of(*law, own.data(), slope);
  }
  auto law = std::make_unique<Controller<Scalar, Filter>>();
  return slope_of(*law, own.data(), slope);
}

NFOPIDN_HOST void BatchEvaluator::run_one_by_one(const double* laws, int count, double* costs,
                                                 const double* bounds) const {
  const LoopInputs<double> inputs = run_.inputs();
  with_tap_controller(structure_, run_.limits, [&](auto& law) {
    for (int i = 0; i < count; ++i) {
      set_numbers(law, laws + static_cast<std::ptrdiff_t>(i) * law_size());
      detail::restart(law, *run_.scenario);
      LoopState<double> loop{run_.start, DelayLine<double>(inputs.delay)};
      const BoundedMeter<double> meter(inputs, bounds == nullptr ? no_bound : bounds[i]);
      costs[i] = run_metered_loop<double>(
                     run_.plant, law, loop, inputs, meter, [](int, auto&&...) {}, run_.poll())
                     .cost;
    }
  });
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_TUNING
