#include "kernel.hpp"

namespace nfopidn {

void run_batch_avx2(const BatchJob& job) { run_batch<4, 4>(job); }

void run_gradient_avx2(const GradientJob& job) { run_gradient<4, 3>(job); }

}  // namespace nfopidn
