// L3. Normal numbers by counter: each is a function of a seed and of its place alone, so that runs
// draw theirs side by side, in any order, and again.
//
// Two words of key and a number of the pair pass the two rounds of SplitMix64 (Steele, Lea and
// Flood 2014), the second word of key between them: 64 bits a pair of normals, which Box and
// Muller's method makes of 32 bits each for the radius and the angle. So a normal is at most
// 6.8 standard deviations from 0. The operations are the same for a double and for a vector of
// them, and so are the bits.
#pragma once

#include <cstdint>

#include "nfopidn/math/math.hpp"

namespace nfopidn {

namespace counter_noise {

constexpr std::uint64_t golden = 0x9E3779B97F4A7C15U;
constexpr std::uint64_t first_factor = 0xBF58476D1CE4E5B9U;
constexpr std::uint64_t second_factor = 0x94D049BB133111EBU;

// SplitMix64's output for a state; with `between` 0 it is the published one.
template <class Word>
NFOPIDN_INLINE constexpr Word mixed(const Word& state, const Word& between) {
  Word z = (state ^ (state >> 30)) * first_factor + between;
  z = (z ^ (z >> 27)) * second_factor;
  return z ^ (z >> 31);
}

// What the pairs of a run are made from.
struct Key {
  std::uint64_t first;
  std::uint64_t second;

  explicit constexpr Key(std::uint64_t seed)
      : first(mixed<std::uint64_t>(seed + golden, 0)),
        second(mixed<std::uint64_t>(seed + 2 * golden, 0)) {}
};

// The 64 bits of pair 0, 1, ...
template <class Word>
NFOPIDN_INLINE constexpr Word pair_bits(const Word& first, const Word& second, std::uint64_t pair) {
  return mixed<Word>(first + (pair + 1) * golden, second);
}

// Minimax-like fits in powers of the square. log((1+s)/(1-s))/s for |s| <= 0.1716; and
// sqrt(2) sin(pi/2 r)/r and sqrt(2) cos(pi/2 r) for |r| <= 1/2, of which cos(pi r) = 1 - s^2 and
// sin(pi r) = s c. Relative errors 4.3e-12, 4.8e-12 and 6.7e-11.
constexpr double logarithm[] = {2.0000000000083595175, 0.66666665247487522794,
                                0.40000384672375187391, 0.28535051037816310104,
                                0.23616359099145984983};
constexpr double half_sine[] = {2.2214414690695711161, -0.91353118557687593279,
                                0.11270233131112665559, -0.0066203102293417873315,
                                0.00022373750014248505777};
constexpr double half_cosine[] = {1.4142135623059049375, -1.7447160364704376413,
                                  0.35874242816544417107, -0.029500593199318808965,
                                  0.0012779230668159256517};

template <class Real>
NFOPIDN_INLINE constexpr Real horner(const Real& x, const double (&coefficients)[5]) {
  Real sum = x * coefficients[4] + coefficients[3];
  for (int i = 2; i >= 0; --i) sum = sum * x + coefficients[i];
  return sum;
}

// The natural logarithm of numbers in (0, 1).
template <class Real, class Word>
NFOPIDN_INLINE Real log(const Real& value) {
  constexpr std::uint64_t root = 0x3FE6A09E667F3BCDU;   // of sqrt(1/2)
  constexpr std::uint64_t whole = 0x4330000000000000U;  // of 2^52
  constexpr std::uint64_t bias = 1023;
  const Word bits = __builtin_bit_cast(Word, value);
  const Word exponent = (bits - root + (bias << 52)) >> 52;
  const Real mantissa = __builtin_bit_cast(Real, bits - ((exponent - bias) << 52));
  const Real power = __builtin_bit_cast(Real, exponent | whole) - (4503599627370496.0 + 1023.0);
  const Real s = (mantissa - 1.0) / (mantissa + 1.0);
  return power * 0.69314718055994530942 + horner(s * s, logarithm) * s;
}

template <class Real>
struct Pair {
  Real cosine;
  Real sine;
};

// Two independent standard normals from 64 bits. root(x) is the square root.
template <class Real, class Word, class Root>
NFOPIDN_INLINE Pair<Real> normals(const Word& bits, const Root& root) {
  constexpr std::uint64_t whole = 0x4330000000000000U;  // of 2^52
  constexpr double middle = 4503599627370496.0 - 0.5;
  constexpr std::uint64_t angle_bits = 0x7FFFFFFFU;
  const Real uniform = (__builtin_bit_cast(Real, (bits >> 32) | whole) - middle) * 0x1p-32;
  const Real r = (__builtin_bit_cast(Real, (bits & angle_bits) | whole) - middle) * 0x1p-31 - 0.5;
  // The last bit of the angle takes the half circle round to the whole one.
  const Word half_turn = (bits << 32) & 0x8000000000000000U;
  const Real length = root(log<Real, Word>(uniform) * -2.0);
  const Real radius = __builtin_bit_cast(Real, __builtin_bit_cast(Word, length) ^ half_turn);
  const Real square = r * r;
  const Real s = horner(square, half_sine) * r;
  const Real c = horner(square, half_cosine);
  return {(1.0 - s * s) * radius, s * c * radius};
}

}  // namespace counter_noise

// The standard normals of one run, three a sample: number n is one half of pair n / 2.
class CounterNoise {
 public:
  explicit constexpr CounterNoise(std::uint64_t seed) : key_(seed) {}

  double normal(std::uint64_t number) const {
    const auto root = [](double value) { return __builtin_sqrt(value); };
    const auto pair = counter_noise::normals<double>(
        counter_noise::pair_bits(key_.first, key_.second, number / 2), root);
    return number % 2 == 0 ? pair.cosine : pair.sine;
  }

 private:
  counter_noise::Key key_;
};

}  // namespace nfopidn
