#include "kernel.hpp"
#include "monte_carlo_kernel.hpp"
#include "rivals_kernel.hpp"

namespace nfopidn {

void run_batch_avx512(const BatchJob& job) { run_batch<8, 4>(job); }

void run_gradient_avx512(const GradientJob& job) { run_gradient<8, 1, 2, 3>(job); }

void run_rivals_avx512(const RivalJob& job) { run_rival_batch<8>(job); }

void run_rival_gradient_avx512(const RivalGradientJob& job) { run_rival_gradient<8>(job); }

void run_monte_carlo_avx512(const MonteCarloJob& job) { run_monte_carlo<8, 4>(job); }

void record_monte_carlo_avx512(const MonteCarloJob& job) { run_monte_carlo<8, 2, true>(job); }

}  // namespace nfopidn
