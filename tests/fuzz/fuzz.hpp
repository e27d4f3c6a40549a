// What the fuzz targets share: a property that must hold, and numbers made of arbitrary bytes.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

namespace nfopidn::fuzz {

// libFuzzer keeps the input of a run that aborts.
inline void require(bool holds, const char* property) {
  if (holds) return;
  std::fprintf(stderr, "fuzz: does not hold: %s\n", property);
  std::abort();
}

// An input's bytes, from the front; zeros once they are used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  bool empty() const { return size_ == 0; }

  template <class Value>
  Value take() {
    Value value{};
    const std::size_t count = size_ < sizeof value ? size_ : sizeof value;
    if (count > 0) std::memcpy(&value, data_, count);
    data_ += count;
    size_ -= count;
    return value;
  }

  // Any bits; but raw bytes seldom make a number near 1, or one at the edge of the type.
  template <class Scalar>
  Scalar number() {
    using Limits = std::numeric_limits<Scalar>;
    constexpr Scalar special[] = {0,
                                  Limits::infinity(),
                                  -Limits::infinity(),
                                  Limits::quiet_NaN(),
                                  Limits::max(),
                                  Limits::lowest(),
                                  Limits::min(),
                                  Limits::denorm_min(),
                                  Scalar(1e6),
                                  Scalar(-1e6)};
    constexpr std::uint8_t count = sizeof special / sizeof special[0];
    const auto kind = take<std::uint8_t>();
    if (kind < count) return special[kind];
    if (kind < 64) return take<Scalar>();
    return static_cast<Scalar>(take<std::int16_t>()) / Scalar(4096);
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

}  // namespace nfopidn::fuzz
