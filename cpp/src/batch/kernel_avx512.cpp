#include "kernel.hpp"

namespace nfopidn {

void run_batch_avx512(const BatchJob& job) { run_batch<8, 4>(job); }

void run_gradient_avx512(const GradientJob& job) { run_gradient<8, 2>(job); }

}  // namespace nfopidn
