#include "kernel.hpp"
#include "monte_carlo_kernel.hpp"
#include "rivals_kernel.hpp"

namespace nfopidn {

void run_batch_avx2(const BatchJob& job) { run_batch<4, 4>(job); }

void run_gradient_avx2(const GradientJob& job) { run_gradient<4, 2, 3>(job); }

void run_rivals_avx2(const RivalJob& job) { run_rival_batch<4>(job); }

void run_rival_gradient_avx2(const RivalGradientJob& job) { run_rival_gradient<4>(job); }

void run_monte_carlo_avx2(const MonteCarloJob& job) { run_monte_carlo<4, 4>(job); }

void record_monte_carlo_avx2(const MonteCarloJob& job) { run_monte_carlo<4, 2, true>(job); }

}  // namespace nfopidn
