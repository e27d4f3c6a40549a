// What lanes compute otherwise than a single number: elementary functions and comparisons.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "lanes.hpp"

namespace nfopidn {

// Angles in half turns, so that their range reduction is x - round(x). Nets in a unit in which the
// neuron's polynomial for small nets has no leading factor.
template <int width, int count>
struct math<Lanes<width, count>> {
  using Base = double;
  using Scalar = Lanes<width, count>;
  using Mask = typename Scalar::Mask;
  using Real = typename Vectors<width>::Real;
  using Bits = typename Vectors<width>::Bits;

  static constexpr Base pi = 3.14159265358979323846;
  static constexpr Base angle_unit = 1 / pi;
  using Constants = kernel::Coefficients<double>;
  static constexpr Base net_scale = 0.32181959892097086843;
  static constexpr bool has_order = false;

  static constexpr Base magic = 6755399441055744.0;  // 1.5 * 2^52: rounds to whole numbers
  static constexpr Base magic_even = 2 * magic;      // rounds to even numbers

  // sqrt(2) sin(pi/2 r)/r and sqrt(2) cos(pi/2 r) in powers of r^2, |r| <= 1/2: then
  // cos(pi r) = 1 - s^2 and sin(pi r) = s c. Relative errors 3.3e-18 and 5.6e-17.
  static constexpr Base half_sine[] = {2.2214414690791831162,     -0.91353118749942699272,
                                       0.11270239285827922222,    -0.0066210001895701277297,
                                       0.00022689805070553731296, -5.0892479762269591237e-6,
                                       7.9672847516788226626e-8};
  static constexpr Base half_cosine[] = {1.41421356237309497,      -1.7447160499096903153,
                                         0.35874285843233976524,   -0.029505417411000441335,
                                         0.0013000298682369860295, -0.000035638300733999613738,
                                         6.5826230631508253878e-7};

