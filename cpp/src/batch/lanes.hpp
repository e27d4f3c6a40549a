// Many candidates at once: a Scalar of `count` vectors of `width` doubles.
//
// GCC's and Clang's vector extensions; the compiler turns them into whatever instructions the
// translation unit may use. Several vectors a Scalar give the processor independent work while one
// step's chain of dependent operations runs. The type differs by width, so that code for one
// instruction set never shares a template instantiation with code for another. No function of
// layers L0-L2 that is not a template on this type may be called here without being inlined.
#pragma once

#if defined(__x86_64__)
#include <immintrin.h>
#endif

#include "nfopidn/math.hpp"

namespace nfopidn {

template <int width>
struct Vectors {
  using Real [[gnu::vector_size(8 * width)]] = double;
  using Bits [[gnu::vector_size(8 * width)]] = std::int64_t;
};

template <int width, int count>
struct LaneMask {
  typename Vectors<width>::Bits part[count];

  NFOPIDN_INLINE friend LaneMask operator&(const LaneMask& a, const LaneMask& b) {
    LaneMask result;
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] & b.part[i];
    return result;
  }
  NFOPIDN_INLINE friend LaneMask operator|(const LaneMask& a, const LaneMask& b) {
    LaneMask result;
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] | b.part[i];
    return result;
  }
};

template <int width, int count>
struct Lanes {
  static constexpr int size = width * count;
  using Real = typename Vectors<width>::Real;
  using Mask = LaneMask<width, count>;

  Real part[count];

  Lanes() = default;
  NFOPIDN_INLINE explicit Lanes(double value) {
    for (auto& p : part) p = Real{} + value;
  }

  NFOPIDN_INLINE void set(int lane, double value) { part[lane / width][lane % width] = value; }
  NFOPIDN_INLINE double get(int lane) const { return part[lane / width][lane % width]; }

#define NFOPIDN_LANES_ARITHMETIC(op)                                         \
  NFOPIDN_INLINE friend Lanes operator op(const Lanes& a, const Lanes& b) {  \
    Lanes result;                                                            \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b.part[i]; \
    return result;                                                           \
  }                                                                          \
  NFOPIDN_INLINE friend Lanes operator op(const Lanes& a, double b) {        \
    Lanes result;                                                            \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b;         \
    return result;                                                           \
  }                                                                          \
  NFOPIDN_INLINE friend Lanes operator op(double a, const Lanes& b) {        \
    Lanes result;                                                            \
    for (int i = 0; i < count; ++i) result.part[i] = a op b.part[i];         \
    return result;                                                           \
  }
  NFOPIDN_LANES_ARITHMETIC(+)
  NFOPIDN_LANES_ARITHMETIC(-)
  NFOPIDN_LANES_ARITHMETIC(*)
  NFOPIDN_LANES_ARITHMETIC(/)
#undef NFOPIDN_LANES_ARITHMETIC

#define NFOPIDN_LANES_COMPARISON(op)                                         \
  NFOPIDN_INLINE friend Mask operator op(const Lanes& a, const Lanes& b) {   \
    Mask result;                                                             \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b.part[i]; \
    return result;                                                           \
  }                                                                          \
  NFOPIDN_INLINE friend Mask operator op(const Lanes& a, double b) {         \
    Mask result;                                                             \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b;         \
    return result;                                                           \
  }
  NFOPIDN_LANES_COMPARISON(<)
  NFOPIDN_LANES_COMPARISON(>)
  NFOPIDN_LANES_COMPARISON(<=)
  NFOPIDN_LANES_COMPARISON(==)
#undef NFOPIDN_LANES_COMPARISON
};

// Angles in half turns and nets in powers of two, so that both range reductions are x - round(x).
template <int width, int count>
struct math<Lanes<width, count>> {
  using Base = double;
  using Scalar = Lanes<width, count>;
  using Mask = typename Scalar::Mask;
  using Real = typename Vectors<width>::Real;
  using Bits = typename Vectors<width>::Bits;

  static constexpr Base pi = 3.14159265358979323846;
  static constexpr Base angle_unit = 1 / pi;
  static constexpr Base net_scale = 1.44269504088896340736;
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

