// L0. The elementary functions in single precision, for processors that execute one instruction
// after the other: straight lines with few operations, where those in double run short chains side
// by side and guess branches.
#pragma once

#include <stdint.h>  // NOLINT(modernize-deprecated-headers): <cstdint> is not everywhere

#include "nfopidn/math/coefficients.hpp"

namespace nfopidn::single {

using Constants = kernel::Coefficients<float>;
constexpr float pi = 3.14159265358979323846F;
constexpr float round_magic = Constants::round_magic;

// Of |rest| <= pi/4.
NFOPIDN_INLINE constexpr float sine(float rest, float square) noexcept {
  float sum = Constants::sine[3];
  sum = Constants::sine[2] + sum * square;
  sum = Constants::sine[1] + sum * square;
  return rest + (rest * square) * sum;
}
NFOPIDN_INLINE constexpr float cosine(float square) noexcept {
  float sum = Constants::cosine[4];
  sum = Constants::cosine[3] + sum * square;
  sum = Constants::cosine[2] + sum * square;
  sum = Constants::cosine[1] + sum * square;
  return Constants::cosine[0] + sum * square;
}

// To [-pi, pi). An angle that lies there already comes back as it is: it is less than half a turn.
NFOPIDN_INLINE constexpr float wrap(float angle) noexcept {
  // 2 pi in two parts, of which the first has 8 bits.
  constexpr float turn[] = {6.28125F, 1.93530717958647692e-3F};
  const float shifted = kernel::opaque(angle * (1 / (2 * pi)) + round_magic);
  const float turns = kernel::opaque(shifted - round_magic);
  const float rest = (angle - turns * turn[0]) - turns * turn[1];
  if (rest >= pi) return rest - 2 * pi < -pi ? -pi : rest - 2 * pi;
  return rest < -pi ? rest + 2 * pi : rest;
}

// NaN stays so.
NFOPIDN_INLINE constexpr float limited(float value, float limit) noexcept {
  if (__builtin_fabsf(value) > limit) return value > 0 ? limit : -limit;
  return value;
}

// 2/(1 + e^-net) - 1. With 2^f = (even + odd)/(even - odd), |f| <= 1/2, and scale = 2^n, n + f
// being net log2(e): ((scale - 1) even + (scale + 1) odd) / ((scale + 1) even + (scale - 1) odd),
// which for n = 0 is odd/even, so that small nets need no branch of their own to keep their digits.
NFOPIDN_INLINE constexpr float sigmoid_of_power(float power) noexcept {
  // The exponent's bias rides on the number that rounds, so that a shift makes 2^n.
  constexpr float biased_magic = round_magic + 127;
  const float shifted = kernel::opaque(power + biased_magic);
  const float fraction = power - kernel::opaque(shifted - biased_magic);
  const float scale = __builtin_bit_cast(float, __builtin_bit_cast(uint32_t, shifted) << 23);
  const float square = fraction * fraction;
  const float odd = fraction * (Constants::exponential_q[0] + Constants::exponential_q[1] * square);
  const float even = Constants::exponential_p[0] + square;
  const float less = scale - 1.0F;
  const float more = scale + 1.0F;
  return (less * even + more * odd) / (more * even + less * odd);
}

// The net in powers of two, no further than where the neuron is 1: 1 - 2^-30 is 1.
NFOPIDN_INLINE constexpr float power_of(float net) noexcept {
  return limited(net * 1.44269504088896340736F, 30);
}
NFOPIDN_INLINE constexpr float sigmoid(float net) noexcept {
  return sigmoid_of_power(power_of(net));
}

// The branches first, so that the rest is one straight line that shares its constants.
template <class Three>
NFOPIDN_INLINE constexpr Three sigmoids(const Three& net) noexcept {
  const float x = power_of(net.x);
  const float y = power_of(net.y);
  const float theta = power_of(net.theta);
  return {sigmoid_of_power(x), sigmoid_of_power(y), sigmoid_of_power(theta)};
}

}  // namespace nfopidn::single
