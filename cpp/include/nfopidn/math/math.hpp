// L0. What differs between one Scalar and another: the law and the plant call math<Scalar>. The
// elementary functions are the project's own polynomials, not libm's, so that a result does not
// depend on the machine it was computed on.
#pragma once

#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/math/single.hpp"

namespace nfopidn {

template <class Scalar>
struct Heading {
  Scalar cosine;
  Scalar sine;
};

namespace kernel {

// Estrin's scheme: the sum waits for few dependent operations. `powers` holds argument^(2^i).
template <int begin, int end, int level, class Value, class Base, int count>
NFOPIDN_INLINE constexpr Value polynomial_part(const Value* powers,
                                               const Base (&coefficients)[count]) {
  if constexpr (end - begin == 1) {
    return Value(coefficients[begin]);
  } else {
    constexpr int half = 1 << level;
    if constexpr (end - begin <= half) {
      return polynomial_part<begin, end, level - 1>(powers, coefficients);
    } else {
      return polynomial_part<begin, begin + half, level - 1>(powers, coefficients) +
             powers[level] * polynomial_part<begin + half, end, level - 1>(powers, coefficients);
    }
  }
}

template <class Value, class Base, int count>
NFOPIDN_INLINE constexpr Value polynomial(const Value& argument,
                                          const Base (&coefficients)[count]) {
  static_assert(count <= 16, "four levels");
  Value powers[4] = {argument, argument, argument, argument};
  for (int i = 1; i < 4; ++i) powers[i] = powers[i - 1] * powers[i - 1];
  return polynomial_part<0, count, 3>(powers, coefficients);
}

// argument * P(square), with the product taken into the parts: one operation less to wait for.
template <class Value, class Base, int count>
NFOPIDN_INLINE constexpr Value odd_polynomial(const Value& argument, const Value& square,
                                              const Base (&coefficients)[count]) {
  const Value powers[] = {square, square * square, (square * square) * (square * square)};
  if constexpr (count > 4) {
    return argument * polynomial_part<0, 4, 1>(powers, coefficients) +
           (argument * powers[2]) * polynomial_part<4, count, 1>(powers, coefficients);
  } else {
    Value sum = argument * coefficients[0] + (argument * coefficients[1]) * powers[0];
    if constexpr (count > 2) sum = sum + (argument * coefficients[2]) * powers[1];
    if constexpr (count > 3) sum = sum + (argument * coefficients[3]) * (square * powers[1]);
    return sum;
  }
}

template <class To, class From>
constexpr To bit_cast(const From& from) noexcept {
  static_assert(sizeof(To) == sizeof(From), "bit_cast needs equal sizes");
  return __builtin_bit_cast(To, from);
}

}  // namespace kernel

// For float and double. Angles are in radians and nets are unscaled.
// Lanes and dual numbers specialise this, in headers of their own.
template <class Scalar>
struct math {
  using Base = Scalar;  // what is the same for all of a Scalar's components
  using Mask = bool;
  using Constants = kernel::Coefficients<Scalar>;
  using Bits = typename Constants::Bits;
  using SignedBits = typename Constants::SignedBits;

  static constexpr Base pi = Base(3.14159265358979323846);
  static constexpr Base net_scale = Base(1);  // internal net units in one of eq. 34

  // Nearest whole number, ties to even, for |value| < 2^(mantissa_bits - 2).
  static constexpr Scalar nearest(Scalar value) {
    return kernel::opaque(kernel::opaque(value + Constants::round_magic) - Constants::round_magic);
  }

  NFOPIDN_INLINE static constexpr Heading<Scalar> heading(Scalar angle) {
    const Scalar shifted = quarters_of(angle);
    return turned(rest_of(angle, shifted), kernel::bit_cast<Bits>(shifted));
  }

  // The quarter turn of an angle, remembered for the next.
  using Turn = Scalar;
  static constexpr Turn no_turn() { return Constants::round_magic; }

  // The same to the last bit, sooner for an angle in the quarter turn of the one before.
  NFOPIDN_INLINE static constexpr Heading<Scalar> heading(Scalar angle, Turn& quarter) {
    Scalar rest = rest_of(angle, quarter);
    constexpr Scalar certain = Scalar(0.78539);  // under pi/4
    if (!(rest < certain && rest > -certain)) {
      quarter = quarters_of(angle);
      rest = rest_of(angle, quarter);
    }
    return turned(rest, kernel::bit_cast<Bits>(quarter));
  }

