// L3. The inner loops of long memory: eight numbers side by side, by AVX2 where the processor has
// it. The sums are made in the same order everywhere, so that the result is the same to the bit.
#pragma once

namespace nfopidn::wide {

// Eight decaying modes: x <- (1 - decay) x + residue coming - end leaving. A cache line each.
struct alignas(64) Modes {
  double decay[8];
  double residue[8];
  double end[8];
  double state[8];
};

struct Loops {
  // sum a_i b_i; count is a multiple of eight.
  double (*dot)(const double* a, const double* b, long count);
  // All states one sample on, and their sum; the first `ending` of `count` blocks have ends.
  double (*advance)(Modes* modes, long count, long ending, double coming, double leaving);
};

}  // namespace nfopidn::wide

#define NFOPIDN_WIDE_SET anywhere
#define NFOPIDN_WIDE_NUMBERS 2
#include "nfopidn/long_memory/wide_loops.hpp"
#undef NFOPIDN_WIDE_SET
#undef NFOPIDN_WIDE_NUMBERS

#if defined(__x86_64__)
// Without fused multiplication, which would round otherwise.
#if defined(__clang__)
#pragma clang attribute push(__attribute__((target("avx2,no-fma"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,no-fma")
#endif
#define NFOPIDN_WIDE_SET avx2
#define NFOPIDN_WIDE_NUMBERS 4
#include "nfopidn/long_memory/wide_loops.hpp"
#undef NFOPIDN_WIDE_SET
#undef NFOPIDN_WIDE_NUMBERS
#if defined(__clang__)
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

namespace nfopidn::wide {

inline constexpr Loops plain = {anywhere::dot, anywhere::advance};

// The fastest of this processor.
inline const Loops& loops() noexcept {
#if defined(__x86_64__)
  static const Loops fastest =
      static_cast<bool>(__builtin_cpu_supports("avx2")) ? Loops{avx2::dot, avx2::advance} : plain;
  return fastest;
#else
  return plain;
#endif
}

}  // namespace nfopidn::wide
