// L3. Many exponentials, two at a time.
#pragma once

#include <cstddef>
#include <cstdint>

#include "nfopidn/math/math.hpp"

namespace nfopidn {

namespace detail {

using Two [[gnu::vector_size(16)]] = double;
using TwoBits [[gnu::vector_size(16)]] = std::uint64_t;

// Operation for operation math<double>::exponential, whose comparisons keep compilers from taking
// two numbers at a time.
inline Two exponential(const Two& exponent) {
  using Constants = kernel::Coefficients<double>;
  const auto& q = Constants::exponential_q;
  const auto& p = Constants::exponential_p;
  const Two most = Two{} + 1020.0;
  Two power = exponent * 1.44269504088896340736;
  power = power < -most ? -most : power;
  power = most < power ? most : power;
  const Two shifted = kernel::opaque<Two>(power + Constants::round_magic);
  const Two fraction = power - kernel::opaque<Two>(shifted - Constants::round_magic);
  const Two square = fraction * fraction;
  const Two fourth = square * square;
  const Two odd = fraction * ((q[0] + square * q[1]) + fourth * q[2]);
  const Two even = (p[0] + square * p[1]) + fourth * p[2];
  const TwoBits magic = reinterpret_cast<TwoBits>(Two{} + Constants::round_magic);
  const TwoBits scale = (reinterpret_cast<TwoBits>(shifted) - magic + Constants::exponent_bias)
                        << Constants::mantissa_bits;
  return reinterpret_cast<Two>(scale) * ((even + odd) / (even - odd));
}

}  // namespace detail

// Puts e^value in place of each, the same to the last bit as math<double>::exponential.
inline void exponentials(double* values, std::ptrdiff_t count) {
  std::ptrdiff_t i = 0;
  for (; i + 1 < count; i += 2) {
    const detail::Two pair = detail::exponential(detail::Two{values[i], values[i + 1]});
    values[i] = pair[0];
    values[i + 1] = pair[1];
  }
  if (i < count) values[i] = math<double>::exponential(values[i]);
}

}  // namespace nfopidn
