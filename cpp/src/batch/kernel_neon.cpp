#include "kernel.hpp"

namespace nfopidn {

void run_batch_neon(const BatchJob& job) { run_batch<2, 4>(job); }

void run_gradient_neon(const GradientJob& job) { run_gradient<2, 6>(job); }

}  // namespace nfopidn
