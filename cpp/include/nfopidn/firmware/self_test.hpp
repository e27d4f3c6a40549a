// L2. Whether the arithmetic on the processor is what this library was compiled for.
#pragma once

#include "nfopidn/math/math.hpp"

namespace nfopidn {

enum class SelfTest : unsigned char {
  ok,
  wrong,         // the elementary functions are wrong: the torques would be, too
  not_a_number,  // NaN is taken for a number, so that bad measurements would go unnoticed
  other_bits,    // right, but not to the last bit, as where products are contracted (see
                 // -ffp-contract=off) or the processor does not round to the nearest
};

namespace detail {

// What the law computes of an angle and of a net.
template <class Scalar>
struct Elementary {
  Scalar wrapped;
  Scalar cosine;
  Scalar sine;
  Scalar neuron;
};

template <class Scalar>
constexpr Elementary<Scalar> elementary(Scalar angle, Scalar net) noexcept {
  using M = math<Scalar>;
  const Heading<Scalar> heading = M::heading(angle);
  return {M::wrap(angle), heading.cosine, heading.sine, M::sigmoid(net)};
}

template <class Scalar>
struct SelfTestCase {
  Scalar angle;
  Scalar net;
  Elementary<Scalar> expected;

  // The compiler's own arithmetic, in constant expressions, is exactly rounded.
  constexpr SelfTestCase(double a, double n) noexcept
      : angle(Scalar(a)), net(Scalar(n)), expected(elementary(angle, net)) {}
};

}  // namespace detail

// Computes what the law computes of an angle and of a net, and compares it with what the compiler
// found beforehand. For the start of a firmware; takes a few hundred instructions. Of float or
// double.
template <class Scalar>
SelfTest self_test() noexcept {
  using M = math<Scalar>;
  constexpr detail::SelfTestCase<Scalar> cases[] = {{0.5, 0.03125}, {2.25, 0.75}, {3.5, -2.5},
                                                    {-4.0, 5.0},    {20.25, 9.0}, {-301.5, -0.3}};
  SelfTest verdict = SelfTest::ok;
  const auto compare = [&](Scalar value, Scalar expected) {
    const Scalar error = M::absolute(value - expected);
    const Scalar slack = sizeof(Scalar) == 8 ? Scalar(1e-12) : Scalar(1e-5);
    if (!(error <= slack)) {
      verdict = SelfTest::wrong;
    } else if (error > Scalar(0) && verdict == SelfTest::ok) {
      verdict = SelfTest::other_bits;
    }
  };
  for (const auto& test : cases) {
    volatile Scalar angle = test.angle;  // volatile, or it would be computed beforehand once more
    volatile Scalar net = test.net;
    const detail::Elementary<Scalar> found = detail::elementary<Scalar>(angle, net);
    compare(found.wrapped, test.expected.wrapped);
    compare(found.cosine, test.expected.cosine);
    compare(found.sine, test.expected.sine);
    compare(found.neuron, test.expected.neuron);
  }
  if (verdict == SelfTest::wrong) return verdict;
  volatile Scalar zero = 0;
  const Scalar nothing = zero / zero;
  if (M::is_finite(nothing) || M::absolute(nothing) <= Scalar(1)) return SelfTest::not_a_number;
  return verdict;
}

}  // namespace nfopidn
