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
    Heading<Scalar> result;
    for (int i = 0; i < count; ++i) {
      const Real shifted = angle.part[i] + magic;
      const Real r = angle.part[i] - (shifted - magic);
      const Real square = r * r;
      const Real s = r * horner(square, half_sine);
      const Real c = horner(square, half_cosine);
      const Bits sign = reinterpret_cast<Bits>(shifted) << 63;  // an odd number of half turns
      result.sine.part[i] = reinterpret_cast<Real>(reinterpret_cast<Bits>(s * c) ^ sign);
      result.cosine.part[i] = reinterpret_cast<Real>(reinterpret_cast<Bits>(1.0 - s * s) ^ sign);
    }
    return result;
  }

  // To [-1, 1] half turns.
  NFOPIDN_INLINE static Scalar wrap(const Scalar& angle) {
    return angle - ((angle + magic_even) - magic_even);
  }

  NFOPIDN_INLINE static Scalar sigmoid(const Scalar& net) {
    using Constants = kernel::Coefficients<double>;
    constexpr Base saturation = 60;
    Scalar result;
    for (int i = 0; i < count; ++i) {
      const Real power = clip(net.part[i], saturation);
      const Real shifted = power + magic;
      const Real f = power - (shifted - magic);
      const Real square = f * f;
      const Real odd = f * horner(square, Constants::exponential_q);
      const Real even =
          (square + Constants::exponential_p[1]) * square + Constants::exponential_p[0];
      const Bits exponent = reinterpret_cast<Bits>(shifted) << 52;
      const Real above = reinterpret_cast<Real>(reinterpret_cast<Bits>(even + odd) + exponent);
      const Real below = even - odd;
      result.part[i] = (above - below) / (above + below);
    }
    return result;
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
