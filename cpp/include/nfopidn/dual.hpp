// L0. Dual numbers: a value and its derivative in one direction. With lanes as Part, each lane
// carries a direction of its own, and one run gives the value and all partial derivatives.
#pragma once

#include "nfopidn/math.hpp"

namespace nfopidn {

template <class Part>
struct Dual {
  using Base = base_t<Part>;

  Part value;
  Part slope;

  Dual() = default;
  NFOPIDN_INLINE constexpr Dual(const Part& v, const Part& s) : value(v), slope(s) {}
  NFOPIDN_INLINE explicit constexpr Dual(Base constant)
      : value(Part(constant)), slope(Part(Base(0))) {}

  NFOPIDN_INLINE friend constexpr Dual operator+(const Dual& a, const Dual& b) {
    return {a.value + b.value, a.slope + b.slope};
  }
  NFOPIDN_INLINE friend constexpr Dual operator+(const Dual& a, Base b) {
    return {a.value + b, a.slope};
  }
  NFOPIDN_INLINE friend constexpr Dual operator+(Base a, const Dual& b) {
    return {a + b.value, b.slope};
  }
  NFOPIDN_INLINE friend constexpr Dual operator-(const Dual& a, const Dual& b) {
    return {a.value - b.value, a.slope - b.slope};
  }
  NFOPIDN_INLINE friend constexpr Dual operator-(const Dual& a, Base b) {
    return {a.value - b, a.slope};
  }
  NFOPIDN_INLINE friend constexpr Dual operator-(Base a, const Dual& b) {
    return {a - b.value, b.slope * Base(-1)};
  }
  NFOPIDN_INLINE friend constexpr Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  NFOPIDN_INLINE friend constexpr Dual operator*(const Dual& a, Base b) {
    return {a.value * b, a.slope * b};
  }
  NFOPIDN_INLINE friend constexpr Dual operator*(Base a, const Dual& b) { return b * a; }
  NFOPIDN_INLINE friend constexpr Dual operator/(const Dual& a, const Dual& b) {
    const Part quotient = a.value / b.value;
    return {quotient, (a.slope - quotient * b.slope) / b.value};
  }
  NFOPIDN_INLINE friend constexpr Dual operator/(const Dual& a, Base b) {
    return {a.value / b, a.slope / b};
  }
  NFOPIDN_INLINE constexpr Dual& operator+=(const Dual& other) { return *this = *this + other; }
  NFOPIDN_INLINE constexpr Dual& operator-=(const Dual& other) { return *this = *this - other; }

  // Comparisons are of the values.
  NFOPIDN_INLINE friend constexpr auto operator<(const Dual& a, const Dual& b) {
    return a.value < b.value;
  }
  NFOPIDN_INLINE friend constexpr auto operator>(const Dual& a, const Dual& b) {
    return a.value > b.value;
  }
  NFOPIDN_INLINE friend constexpr auto operator<=(const Dual& a, Base b) { return a.value <= b; }
  NFOPIDN_INLINE friend constexpr auto operator>=(const Dual& a, Base b) { return a.value >= b; }
  NFOPIDN_INLINE friend constexpr auto operator==(const Dual& a, const Dual& b) {
    return a.value == b.value;
  }
};

template <class Part>
struct math<Dual<Part>> {
  using Scalar = Dual<Part>;
  using P = math<Part>;
  using Base = typename P::Base;
  using Mask = typename P::Mask;

  static constexpr Base angle_unit = P::angle_unit;
  static constexpr Base net_scale = P::net_scale;
  static constexpr bool has_order = P::has_order;

  NFOPIDN_INLINE static Heading<Scalar> heading(const Scalar& angle) {
    const Heading<Part> h = P::heading(angle.value);
    const Part turn = angle.slope * (Base(1) / angle_unit);
    return {{h.cosine, h.sine * turn * Base(-1)}, {h.sine, h.cosine * turn}};
  }
  NFOPIDN_INLINE static Scalar wrap(const Scalar& angle) {
    return {P::wrap(angle.value), angle.slope};
  }
  template <class Three>
  NFOPIDN_INLINE static void sigmoids(Three& net) {
    struct {
      Part x, y, theta;
    } out = {net.x.value, net.y.value, net.theta.value};
    P::sigmoids(out);
    const auto chain = [](Scalar& channel, const Part& output) {
      channel = {output, (Base(1) - output * output) * channel.slope * (Base(0.5) / net_scale)};
    };
    chain(net.x, out.x);
    chain(net.y, out.y);
    chain(net.theta, out.theta);
  }
  NFOPIDN_INLINE static Scalar identity(const Scalar& net) {
    return {P::identity(net.value), P::identity(net.slope)};
  }
  NFOPIDN_INLINE static Scalar from_radians(const Scalar& angle) { return angle * angle_unit; }
  NFOPIDN_INLINE static Scalar to_radians(const Scalar& angle) {
    return {P::to_radians(angle.value), P::to_radians(angle.slope)};
  }
  NFOPIDN_INLINE static Base base_from_radians(Base angle) { return P::base_from_radians(angle); }
  NFOPIDN_INLINE static Scalar select(const Mask& mask, const Scalar& yes, const Scalar& no) {
    return {P::select(mask, yes.value, no.value), P::select(mask, yes.slope, no.slope)};
  }
  NFOPIDN_INLINE static Scalar minimum(const Scalar& a, const Scalar& b) {
    return select(b < a, b, a);
  }
  NFOPIDN_INLINE static Scalar maximum(const Scalar& a, const Scalar& b) {
    return select(a < b, b, a);
  }
  NFOPIDN_INLINE static Scalar absolute(const Scalar& a) { return maximum(a, a * Base(-1)); }
  NFOPIDN_INLINE static Base value(const Scalar& a) { return P::value(a.value); }
  NFOPIDN_INLINE static constexpr Mask all() { return P::all(); }
  NFOPIDN_INLINE static bool any(const Mask& mask) { return P::any(mask); }
};

}  // namespace nfopidn