  // Horner's scheme: fewest operations; the other vectors fill the waiting.
  template <int terms>
  NFOPIDN_INLINE static Real horner(const Real& x, const Base (&coefficients)[terms]) {
    Real sum = x * coefficients[terms - 1] + coefficients[terms - 2];
    for (int i = terms - 3; i >= 0; --i) sum = sum * x + coefficients[i];
    return sum;
  }

  NFOPIDN_INLINE static Heading<Scalar> heading(const Scalar& angle) {
    Real shifted[count], r[count], square[count], s[count], c[count];
    for (int i = 0; i < count; ++i) shifted[i] = angle.part[i] + magic;
    for (int i = 0; i < count; ++i) r[i] = angle.part[i] - (shifted[i] - magic);
    for (int i = 0; i < count; ++i) square[i] = r[i] * r[i];
    constexpr int terms = sizeof half_sine / sizeof *half_sine;
    for (int i = 0; i < count; ++i) {
      s[i] = square[i] * half_sine[terms - 1] + half_sine[terms - 2];
      c[i] = square[i] * half_cosine[terms - 1] + half_cosine[terms - 2];
    }
    for (int term = terms - 3; term >= 0; --term) {
      for (int i = 0; i < count; ++i) {
        s[i] = s[i] * square[i] + half_sine[term];
        c[i] = c[i] * square[i] + half_cosine[term];
      }
    }
    Heading<Scalar> result;
    for (int i = 0; i < count; ++i) {
      s[i] = s[i] * r[i];
      const Bits sign = reinterpret_cast<Bits>(shifted[i]) << 63;  // an odd number of half turns
      result.sine.part[i] = reinterpret_cast<Real>(reinterpret_cast<Bits>(s[i] * c[i]) ^ sign);
      result.cosine.part[i] =
          reinterpret_cast<Real>(reinterpret_cast<Bits>(1.0 - s[i] * s[i]) ^ sign);
    }
    return result;
  }

  // To [-1, 1] half turns.
  NFOPIDN_INLINE static Scalar wrap(const Scalar& angle) {
    return angle - ((angle + magic_even) - magic_even);
  }

  // All channels together, a stage after the other: nine or so independent chains hide each other's
  // waiting.
  template <class Three>
  NFOPIDN_INLINE static void sigmoids(Three& net) {
    using Constants = kernel::Coefficients<double>;
    constexpr Base saturation = 60;
    constexpr int chains = 3 * count;
    Real f[chains], square[chains], odd[chains], even[chains];
    Bits exponent[chains];
    Scalar* const channels[] = {&net.x, &net.y, &net.theta};
    for (int i = 0; i < chains; ++i) {
      const Real power = clip(channels[i / count]->part[i % count], saturation);
      const Real shifted = power + magic;
      f[i] = power - (shifted - magic);
      exponent[i] = reinterpret_cast<Bits>(shifted) << 52;
    }
    for (int i = 0; i < chains; ++i) square[i] = f[i] * f[i];
    for (int i = 0; i < chains; ++i) odd[i] = horner(square[i], Constants::exponential_q) * f[i];
    for (int i = 0; i < chains; ++i) {
      even[i] = (square[i] + Constants::exponential_p[1]) * square[i] + Constants::exponential_p[0];
    }
    Real numerator[chains], denominator[chains];
    for (int i = 0; i < chains; ++i) {
      const Real above =
          reinterpret_cast<Real>(reinterpret_cast<Bits>(even[i] + odd[i]) + exponent[i]);
      const Real below = even[i] - odd[i];
      numerator[i] = above - below;
      denominator[i] = above + below;
    }
    // One division for the three.
    for (int i = 0; i < count; ++i) {
      const Real& x = denominator[i];
      const Real& y = denominator[count + i];
      const Real& theta = denominator[2 * count + i];
      const Real pair = x * y;
      const Real all = 1.0 / (pair * theta);
      const Real pair_inverse = all * theta;
      net.x.part[i] = numerator[i] * (pair_inverse * y);
      net.y.part[i] = numerator[count + i] * (pair_inverse * x);
      net.theta.part[i] = numerator[2 * count + i] * (all * pair);
    }
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
};

}  // namespace nfopidn
