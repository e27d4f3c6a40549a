// L4. A digest of a file's content, by which damage shows.
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace nfopidn {

namespace detail {

constexpr std::array<std::uint64_t, 256> crc64_table() {
  constexpr std::uint64_t polynomial = 0xC96C5795D7870F42;  // of ECMA-182, lowest bit first
  std::array<std::uint64_t, 256> table = {};
  for (std::size_t byte = 0; byte < table.size(); ++byte) {
    std::uint64_t value = byte;
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ (value % 2 == 0 ? 0 : polynomial);
    table[byte] = value;
  }
  return table;
}

inline constexpr std::array<std::uint64_t, 256> crc64_values = crc64_table();

}  // namespace detail

// CRC-64/XZ. It differs for any two texts of one length that differ within 64 bits; other texts
// have the same one by chance alone, 1 in 2^64.
constexpr std::uint64_t crc64(std::string_view text) {
  std::uint64_t value = ~std::uint64_t{0};
  for (const char c : text) {
    value = (value >> 8) ^ detail::crc64_values[(value ^ static_cast<unsigned char>(c)) & 0xFF];
  }
  return ~value;
}

// The check value that the catalogues of CRCs give.
static_assert(crc64("123456789") == 0x995DC9BBDF1939FA);

}  // namespace nfopidn
