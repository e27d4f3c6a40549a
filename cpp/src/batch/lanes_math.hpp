// What lanes compute otherwise than a single number: elementary functions and comparisons.
#pragma once

#include "lanes_instructions.hpp"

namespace nfopidn {

// Nets in a unit in which the neuron's polynomial for small nets has no leading factor.
template <int width, int count>
struct math<Lanes<width, count>> : private Instructions<width> {
  using Base = double;
  using Scalar = Lanes<width, count>;
  using Mask = typename Scalar::Mask;
  using Real = typename Vectors<width>::Real;
  using Bits = typename Vectors<width>::Bits;
  using Instructions<width>::smaller, Instructions<width>::larger, Instructions<width>::clip;
  using Instructions<width>::farther, Instructions<width>::all_under;
  using Instructions<width>::any_over, Instructions<width>::any_bit;

  static constexpr Base pi = 3.14159265358979323846;
  using Constants = kernel::Coefficients<double>;
  static constexpr Base net_scale = 0.32181959892097086843;

  static constexpr Base magic = 6755399441055744.0;  // 1.5 * 2^52: rounds to whole numbers

  // (cos(a) - 1) / a^2 and (sin(a) / a - 1) / a^2 in powers of a^2, |a| <= small_angle. Errors of
  // cosine and sine 9.8e-19 and, relative, 4.9e-16.
  static constexpr Base small_cosine[] = {-0.49999999999999954339, 0.041666666666600385547,
                                          -0.001388888885764436481, 0.000024801523021095435091,
                                          -2.7497277917757532312e-7};
  static constexpr Base small_sine[] = {-0.16666666666650792261, 0.0083333333175377359772,
                                        -0.00019841220984048832291, 2.7497752152011910997e-6};
  static constexpr Base small_angle = 0.3125;

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

  // tanh(n/2)/n as a polynomial of sixth degree in x = n^2, in units of net_scale, |n| <=
  // small_net; in those units its leading coefficient is 1. In Knuth's form for the sixth degree,
  // with three multiplications: z = (x + a0) x + a1, w = (x + a2) z + a3, (w + z + a4) w + a5.
  // Relative error 1.4e-15.
  static constexpr Base small_neuron[] = {-1.098571173519737795449,  1.132917931946503487728,
                                          0.03634079859715713187045, -0.01480054057999903375722,
                                          -2.302909309028378144493,  1.58382344302061901099};
  static constexpr Base small_net = 0.53125;
  static constexpr Base small_square = (small_net * net_scale) * (small_net * net_scale);

  // Horner's scheme: fewest operations; the other vectors fill the waiting.
  template <int terms>
  NFOPIDN_INLINE static Real horner(const Real& x, const Base (&coefficients)[terms]) {
    Real sum = x * coefficients[terms - 1] + coefficients[terms - 2];
    for (int i = terms - 3; i >= 0; --i) sum = sum * x + coefficients[i];
    return sum;
  }

  // From the difference of two angles, the first one's heading being known: takes the difference to
  // [-pi, pi] and gives the heading of the second. Sooner while no angle is far from the other.
  NFOPIDN_INLINE static Heading<Scalar> heading_relative_to(const Heading<Base>& first,
                                                            Scalar& difference) {
    Real square[count];
    Real farthest = Real{};
    for (int i = 0; i < count; ++i) {
      square[i] = difference.part[i] * difference.part[i];
      farthest = larger(farthest, square[i]);
    }
    Heading<Scalar> turn = small_heading(difference, square);
    if (__builtin_expect(any_over(farthest, small_angle * small_angle), 0)) {
      difference = wrap(difference);
      turn = any_heading(difference);
    }
    return {first.cosine * turn.cosine + first.sine * turn.sine,
            first.sine * turn.cosine - first.cosine * turn.sine};
  }

  NFOPIDN_INLINE static Heading<Scalar> heading(const Scalar& angle) {
    return any_heading(wrap(angle));
  }

  // Of angles that are small_angle at most.
  NFOPIDN_INLINE static Heading<Scalar> small_heading(const Scalar& angle) {
    Real square[count];
    for (int i = 0; i < count; ++i) square[i] = angle.part[i] * angle.part[i];
    return small_heading(angle, square);
  }