  // tanh(n/2)/n in powers of n^2 and in units of net_scale, |n| <= small_net; the leading
  // coefficient is 1. Relative error 1.4e-15.
  static constexpr Base small_neuron[] = {1.5536654749320725318,   -1.250118811944810972494,
                                          1.207052918948234131515, -1.17934445667778943232,
                                          1.153521777335808097172, -1.124460749845161327157};
  static constexpr Base small_net = 0.53125;
  static constexpr Base small_square = (small_net * net_scale) * (small_net * net_scale);

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
  NFOPIDN_INLINE static Real clip(const Real& value, Base limit) {
    return larger(smaller(value, Real{} + limit), Real{} - limit);
  }
  // Whether no number is over the limit, nor not a number.
  NFOPIDN_INLINE static bool all_under(const Real& value, Base limit) {
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
  NFOPIDN_INLINE static bool any_over(const Real& value, Base limit) {
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

  // Estrin's scheme, of seven terms: half the waiting for two operations more.
  NFOPIDN_INLINE static Real estrin(const Real& x, const Real& x2, const Real& x4,
                                    const Base (&a)[7]) {
    return ((a[0] + a[1] * x) + (a[2] + a[3] * x) * x2) + ((a[4] + a[5] * x) + a[6] * x2) * x4;
  }

  // Horner's scheme: fewest operations; the other vectors fill the waiting.
  template <int terms>
  NFOPIDN_INLINE static Real horner(const Real& x, const Base (&coefficients)[terms]) {
    Real sum = x * coefficients[terms - 1] + coefficients[terms - 2];
    for (int i = terms - 3; i >= 0; --i) sum = sum * x + coefficients[i];
    return sum;
  }

  // The whole number of half turns nearest to an angle, and 1 or -1 as it is even or odd:
  // remembered, for angles that change little from one to the next.
  struct Turn {
    Real whole[count];
    Real sign[count];
  };
  NFOPIDN_INLINE static Turn no_turn() {
    Turn turn;
    for (int i = 0; i < count; ++i) {
      turn.whole[i] = Real{};
      turn.sign[i] = Real{} + 1.0;
    }
    return turn;
  }

  NFOPIDN_INLINE static Heading<Scalar> heading(const Scalar& angle) {
    Turn turn = turn_of(angle);
    return heading(angle, turn);
  }

  // The same to the last bit, sooner while no angle leaves its half turn.
  NFOPIDN_INLINE static Heading<Scalar> heading(const Scalar& angle, Turn& turn) {
    Real r[count], square[count], s[count], c[count];
    Real farthest = Real{};
    for (int i = 0; i < count; ++i) {
      r[i] = angle.part[i] - turn.whole[i];
      square[i] = r[i] * r[i];
      farthest = larger(farthest, square[i]);
    }
    if (__builtin_expect(any_over(farthest, 0.25), 0)) {
      turn = turn_of(angle);
      for (int i = 0; i < count; ++i) {
        r[i] = angle.part[i] - turn.whole[i];
        square[i] = r[i] * r[i];
      }
    }
    Real fourth[count], eighth[count];
    for (int i = 0; i < count; ++i) fourth[i] = square[i] * square[i];
    for (int i = 0; i < count; ++i) eighth[i] = fourth[i] * fourth[i];
    for (int i = 0; i < count; ++i) {
      s[i] = estrin(square[i], fourth[i], eighth[i], half_sine);
      c[i] = estrin(square[i], fourth[i], eighth[i], half_cosine);
    }
    Heading<Scalar> result;
    for (int i = 0; i < count; ++i) {
      s[i] = s[i] * r[i];
      const Real signed_sine = s[i] * turn.sign[i];
      result.sine.part[i] = signed_sine * c[i];
      result.cosine.part[i] = turn.sign[i] - signed_sine * s[i];
    }
    return result;
  }

  // To [-1, 1] half turns.
  NFOPIDN_INLINE static Scalar wrap(const Scalar& angle) {
    return angle - ((angle + magic_even) - magic_even);
  }

  // All channels together, a stage after the other: their chains hide each other's waiting.
  template <class Three>
  NFOPIDN_INLINE static void sigmoids(Three& net) {
    Scalar* const channels[] = {&net.x, &net.y, &net.theta};
    Real value[chains], square[chains];
    Real largest = Real{};
    for (int i = 0; i < chains; ++i) {
      value[i] = channels[i / count]->part[i % count];
      square[i] = value[i] * value[i];
      largest = larger(largest, square[i]);
    }
    Real output[chains];
    small_sigmoids(value, square, output);
    if (__builtin_expect(any_over(largest, small_square), 0)) large_sigmoids(value, square, output);
    for (int i = 0; i < chains; ++i) channels[i / count]->part[i % count] = output[i];
  }

  NFOPIDN_INLINE static Scalar identity(const Scalar& net) { return net * (1 / net_scale); }
  NFOPIDN_INLINE static Scalar from_radians(const Scalar& angle) { return angle * angle_unit; }
  NFOPIDN_INLINE static Base base_from_radians(Base angle) { return angle * angle_unit; }
  NFOPIDN_INLINE static Scalar to_radians(const Scalar& angle) { return angle * pi; }

  NFOPIDN_INLINE static Scalar minimum(const Scalar& a, const Scalar& b) {
    Scalar result;
    for (int i = 0; i < count; ++i) result.part[i] = smaller(a.part[i], b.part[i]);
    return result;
  }
  NFOPIDN_INLINE static Scalar maximum(const Scalar& a, const Scalar& b) {
    Scalar result;
    for (int i = 0; i < count; ++i) result.part[i] = larger(a.part[i], b.part[i]);
    return result;
  }
  NFOPIDN_INLINE static Scalar select(const Mask& mask, const Scalar& yes, const Scalar& no) {
    Scalar result;
    for (int i = 0; i < count; ++i) result.part[i] = mask.part[i] ? yes.part[i] : no.part[i];
    return result;
  }
  // By their sum, in one comparison.
  NFOPIDN_INLINE static bool surely_under(const Scalar& amount, Base limit) {
    Real sum = amount.part[0];
    for (int i = 1; i < count; ++i) sum = sum + amount.part[i];
    return all_under(sum, limit);
  }
  NFOPIDN_INLINE static bool every(const Mask& mask) {
    Bits joined = mask.part[0];
    for (int i = 1; i < count; ++i) joined &= mask.part[i];
    return !any_bit(~joined);
  }
  NFOPIDN_INLINE static bool within(const Scalar& a, const Scalar& b, Base limit) {
    Real farthest = Real{};
    for (int i = 0; i < count; ++i) {
      farthest = farther(farther(farthest, a.part[i]), b.part[i]);
    }
    return !any_over(farthest, limit);
  }
  NFOPIDN_INLINE static Mask all() {
    Mask mask;
    for (auto& p : mask.part) p = Bits{} - 1;
    return mask;
  }
  NFOPIDN_INLINE static bool any(const Mask& mask) {
    Bits joined = mask.part[0];
    for (int i = 1; i < count; ++i) joined |= mask.part[i];
    return any_bit(joined);
  }

 private:
  static constexpr int chains = 3 * count;

  // The larger of a distance and that of b from zero.
  NFOPIDN_INLINE static Real farther(const Real& distance, const Real& b) {
#if defined(__AVX512DQ__)
    constexpr int of_magnitudes = 0b1011;
    if constexpr (width == 8) return _mm512_range_pd(distance, b, of_magnitudes);
#endif
    const std::int64_t sign = ~(std::int64_t{1} << 63);
    return larger(distance, reinterpret_cast<Real>(reinterpret_cast<Bits>(b) & sign));
  }

  NFOPIDN_INLINE static Turn turn_of(const Scalar& angle) {
    Turn turn;
    for (int i = 0; i < count; ++i) {
      const Real shifted = angle.part[i] + magic;
      turn.whole[i] = shifted - magic;
      const Bits odd = reinterpret_cast<Bits>(shifted) << 63;
      turn.sign[i] = reinterpret_cast<Real>(reinterpret_cast<Bits>(Real{} + 1.0) ^ odd);
    }
    return turn;
  }

  NFOPIDN_INLINE static void small_sigmoids(const Real (&net)[chains], const Real (&square)[chains],
                                            Real (&output)[chains]) {
    Real fourth[chains], odd[chains];
    for (int i = 0; i < chains; ++i) {
      fourth[i] = square[i] * square[i];
      odd[i] = fourth[i] * small_neuron[5] + small_neuron[3];
      output[i] = fourth[i] + small_neuron[4];
    }
    for (int i = 0; i < chains; ++i) {
      odd[i] = odd[i] * fourth[i] + small_neuron[1];
      output[i] = output[i] * fourth[i] + small_neuron[2];
    }
    for (int i = 0; i < chains; ++i) {
      output[i] = (output[i] * fourth[i] + small_neuron[0]) + odd[i] * square[i];
    }
    for (int i = 0; i < chains; ++i) output[i] = output[i] * net[i];
  }

  // By the exponential function, where a net is not small.
  NFOPIDN_INLINE static void large_sigmoids(const Real (&net)[chains], const Real (&square)[chains],
                                            Real (&output)[chains]) {
    constexpr Base saturation = 60;  // in powers of two: 1 - 2^-60 is 1
    constexpr Base powers = 1.44269504088896340736 / net_scale;
    Real f[chains], f_square[chains], odd[chains], even[chains];
    Bits exponent[chains];
    for (int i = 0; i < chains; ++i) {
      const Real power = clip(net[i] * powers, saturation);
      const Real shifted = power + magic;
      f[i] = power - (shifted - magic);
      exponent[i] = reinterpret_cast<Bits>(shifted) << 52;
      f_square[i] = f[i] * f[i];
    }
    for (int i = 0; i < chains; ++i) odd[i] = horner(f_square[i], Constants::exponential_q) * f[i];
    for (int i = 0; i < chains; ++i) even[i] = horner(f_square[i], Constants::exponential_p);
    Real above[chains], below[chains];
    for (int i = 0; i < chains; ++i) {
      const Real high =
          reinterpret_cast<Real>(reinterpret_cast<Bits>(even[i] + odd[i]) + exponent[i]);
      const Real low = even[i] - odd[i];
      above[i] = high - low;
      below[i] = high + low;
    }
    // One division for the three channels.
    for (int i = 0; i < count; ++i) {
      const Real& x = below[i];
      const Real& y = below[count + i];
      const Real& theta = below[2 * count + i];
      const Real pair = x * y;
      const Real all = 1.0 / (pair * theta);
      const Real pair_inverse = all * theta;
      above[i] = above[i] * (pair_inverse * y);
      above[count + i] = above[count + i] * (pair_inverse * x);
      above[2 * count + i] = above[2 * count + i] * (all * pair);
    }
    for (int i = 0; i < chains; ++i) {
      output[i] = square[i] > small_square ? above[i] : output[i];
    }
  }
};

}  // namespace nfopidn