  // To [-pi, pi). The loop's errors nearly always lie there already.
  NFOPIDN_INLINE static constexpr Scalar wrap(Scalar angle) {
    if constexpr (is_single) return single::wrap(angle);
    if (angle >= -pi && angle < pi) return angle;
    const Scalar turns = nearest(angle * Scalar(1 / (2 * pi)));
    const Scalar rest =
        (angle - turns * (4 * Constants::half_pi[0])) - turns * (4 * Constants::half_pi[1]);
    if (rest >= pi) return rest - 2 * pi < -pi ? -pi : rest - 2 * pi;
    return rest < -pi ? rest + 2 * pi : rest;
  }

  // 2/(1 + e^-net) - 1, the neuron of eq. 33, absolute error about 1 unit in the last place of 1
  // (2 in float).
  NFOPIDN_INLINE static constexpr Scalar sigmoid(Scalar net) {
    if constexpr (is_single) {
      return single::sigmoid(net);
    } else {
      return branching_sigmoid(net);
    }
  }

  // The neurons of three channels.
  template <class Three>
  NFOPIDN_INLINE static void sigmoids(Three& net) {
    if constexpr (is_single) {
      net = single::sigmoids(net);
    } else {
      net.x = sigmoid(net.x);
      net.y = sigmoid(net.y);
      net.theta = sigmoid(net.theta);
    }
  }

  static constexpr Scalar identity(Scalar net) { return net; }
  static constexpr Base value(Scalar scalar) { return scalar; }

  static constexpr Scalar minimum(Scalar a, Scalar b) { return b < a ? b : a; }
  static constexpr Scalar maximum(Scalar a, Scalar b) { return a < b ? b : a; }
  static constexpr Scalar absolute(Scalar value) { return value < 0 ? -value : value; }
  static constexpr Scalar select(Mask condition, Scalar yes, Scalar no) {
    return condition ? yes : no;
  }
  static constexpr Mask both(Mask a, Mask b) { return a && b; }
  static constexpr Mask either(Mask a, Mask b) { return a || b; }
  static constexpr Mask all() { return true; }
  static constexpr bool any(Mask mask) { return mask; }
  static constexpr bool every(Mask mask) { return mask; }
  // Whether every component of an amount that is not negative is a number and within the limit; may
  // say no where it is so.
  static constexpr bool surely_under(Scalar amount, Base limit) { return amount <= limit; }
  // Whether both lie in [-limit, limit], every component.
  static constexpr bool within(Scalar a, Scalar b, Base limit) {
    return a <= limit && a >= -limit && b <= limit && b >= -limit;
  }
  static constexpr bool is_finite(Scalar value) { return value - value == Scalar(0); }

  static Scalar exponential(Scalar exponent) {
    constexpr Scalar most = sizeof(Scalar) == 8 ? Scalar(1020) : Scalar(124);  // powers of two
    const Scalar power = minimum(maximum(exponent * Scalar(1.44269504088896340736), -most), most);
    const Scalar shifted = kernel::opaque(power + Constants::round_magic);
    const Scalar fraction = power - kernel::opaque(shifted - Constants::round_magic);
    const Scalar square = fraction * fraction;
    const Scalar odd = fraction * kernel::polynomial(square, Constants::exponential_q);
    const Scalar even = kernel::polynomial(square, Constants::exponential_p);
    return power_of_two(shifted) * ((even + odd) / (even - odd));
  }

  // Natural logarithm of a positive, normal number.
  static Scalar log(Scalar value) {
    Bits bits = kernel::bit_cast<Bits>(value);
    // Take the mantissa to [1/sqrt 2, sqrt 2), where s below stays under 0.1716.
    const Bits root = kernel::bit_cast<Bits>(Scalar(0.70710678118654752440));
    const SignedBits exponent = static_cast<SignedBits>(bits - root) >> Constants::mantissa_bits;
    bits -= Bits(exponent) << Constants::mantissa_bits;
    const Scalar mantissa = kernel::bit_cast<Scalar>(bits);
    const Scalar s = (mantissa - 1) / (mantissa + 1);
    return Scalar(exponent) * Scalar(0.69314718055994530942) +
           s * kernel::polynomial(s * s, Constants::logarithm);
  }

