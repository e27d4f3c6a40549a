// L4. SHA-256 (FIPS 180-4), by which a verdict tells what it is on.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace nfopidn {

namespace detail {

using Sha256State = std::array<std::uint32_t, 8>;

// The first bits of the fractional parts of the first primes' cube roots.
inline constexpr std::array<std::uint32_t, 64> sha256_constants = {
    0x428a2f98, 0x71374491, 0xb5c0fbcf, 0xe9b5dba5, 0x3956c25b, 0x59f111f1, 0x923f82a4, 0xab1c5ed5,
    0xd807aa98, 0x12835b01, 0x243185be, 0x550c7dc3, 0x72be5d74, 0x80deb1fe, 0x9bdc06a7, 0xc19bf174,
    0xe49b69c1, 0xefbe4786, 0x0fc19dc6, 0x240ca1cc, 0x2de92c6f, 0x4a7484aa, 0x5cb0a9dc, 0x76f988da,
    0x983e5152, 0xa831c66d, 0xb00327c8, 0xbf597fc7, 0xc6e00bf3, 0xd5a79147, 0x06ca6351, 0x14292967,
    0x27b70a85, 0x2e1b2138, 0x4d2c6dfc, 0x53380d13, 0x650a7354, 0x766a0abb, 0x81c2c92e, 0x92722c85,
    0xa2bfe8a1, 0xa81a664b, 0xc24b8b70, 0xc76c51a3, 0xd192e819, 0xd6990624, 0xf40e3585, 0x106aa070,
    0x19a4c116, 0x1e376c08, 0x2748774c, 0x34b0bcb5, 0x391c0cb3, 0x4ed8aa4a, 0x5b9cca4f, 0x682e6ff3,
    0x748f82ee, 0x78a5636f, 0x84c87814, 0x8cc70208, 0x90befffa, 0xa4506ceb, 0xbef9a3f7, 0xc67178f2};

constexpr std::uint32_t rotated(std::uint32_t word, int bits) {
  return (word >> bits) | (word << (32 - bits));
}

// Takes in a block of 64 bytes.
constexpr void sha256_block(Sha256State& state, const std::array<std::uint8_t, 64>& block) {
  std::array<std::uint32_t, 64> w = {};
  for (std::size_t t = 0; t < 16; ++t) {
    for (std::size_t i = 0; i < 4; ++i) w[t] = (w[t] << 8) | block[4 * t + i];
  }
  for (std::size_t t = 16; t < 64; ++t) {
    const std::uint32_t a = w[t - 15], b = w[t - 2];
    w[t] = w[t - 16] + (rotated(a, 7) ^ rotated(a, 18) ^ (a >> 3)) + w[t - 7] +
           (rotated(b, 17) ^ rotated(b, 19) ^ (b >> 10));
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (std::size_t t = 0; t < 64; ++t) {
    const std::uint32_t one = h + (rotated(e, 6) ^ rotated(e, 11) ^ rotated(e, 25)) +
                              ((e & f) ^ (~e & g)) + sha256_constants[t] + w[t];
    const std::uint32_t two =
        (rotated(a, 2) ^ rotated(a, 13) ^ rotated(a, 22)) + ((a & b) ^ (a & c) ^ (b & c));
    h = g;
    g = f;
    f = e;
    e = d + one;
    d = c;
    c = b;
    b = a;
    a = one + two;
  }
  const Sha256State rounds = {a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < state.size(); ++i) state[i] += rounds[i];
}

}  // namespace detail

// The first 8 of its 32 bytes.
constexpr std::uint64_t sha256_start(std::string_view text) {
  detail::Sha256State state = {0x6a09e667, 0xbb67ae85, 0x3c6ef372, 0xa54ff53a,
                               0x510e527f, 0x9b05688c, 0x1f83d9ab, 0x5be0cd19};
  std::array<std::uint8_t, 64> block = {};
  // The text, a bit, and its length in bits at the end of the last block.
  const std::size_t blocks = (text.size() + 8) / block.size() + 1;
  for (std::size_t n = 0; n < blocks; ++n) {
    for (std::size_t i = 0; i < block.size(); ++i) {
      const std::size_t place = n * block.size() + i;
      block[i] = place < text.size() ? static_cast<std::uint8_t>(text[place])
                                     : static_cast<std::uint8_t>(place == text.size() ? 0x80 : 0);
    }
    if (n + 1 == blocks) {
      const std::uint64_t bits = std::uint64_t{8} * text.size();
      for (std::size_t i = 0; i < 8; ++i) {
        block[63 - i] = static_cast<std::uint8_t>(bits >> (8 * i));
      }
    }
    detail::sha256_block(state, block);
  }
  return (std::uint64_t{state[0]} << 32) | state[1];
}

// The standard's own examples: of one block, of two, and of none of a text.
static_assert(sha256_start("abc") == 0xba7816bf8f01cfea);
static_assert(sha256_start("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq") ==
              0x248d6a61d20638b8);
static_assert(sha256_start("") == 0xe3b0c44298fc1c14);

}  // namespace nfopidn
