// L3. Random draws that are the same on every platform: a fixed engine, and own distributions,
// since the standard library's differ between implementations.
#pragma once

#include <cmath>
#include <cstdint>

#include "nfopidn/math.hpp"

namespace nfopidn {

// The stream of std::mt19937_64, made a whole state at a time: loops without branches, in which
// the compiler takes several words at once.
class MersenneTwister {
 public:
  explicit MersenneTwister(std::uint64_t seed) {
    state_[0] = seed;
    for (std::uint64_t i = 1; i < size; ++i) {
      state_[i] = 6364136223846793005U * (state_[i - 1] ^ (state_[i - 1] >> 62)) + i;
    }
  }

  std::uint64_t operator()() {
    if (next_ == size) refill();
    return words_[next_++];
  }

 private:
  static constexpr int size = 312;
  static constexpr int middle = 156;

  static std::uint64_t twisted(std::uint64_t upper, std::uint64_t lower) {
    constexpr std::uint64_t low_bits = 0x7fffffff;
    const std::uint64_t joined = (upper & ~low_bits) | (lower & low_bits);
    return (joined >> 1) ^ ((0 - (joined & 1)) & 0xb5026f5aa96619e9U);
  }

  void refill() {
    for (int i = 0; i < middle; ++i) {
      state_[i] = state_[i + middle] ^ twisted(state_[i], state_[i + 1]);
    }
    for (int i = middle; i < size - 1; ++i) {
      state_[i] = state_[i - middle] ^ twisted(state_[i], state_[i + 1]);
    }
    state_[size - 1] = state_[middle - 1] ^ twisted(state_[size - 1], state_[0]);
    for (int i = 0; i < size; ++i) {
      std::uint64_t word = state_[i];
      word ^= (word >> 29) & 0x5555555555555555U;
      word ^= (word << 17) & 0x71d67fffeda60000U;
      word ^= (word << 37) & 0xfff7eee000000000U;
      words_[i] = word ^ (word >> 43);
    }
    next_ = 0;
  }

  std::uint64_t state_[size];
  std::uint64_t words_[size];
  int next_ = size;
};

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
  MersenneTwister engine_;
};

}  // namespace nfopidn