  // The angle of the vector (x, y) in [-pi, pi], 0 for the null vector.
  static constexpr Scalar angle_of(Scalar y, Scalar x) {
    const Scalar wide = absolute(x);
    const Scalar high = absolute(y);
    const Scalar low_side = minimum(wide, high);
    const Scalar long_side = maximum(wide, high);
    if (!(long_side > 0)) return 0;
    Scalar ratio = low_side / long_side;
    Scalar angle = 0;
    if (ratio > Scalar(0.41421356237309504880)) {  // tan(pi/8)
      ratio = (low_side - long_side) / (low_side + long_side);
      angle = pi / 4;
    }
    angle += ratio * kernel::polynomial(ratio * ratio, Constants::arctangent);
    if (high > wide) angle = pi / 2 - angle;
    if (x < 0) angle = pi - angle;
    return y < 0 ? -angle : angle;
  }

 private:
  static constexpr bool is_single = traits::is_same<Scalar, float>;

  NFOPIDN_INLINE static constexpr Scalar branching_sigmoid(Scalar net) {
    if (net <= Constants::small_net && net >= -Constants::small_net) {
      const Scalar square = net * net;
      return kernel::odd_polynomial(net, square, Constants::neuron_p) /
             kernel::polynomial(square, Constants::neuron_q);
    }
    const Scalar power = net * Scalar(1.44269504088896340736);
    constexpr Scalar saturation = 60;  // in powers of two: 1 - 2^-60 is 1
    if (power > saturation) return Scalar(1);
    if (power < -saturation) return Scalar(-1);
    const Scalar shifted = kernel::opaque(power + Constants::round_magic);
    const Scalar fraction = power - kernel::opaque(shifted - Constants::round_magic);
    const Scalar square = fraction * fraction;
    const Scalar odd = fraction * kernel::polynomial(square, Constants::exponential_q);
    const Scalar even = kernel::polynomial(square, Constants::exponential_p);
    const Scalar above = power_of_two(shifted) * (even + odd);
    const Scalar below = even - odd;
    return (above - below) / (above + below);
  }

  // The nearest whole number of quarter turns, plus round_magic.
  NFOPIDN_INLINE static constexpr Scalar quarters_of(Scalar angle) {
    return kernel::opaque(angle * Scalar(2 / pi) + Constants::round_magic);
  }

  NFOPIDN_INLINE static constexpr Scalar rest_of(Scalar angle, Scalar shifted) {
    const Scalar quarters = kernel::opaque(shifted - Constants::round_magic);
    return (angle - quarters * Constants::half_pi[0]) - quarters * Constants::half_pi[1];
  }

  NFOPIDN_INLINE static constexpr Heading<Scalar> turned(Scalar rest, Bits quadrant) {
    const Scalar square = rest * rest;
    Scalar sine = 0;
    Scalar cosine = 0;
    if constexpr (is_single) {
      sine = single::sine(rest, square);
      cosine = single::cosine(square);
    } else {
      sine = kernel::odd_polynomial(rest, square, Constants::sine);
      cosine = kernel::polynomial(square, Constants::cosine);
    }
    if (quadrant & 1) {
      const Scalar swap = sine;
      sine = cosine;
      cosine = -swap;
    }
    return (quadrant & 2) ? Heading<Scalar>{-cosine, -sine} : Heading<Scalar>{cosine, sine};
  }

  // 2^n, where n is the whole number in the low bits of n + round_magic.
  static constexpr Scalar power_of_two(Scalar shifted) {
    const Bits magic = kernel::bit_cast<Bits>(Constants::round_magic);
    const Bits exponent = kernel::bit_cast<Bits>(shifted) - magic + Constants::exponent_bias;
    return kernel::bit_cast<Scalar>(Bits(exponent << Constants::mantissa_bits));
  }
};

template <class Scalar>
using base_t = typename math<Scalar>::Base;

}  // namespace nfopidn
