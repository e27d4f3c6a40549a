// L3. Random draws that are the same on every platform: a fixed engine, and own distributions,
// since the standard library's differ between implementations.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "nfopidn/math.hpp"

namespace nfopidn {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  // Uniform in [0, 1), a multiple of 2^-53.
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }

  double uniform(double low, double high) { return low + (high - low) * uniform(); }

  // Standard normal (Box and Muller).
  double normal() {
    const double radius = std::sqrt(-2 * math<double>::log(1 - uniform()));
    return radius * math<double>::heading(2 * math<double>::pi * uniform()).cosine;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace nfopidn
