// L3. The 64-bit Mersenne twister of Nishimura and Matsumoto (MT19937-64): the same numbers as
// std::mt19937_64, made a block at a time in loops that compilers vectorise.
#pragma once

#include <cstdint>

#include "nfopidn/foundation/inlining.hpp"

namespace nfopidn {

class MersenneTwister {
 public:
  explicit MersenneTwister(std::uint64_t seed) {
    state_[0] = seed;
    for (unsigned i = 1; i < size; ++i) {
      const std::uint64_t last = state_[i - 1];
      state_[i] = 6364136223846793005U * (last ^ (last >> 62)) + i;
    }
  }

  std::uint64_t operator()() {
    if (next_ == size) make_block();
    return block_[next_++];
  }

 private:
  static constexpr int size = 312;
  static constexpr int half = 156;

  static std::uint64_t twist(std::uint64_t high, std::uint64_t low, std::uint64_t far) {
    constexpr std::uint64_t low_bits = 0x7FFFFFFF;
    const std::uint64_t joined = (high & ~low_bits) | (low & low_bits);
    return far ^ (joined >> 1) ^ ((0 - (joined & 1)) & 0xB5026F5AA96619E9U);
  }

  static std::uint64_t temper(std::uint64_t x) {
    x ^= (x >> 29) & 0x5555555555555555U;
    x ^= (x << 17) & 0x71D67FFFEDA60000U;
    x ^= (x << 37) & 0xFFF7EEE000000000U;
    return x ^ (x >> 43);
  }

  NFOPIDN_NOINLINE void make_block() {
    for (int i = 0; i < half; ++i) state_[i] = twist(state_[i], state_[i + 1], state_[i + half]);
    for (int i = half; i < size - 1; ++i) {
      state_[i] = twist(state_[i], state_[i + 1], state_[i - half]);
    }
    state_[size - 1] = twist(state_[size - 1], state_[0], state_[half - 1]);
    for (int i = 0; i < size; ++i) block_[i] = temper(state_[i]);
    next_ = 0;
  }

  std::uint64_t state_[size];
  std::uint64_t block_[size];
  int next_ = size;
};

}  // namespace nfopidn
