// For processors older than AVX2 (2013), which are few: blocks of one size alone, since each size
// is compiled for each law.
#include "kernel.hpp"
#include "monte_carlo_kernel.hpp"
#include "rivals_kernel.hpp"

namespace nfopidn {

void run_batch_sse2(const BatchJob& job) { run_batch<2, 4, 4>(job); }

void run_gradient_sse2(const GradientJob& job) { run_gradient<2, 6>(job); }

void run_rivals_sse2(const RivalJob& job) { run_rival_batch<2>(job); }

void run_rival_gradient_sse2(const RivalGradientJob& job) { run_rival_gradient<2>(job); }

void run_monte_carlo_sse2(const MonteCarloJob& job) { run_monte_carlo<2, 4>(job); }

void record_monte_carlo_sse2(const MonteCarloJob& job) { run_monte_carlo<2, 2, true>(job); }

}  // namespace nfopidn
