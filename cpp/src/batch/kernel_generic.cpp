// For every processor without units of its own: two numbers a vector, which the compiler turns into
// NEON on aarch64, SIMD on WebAssembly, and into single numbers where there are no vectors.
#include "kernel.hpp"
#include "monte_carlo_kernel.hpp"
#include "rivals_kernel.hpp"

namespace nfopidn {

void run_batch_generic(const BatchJob& job) { run_batch<2, 4>(job); }

void run_gradient_generic(const GradientJob& job) { run_gradient<2, 3, 6>(job); }

void run_rivals_generic(const RivalJob& job) { run_rival_batch<2>(job); }

void run_rival_gradient_generic(const RivalGradientJob& job) { run_rival_gradient<2>(job); }

void run_monte_carlo_generic(const MonteCarloJob& job) { run_monte_carlo<2, 4>(job); }

void record_monte_carlo_generic(const MonteCarloJob& job) { run_monte_carlo<2, 2, true>(job); }

}  // namespace nfopidn