  // Whole numbers, ties to even.
  NFOPIDN_INLINE static Scalar nearest(const Scalar& value) {
    Scalar whole = value + magic;
    for (auto& part : whole.part) part = kernel::opaque<Real>(kernel::opaque<Real>(part) - magic);
    return whole;
  }

  // To [-pi, pi].
  NFOPIDN_INLINE static Scalar wrap(const Scalar& angle) {
    constexpr Base whole[] = {4 * Constants::half_pi[0], 4 * Constants::half_pi[1]};
    const Scalar turns = nearest(angle * (1 / (2 * pi)));
    return (angle - turns * whole[0]) - turns * whole[1];
  }

  // All channels together.
  template <class Three>
  NFOPIDN_INLINE static void sigmoids(Three& net) {
    Scalar* const nets[] = {&net.x, &net.y, &net.theta};
    Real value[chains], square[chains], largest[count];
    for (int i = 0; i < chains; ++i) {
      value[i] = nets[i / count]->part[i % count];
      square[i] = value[i] * value[i];
    }
    Real largest_of_all = Real{};
    for (int i = 0; i < count; ++i) {
      largest[i] = larger(larger(square[i], square[count + i]), square[2 * count + i]);
      largest_of_all = larger(largest_of_all, largest[i]);
    }
    Real output[chains];
    small_sigmoids(value, square, output);
    if (__builtin_expect(any_over(largest_of_all, small_square), 0)) {
      for (int i = 0; i < count; ++i) {
        if (any_over(largest[i], small_square)) large_sigmoids(value + i, square + i, output + i);
      }
    }
    for (int i = 0; i < chains; ++i) nets[i / count]->part[i % count] = output[i];
  }

  NFOPIDN_INLINE static Scalar identity(const Scalar& net) { return net * (1 / net_scale); }

  // The same operations as math<double>'s, vector by vector.
  NFOPIDN_INLINE static Scalar exponential(const Scalar& exponent) {
    constexpr Base most = 1020;  // powers of two
    Scalar result;
    for (int i = 0; i < count; ++i) {
      const Real power = clip(exponent.part[i] * 1.44269504088896340736, most);
      const Real shifted = kernel::opaque<Real>(power + magic);
      const Real f = power - kernel::opaque<Real>(shifted - magic);
      const Real square = f * f;
      const Real odd = horner(square, Constants::exponential_q) * f;
      const Real even = horner(square, Constants::exponential_p);
      const Real ratio = (even + odd) / (even - odd);
      result.part[i] = reinterpret_cast<Real>(reinterpret_cast<Bits>(ratio) +
                                              (reinterpret_cast<Bits>(shifted) << 52));
    }
    return result;
  }

  // Natural logarithm of positive, normal numbers.
  NFOPIDN_INLINE static Scalar log(const Scalar& value) {
    constexpr auto root = static_cast<std::int64_t>(0x3FE6A09E667F3BCD);   // of sqrt(1/2)
    constexpr auto whole = static_cast<std::int64_t>(0x4330000000000000);  // of 2^52
    constexpr std::int64_t bias = 1023;
    Scalar result;
    for (int i = 0; i < count; ++i) {
      const Bits bits = reinterpret_cast<Bits>(value.part[i]);
      // Positive, so that a logical shift and one that keeps the sign are the same.
      const Bits exponent = ((bits - root) + (bias << 52)) >> 52;
      const Real mantissa = reinterpret_cast<Real>(bits - ((exponent - bias) << 52));
      const Real power =
          reinterpret_cast<Real>(exponent | whole) - (4503599627370496.0 + double(bias));
      const Real s = (mantissa - 1.0) / (mantissa + 1.0);
      result.part[i] = power * 0.69314718055994530942 + horner(s * s, Constants::logarithm) * s;
    }
    return result;
  }

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
  // The components in [-limit, limit].
  NFOPIDN_INLINE static Mask within_each(const Scalar& a, Base limit) {
    return maximum(a, a * -1.0) <= limit;
  }
  NFOPIDN_INLINE static Mask both(const Mask& a, const Mask& b) { return a & b; }
  NFOPIDN_INLINE static Mask either(const Mask& a, const Mask& b) { return a | b; }
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
  static constexpr int channels = 3;
  static constexpr int chains = channels * count;

