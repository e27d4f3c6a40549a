// L0. Dual numbers: a value and its derivative in one direction. With lanes as Slope, each lane
// carries a direction of its own, and one run gives the value and all partial derivatives.
#pragma once

#include <type_traits>

#include "nfopidn/math/math.hpp"

namespace nfopidn {

template <class Value, class Slope = Value>
struct Dual {
  using Base = base_t<Value>;

  Value value;
  Slope slope;

  Dual() = default;
  NFOPIDN_INLINE constexpr Dual(const Value& v, const Slope& s) : value(v), slope(s) {}
  NFOPIDN_INLINE explicit constexpr Dual(Base constant)
      : value(Value(constant)), slope(Slope(Base(0))) {}

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
  NFOPIDN_INLINE friend constexpr Dual operator-(const Dual& a) { return a * Base(-1); }
  NFOPIDN_INLINE friend constexpr Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.slope * b.value + a.value * b.slope};
  }
  NFOPIDN_INLINE friend constexpr Dual operator*(const Dual& a, Base b) {
    return {a.value * b, a.slope * b};
  }
  NFOPIDN_INLINE friend constexpr Dual operator*(Base a, const Dual& b) { return b * a; }
  NFOPIDN_INLINE friend constexpr Dual operator/(const Dual& a, const Dual& b) {
    const Value quotient = a.value / b.value;
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

template <class Value, class Slope>
struct math<Dual<Value, Slope>> {
  using Scalar = Dual<Value, Slope>;
  using P = math<Value>;
  using Base = typename P::Base;
  using Mask = typename P::Mask;

  static constexpr Base net_scale = P::net_scale;

  NFOPIDN_INLINE static Heading<Scalar> heading(const Scalar& angle) {
    const Heading<Value> h = P::heading(angle.value);
    return {{h.cosine, angle.slope * (h.sine * Base(-1))}, {h.sine, angle.slope * h.cosine}};
  }
  NFOPIDN_INLINE static Scalar wrap(const Scalar& angle) {
    return {P::wrap(angle.value), angle.slope};
  }
  template <class Three>
  NFOPIDN_INLINE static void sigmoids(Three& net) {
    struct {
      Value x, y, theta;
    } out = {net.x.value, net.y.value, net.theta.value};
    P::sigmoids(out);
    const auto chain = [](Scalar& channel, const Value& output) {
      const Value steepness = (Base(1) - output * output) * (Base(0.5) / net_scale);
      channel = {output, channel.slope * steepness};
    };
    chain(net.x, out.x);
    chain(net.y, out.y);
    chain(net.theta, out.theta);
  }
  NFOPIDN_INLINE static Scalar identity(const Scalar& net) {
    return {P::identity(net.value), net.slope * (Base(1) / net_scale)};
  }
  NFOPIDN_INLINE static Scalar exponential(const Scalar& exponent) {
    const Value value = P::exponential(exponent.value);
    return {value, exponent.slope * value};
  }
  NFOPIDN_INLINE static Scalar log(const Scalar& positive) {
    return {P::log(positive.value), positive.slope / positive.value};
  }
  NFOPIDN_INLINE static Scalar select(const Mask& mask, const Scalar& yes, const Scalar& no) {
    if constexpr (std::is_same_v<Mask, bool>) {
      return mask ? yes : no;
    } else {
      return {P::select(mask, yes.value, no.value), P::select(mask, yes.slope, no.slope)};
    }
  }
  NFOPIDN_INLINE static Scalar minimum(const Scalar& a, const Scalar& b) {
    return select(b < a, b, a);
  }
  NFOPIDN_INLINE static Scalar maximum(const Scalar& a, const Scalar& b) {
    return select(a < b, b, a);
  }
  NFOPIDN_INLINE static Scalar absolute(const Scalar& a) { return maximum(a, a * Base(-1)); }
  NFOPIDN_INLINE static Base value(const Scalar& a) { return P::value(a.value); }
  NFOPIDN_INLINE static Mask both(const Mask& a, const Mask& b) { return P::both(a, b); }
  NFOPIDN_INLINE static Mask either(const Mask& a, const Mask& b) { return P::either(a, b); }
  NFOPIDN_INLINE static constexpr Mask all() { return P::all(); }
  NFOPIDN_INLINE static bool any(const Mask& mask) { return P::any(mask); }
  NFOPIDN_INLINE static bool every(const Mask& mask) { return P::every(mask); }
  NFOPIDN_INLINE static bool surely_under(const Scalar& amount, Base limit) {
    return P::surely_under(amount.value, limit);
  }
  NFOPIDN_INLINE static bool within(const Scalar& a, const Scalar& b, Base limit) {
    return P::within(a.value, b.value, limit);
  }
};

}  // namespace nfopidn
