// Vector by vector, what compilers do not make one instruction of by themselves.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "lanes.hpp"

namespace nfopidn {

template <int width>
struct Instructions {
  using Real = typename Vectors<width>::Real;
  using Bits = typename Vectors<width>::Bits;

  // b < a ? b : a, and a < b ? b : a, as one instruction where there is one.
  NFOPIDN_INLINE static Real smaller(const Real& a, const Real& b) {
#if defined(__x86_64__)
    if constexpr (width == 2) return _mm_min_pd(b, a);
#if defined(__AVX__)
    if constexpr (width == 4) return _mm256_min_pd(b, a);
#endif
#if defined(__AVX512F__)
    if constexpr (width == 8) return _mm512_min_pd(b, a);
#endif
#endif
    return b < a ? b : a;
  }
  NFOPIDN_INLINE static Real larger(const Real& a, const Real& b) {
#if defined(__x86_64__)
    if constexpr (width == 2) return _mm_max_pd(b, a);
#if defined(__AVX__)
    if constexpr (width == 4) return _mm256_max_pd(b, a);
#endif
#if defined(__AVX512F__)
    if constexpr (width == 8) return _mm512_max_pd(b, a);
#endif
#endif
    return a < b ? b : a;
  }
  // The square root of each.
  NFOPIDN_INLINE static Real root(const Real& a) {
#if defined(__x86_64__)
    if constexpr (width == 2) return _mm_sqrt_pd(a);
#if defined(__AVX__)
    if constexpr (width == 4) return _mm256_sqrt_pd(a);
#endif
#if defined(__AVX512F__)
    if constexpr (width == 8) return _mm512_sqrt_pd(a);
#endif
#endif
    Real result = a;
    for (int i = 0; i < width; ++i) result[i] = __builtin_sqrt(a[i]);
    return result;
  }
  NFOPIDN_INLINE static Real clip(const Real& value, double limit) {
    return larger(smaller(value, Real{} + limit), Real{} - limit);
  }
  // Whether no number is over the limit, nor not a number.
  NFOPIDN_INLINE static bool all_under(const Real& value, double limit) {
    const Real bar = Real{} + limit;
#if defined(__x86_64__)
    if constexpr (width == 2) return _mm_movemask_pd(_mm_cmple_pd(value, bar)) == 3;
#if defined(__AVX__)
    if constexpr (width == 4) {
      return _mm256_movemask_pd(_mm256_cmp_pd(value, bar, _CMP_LE_OQ)) == 15;
    }
#endif
#if defined(__AVX512F__)
    if constexpr (width == 8) return _mm512_cmp_pd_mask(value, bar, _CMP_LE_OQ) == 255;
#endif
#endif
    return !any_bit(~(value <= bar));
  }
  // Whether any number is over the limit.
  NFOPIDN_INLINE static bool any_over(const Real& value, double limit) {
    const Real bar = Real{} + limit;
#if defined(__x86_64__)
    if constexpr (width == 2) return _mm_movemask_pd(_mm_cmpgt_pd(value, bar)) != 0;
#if defined(__AVX__)
    if constexpr (width == 4) {
      return _mm256_movemask_pd(_mm256_cmp_pd(value, bar, _CMP_GT_OQ)) != 0;
    }
#endif
#if defined(__AVX512F__)
    if constexpr (width == 8) return _mm512_cmp_pd_mask(value, bar, _CMP_GT_OQ) != 0;
#endif
#endif
    return any_bit(value > bar);
  }
  NFOPIDN_INLINE static bool any_bit(const Bits& bits) {
#if defined(__x86_64__)
    if constexpr (width == 2) return _mm_movemask_pd(reinterpret_cast<Real>(bits)) != 0;
#if defined(__AVX__)
    if constexpr (width == 4) return _mm256_movemask_pd(reinterpret_cast<Real>(bits)) != 0;
#endif
#if defined(__AVX512F__)
    if constexpr (width == 8)
      return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(bits),
                                    reinterpret_cast<__m512i>(bits)) != 0;
#endif
#endif
    std::int64_t some = 0;
    for (int i = 0; i < width; ++i) some |= bits[i];
    return some != 0;
  }

  // The larger of a distance and that of b from zero.
  NFOPIDN_INLINE static Real farther(const Real& distance, const Real& b) {
#if defined(__AVX512DQ__)
    constexpr int of_magnitudes = 0b1011;
    if constexpr (width == 8) return _mm512_range_pd(distance, b, of_magnitudes);
#endif
    const std::int64_t sign = ~(std::int64_t{1} << 63);
    return larger(distance, reinterpret_cast<Real>(reinterpret_cast<Bits>(b) & sign));
  }
};

}  // namespace nfopidn
