// Many candidates at once: a Scalar of `count` vectors of `width` doubles.
//
// GCC's and Clang's vector extensions; the compiler turns them into whatever instructions the
// translation unit may use. Several vectors a Scalar give the processor independent work while one
// step's chain of dependent operations runs. The type differs by width, so that code for one
// instruction set never shares a template instantiation with code for another. No function of
// layers L0-L2 that is not a template on this type may be called here without being inlined.
#pragma once

#include <cstdint>

#include "nfopidn/math/math.hpp"

namespace nfopidn {

template <int width>
struct Vectors {
  using Real [[gnu::vector_size(8 * width)]] = double;
  using Bits [[gnu::vector_size(8 * width)]] = std::int64_t;
};

template <int width, int count>
struct LaneMask {
  typename Vectors<width>::Bits part[count];

  NFOPIDN_INLINE friend LaneMask operator&(const LaneMask& a, const LaneMask& b) {
    LaneMask result;
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] & b.part[i];
    return result;
  }
  NFOPIDN_INLINE friend LaneMask operator~(const LaneMask& a) {
    LaneMask result;
    for (int i = 0; i < count; ++i) result.part[i] = ~a.part[i];
    return result;
  }
  NFOPIDN_INLINE friend LaneMask operator|(const LaneMask& a, const LaneMask& b) {
    LaneMask result;
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] | b.part[i];
    return result;
  }
};

template <int width, int count>
struct Lanes {
  static constexpr int size = width * count;
  using Real = typename Vectors<width>::Real;
  using Mask = LaneMask<width, count>;

  Real part[count];

  Lanes() = default;
  // Vector by vector: the compiler copies arrays through memory in pieces of its own, and reading a
  // vector that was written in pieces waits.
  NFOPIDN_INLINE Lanes(const Lanes& other) {
    for (int i = 0; i < count; ++i) part[i] = other.part[i];
  }
  NFOPIDN_INLINE Lanes& operator=(const Lanes& other) {
    for (int i = 0; i < count; ++i) part[i] = other.part[i];
    return *this;
  }
  NFOPIDN_INLINE explicit Lanes(double value) {
    for (auto& p : part) p = Real{} + value;
  }

  NFOPIDN_INLINE void set(int lane, double value) { part[lane / width][lane % width] = value; }
  NFOPIDN_INLINE double get(int lane) const { return part[lane / width][lane % width]; }

#define NFOPIDN_LANES_ARITHMETIC(op)                                         \
  NFOPIDN_INLINE friend Lanes operator op(const Lanes& a, const Lanes& b) {  \
    Lanes result;                                                            \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b.part[i]; \
    return result;                                                           \
  }                                                                          \
  NFOPIDN_INLINE friend Lanes operator op(const Lanes& a, double b) {        \
    Lanes result;                                                            \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b;         \
    return result;                                                           \
  }                                                                          \
  NFOPIDN_INLINE friend Lanes operator op(double a, const Lanes& b) {        \
    Lanes result;                                                            \
    for (int i = 0; i < count; ++i) result.part[i] = a op b.part[i];         \
    return result;                                                           \
  }
  NFOPIDN_LANES_ARITHMETIC(+)
  NFOPIDN_LANES_ARITHMETIC(-)
  NFOPIDN_LANES_ARITHMETIC(*)
  NFOPIDN_LANES_ARITHMETIC(/)
#undef NFOPIDN_LANES_ARITHMETIC

#define NFOPIDN_LANES_COMPARISON(op)                                         \
  NFOPIDN_INLINE friend Mask operator op(const Lanes& a, const Lanes& b) {   \
    Mask result;                                                             \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b.part[i]; \
    return result;                                                           \
  }                                                                          \
  NFOPIDN_INLINE friend Mask operator op(const Lanes& a, double b) {         \
    Mask result;                                                             \
    for (int i = 0; i < count; ++i) result.part[i] = a.part[i] op b;         \
    return result;                                                           \
  }
  NFOPIDN_LANES_COMPARISON(<)
  NFOPIDN_LANES_COMPARISON(>)
  NFOPIDN_LANES_COMPARISON(<=)
  NFOPIDN_LANES_COMPARISON(==)
#undef NFOPIDN_LANES_COMPARISON
};

}  // namespace nfopidn
