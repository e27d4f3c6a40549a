// L3. Random draws that are the same on every platform: a fixed engine, and own distributions,
// since the standard library's differ between implementations.
#pragma once

#include <cmath>
#include <cstdint>
#include <utility>

#include "nfopidn/math/math.hpp"
#include "nfopidn/math/mersenne_twister.hpp"

namespace nfopidn {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  // 64 bits, each 0 or 1 with the same probability.
  std::uint64_t bits() { return engine_(); }

  // Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1p-53; }

  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  // Two indices from one draw, each under its count: for counts that are small beside 2^32.
  template <class Index>
  std::pair<Index, Index> pair(Index count, Index other_count) {
    const std::uint64_t draw = bits();
    const auto under = [](std::uint64_t half, Index bound) {
      return static_cast<Index>(half * static_cast<std::uint64_t>(bound) >> 32);
    };
    return {under(draw >> 32, count), under(draw & 0xFFFFFFFF, other_count)};
  }

  // Bell-shaped, with mean 0 and standard deviation 1, within 3.5: the sum of four small uniform
  // numbers from one draw, where a normal distribution would do and cost too much.
  double bell() {
    constexpr double mean = 131070;                // 4 (2^16 - 1) / 2
    constexpr double deviation = 37837.227245851;  // the root of 4 (2^32 - 1) / 12
    const std::uint64_t draw = bits();
    const std::uint64_t sum =
        (draw & 0xFFFF) + (draw >> 16 & 0xFFFF) + (draw >> 32 & 0xFFFF) + (draw >> 48);
    return (static_cast<double>(sum) - mean) / deviation;
  }

  // Standard normal (Box and Muller).
  double normal() {
    const double radius = std::sqrt(-2 * math<double>::log(1 - uniform()));
    return radius * math<double>::heading(2 * math<double>::pi * uniform()).cosine;
  }

 private:
  MersenneTwister engine_;
};

}  // namespace nfopidn
