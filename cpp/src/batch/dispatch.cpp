// Chooses the unit for this processor. Compiled for the plain architecture.
#include "nfopidn/rivals/rival_job.hpp"
#include "nfopidn/tuning/batch.hpp"
#include "nfopidn/tuning/monte_carlo_job.hpp"

namespace nfopidn {

#if defined(__x86_64__)
void run_batch_sse2(const BatchJob& job);
void run_batch_avx2(const BatchJob& job);
void run_batch_avx512(const BatchJob& job);
void run_gradient_sse2(const GradientJob& job);
void run_rivals_sse2(const RivalJob& job);
void run_rival_gradient_sse2(const RivalGradientJob& job);
void run_monte_carlo_sse2(const MonteCarloJob& job);
void record_monte_carlo_sse2(const MonteCarloJob& job);
void run_gradient_avx2(const GradientJob& job);
void run_rivals_avx2(const RivalJob& job);
void run_rival_gradient_avx2(const RivalGradientJob& job);
void run_monte_carlo_avx2(const MonteCarloJob& job);
void record_monte_carlo_avx2(const MonteCarloJob& job);
void run_gradient_avx512(const GradientJob& job);
void run_rivals_avx512(const RivalJob& job);
void run_rival_gradient_avx512(const RivalGradientJob& job);
void run_monte_carlo_avx512(const MonteCarloJob& job);
void record_monte_carlo_avx512(const MonteCarloJob& job);
#else
void run_batch_generic(const BatchJob& job);
void run_gradient_generic(const GradientJob& job);
void run_rivals_generic(const RivalJob& job);
void run_rival_gradient_generic(const RivalGradientJob& job);
void run_monte_carlo_generic(const MonteCarloJob& job);
void record_monte_carlo_generic(const MonteCarloJob& job);
#endif

BatchKernels batch_kernels(InstructionSet set) noexcept {
#if defined(__x86_64__)
  __builtin_cpu_init();
  switch (set) {
    case InstructionSet::avx512:
      if (!__builtin_cpu_supports("avx512f") || !__builtin_cpu_supports("avx512dq") ||
          !__builtin_cpu_supports("avx512vl")) {
        break;
      }
      return {run_batch_avx512,          run_gradient_avx512,    run_rivals_avx512,
              run_rival_gradient_avx512, run_monte_carlo_avx512, record_monte_carlo_avx512};
    case InstructionSet::avx2:
      if (!__builtin_cpu_supports("avx2")) break;
      return {run_batch_avx2,          run_gradient_avx2,    run_rivals_avx2,
              run_rival_gradient_avx2, run_monte_carlo_avx2, record_monte_carlo_avx2};
    case InstructionSet::sse2:
      return {run_batch_sse2,          run_gradient_sse2,    run_rivals_sse2,
              run_rival_gradient_sse2, run_monte_carlo_sse2, record_monte_carlo_sse2};
    case InstructionSet::generic:
      break;
  }
#else
  if (set == InstructionSet::generic)
    return {run_batch_generic,          run_gradient_generic,    run_rivals_generic,
            run_rival_gradient_generic, run_monte_carlo_generic, record_monte_carlo_generic};
#endif
  return {};
}

InstructionSet best_instruction_set() noexcept {
  for (const InstructionSet set :
       {InstructionSet::avx512, InstructionSet::avx2, InstructionSet::sse2}) {
    if (batch_kernels(set).costs != nullptr) return set;
  }
  return InstructionSet::generic;
}

}  // namespace nfopidn
