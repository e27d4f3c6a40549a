// L0. What the compiler has to do as it is told: settings under which the arithmetic would come out
// wrong are refused here, and rounding survives those that no compiler reports.
#pragma once

#if __cplusplus < 201703L
#error "nfopidn needs C++17 or newer: compile with -std=c++17"
#endif
#if !defined(__has_builtin)
#error "nfopidn needs GCC 11, Clang 9 or newer"
#elif !__has_builtin(__builtin_bit_cast) || !__has_builtin(__builtin_is_constant_evaluated)
#error "nfopidn needs GCC 11, Clang 9 or newer"
#endif

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error \
    "nfopidn rounds by adding and subtracting; compile it without -ffast-math, -Ofast, \
-funsafe-math-optimizations, -fassociative-math and -freciprocal-math"
#endif
#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__
#error \
    "nfopidn looks for NaN in measurements; compile it without -ffinite-math-only and -ffast-math"
#endif
// 0 and 16: float and double are computed as such.
#if defined(__FLT_EVAL_METHOD__) && __FLT_EVAL_METHOD__ != 0 && __FLT_EVAL_METHOD__ != 16
#error \
    "nfopidn needs float and double arithmetic without excess precision: on 32-bit x86 compile \
with -msse2 -mfpmath=sse, on s390x without -std=c++NN (with -std=gnu++17)"
#endif

#include "nfopidn/foundation/inlining.hpp"

// Clang, and GCC before 12, do not report all options with which sums are rearranged. There an
// empty assembler instruction hides a sum from what follows. GCC from 12 on reports them, and its
// code stays as it is.
#if defined(__clang__) || __GNUC__ < 12
#define NFOPIDN_HIDES_SUMS 1
#if defined(__x86_64__) || defined(__i386__)
#define NFOPIDN_SINGLE "+v"
#define NFOPIDN_DOUBLE "+v"
#define NFOPIDN_VECTOR "+v"
#elif defined(__aarch64__)
#define NFOPIDN_SINGLE "+w"
#define NFOPIDN_DOUBLE "+w"
#define NFOPIDN_VECTOR "+w"
#elif defined(__arm__) && defined(__ARM_FP) && !defined(__SOFTFP__)
#define NFOPIDN_SINGLE "+t"
#elif defined(__riscv_flen) && __riscv_flen >= 64
#define NFOPIDN_SINGLE "+f"
#define NFOPIDN_DOUBLE "+f"
#endif
// Through memory is right everywhere.
#if !defined(NFOPIDN_SINGLE)
#define NFOPIDN_SINGLE "+m"
#endif
#if !defined(NFOPIDN_DOUBLE)
#define NFOPIDN_DOUBLE "+m"
#endif
#if !defined(NFOPIDN_VECTOR)
#define NFOPIDN_VECTOR "+m"
#endif
#endif

namespace nfopidn::kernel {

#if defined(NFOPIDN_HIDES_SUMS)
NFOPIDN_INLINE float hidden(float value) noexcept {
  __asm__("" : NFOPIDN_SINGLE(value));
  return value;
}
NFOPIDN_INLINE double hidden(double value) noexcept {
  __asm__("" : NFOPIDN_DOUBLE(value));
  return value;
}
template <class Vector>
NFOPIDN_INLINE Vector hidden(Vector value) noexcept {
  __asm__("" : NFOPIDN_VECTOR(value));
  return value;
}
#undef NFOPIDN_HIDES_SUMS
#undef NFOPIDN_SINGLE
#undef NFOPIDN_DOUBLE
#undef NFOPIDN_VECTOR

// The value itself, of which the compiler does not know how it came about. Around both the sum and
// the difference that round: otherwise x - ((x + magic) - magic), the sum hidden alone, would
// become (x + magic) - sum, which is 0.
template <class Value>
NFOPIDN_INLINE constexpr Value opaque(const Value& value) noexcept {
  if (__builtin_is_constant_evaluated()) return value;
  return hidden(value);
}
#else
template <class Value>
NFOPIDN_INLINE constexpr Value opaque(const Value& value) noexcept {
  return value;
}
#endif

}  // namespace nfopidn::kernel