  NFOPIDN_INLINE static Heading<Scalar> small_heading(const Scalar& angle,
                                                      const Real (&square)[count]) {
    Heading<Scalar> result;
    for (int i = 0; i < count; ++i) {
      const Real& x = square[i];
      const Real fourth = x * x;
      const Real cosine =
          (small_cosine[0] + small_cosine[1] * x) +
          ((small_cosine[2] + small_cosine[3] * x) + small_cosine[4] * fourth) * fourth;
      const Real sine =
          (small_sine[0] + small_sine[1] * x) + (small_sine[2] + small_sine[3] * x) * fourth;
      result.cosine.part[i] = 1.0 + cosine * x;
      result.sine.part[i] = angle.part[i] + sine * (angle.part[i] * x);
    }
    return result;
  }

  // The same for small angles; others by the half angle's cosine and sine.
  NFOPIDN_INLINE static Heading<Scalar> any_heading(const Scalar& angle) {
    Real square[count];
    for (int i = 0; i < count; ++i) square[i] = angle.part[i] * angle.part[i];
    Heading<Scalar> result = small_heading(angle, square);
    for (int i = 0; i < count; ++i) {
      if (!any_over(square[i], small_angle * small_angle)) continue;
      const Real half_turns = angle.part[i] * (1 / pi);
      const Real shifted = kernel::opaque<Real>(half_turns + magic);
      const Real r = half_turns - kernel::opaque<Real>(shifted - magic);
      const Bits odd = reinterpret_cast<Bits>(shifted) << 63;
      const Real sign = reinterpret_cast<Real>(reinterpret_cast<Bits>(Real{} + 1.0) ^ odd);
      const Real x = r * r;
      const Real s = horner(x, half_sine) * r;
      const Real c = horner(x, half_cosine);
      const Real signed_sine = s * sign;
      const auto large = square[i] > small_angle * small_angle;
      result.cosine.part[i] = large ? sign - signed_sine * s : result.cosine.part[i];
      result.sine.part[i] = large ? signed_sine * c : result.sine.part[i];
    }
    return result;
  }

  NFOPIDN_INLINE static void small_sigmoids(const Real (&net)[chains], const Real (&square)[chains],
                                            Real (&output)[chains]) {
    constexpr auto& a = small_neuron;
    // Vector by vector, whose three chains hide each other's waiting in few registers.
    for (int i = 0; i < count; ++i) {
      Real z[channels], w[channels];
      for (int c = 0; c < channels; ++c) {
        const Real& x = square[c * count + i];
        z[c] = (x + a[0]) * x + a[1];
      }
      for (int c = 0; c < channels; ++c) w[c] = (square[c * count + i] + a[2]) * z[c] + a[3];
      for (int c = 0; c < channels; ++c) {
        output[c * count + i] = (((w[c] + z[c]) + a[4]) * w[c] + a[5]) * net[c * count + i];
      }
    }
  }

  // By the exponential function, where a net is not small. The three channels of one vector.
  NFOPIDN_INLINE static void large_sigmoids(const Real* net, const Real* square, Real* output) {
    constexpr Base saturation = 60;  // in powers of two: 1 - 2^-60 is 1
    constexpr Base powers = 1.44269504088896340736 / net_scale;
    Real above[channels], below[channels];
    for (int i = 0; i < channels; ++i) {
      const Real power = clip(net[i * count] * powers, saturation);
      const Real shifted = kernel::opaque<Real>(power + magic);
      const Real f = power - kernel::opaque<Real>(shifted - magic);
      const Bits exponent = reinterpret_cast<Bits>(shifted) << 52;
      const Real f_square = f * f;
      const Real odd = horner(f_square, Constants::exponential_q) * f;
      const Real even = horner(f_square, Constants::exponential_p);
      const Real high = reinterpret_cast<Real>(reinterpret_cast<Bits>(even + odd) + exponent);
      const Real low = even - odd;
      above[i] = high - low;
      below[i] = high + low;
    }
    // One division for the three channels.
    const Real pair = below[0] * below[1];
    const Real all = 1.0 / (pair * below[2]);
    const Real pair_inverse = all * below[2];
    above[0] = above[0] * (pair_inverse * below[1]);
    above[1] = above[1] * (pair_inverse * below[0]);
    above[2] = above[2] * (all * pair);
    for (int i = 0; i < channels; ++i) {
      Real& result = output[i * count];
      result = square[i * count] > small_square ? above[i] : result;
    }
  }
};

}  // namespace nfopidn
