// L1. When something that moves comes to zero: the events between which a robot with Coulomb
// friction moves smoothly.
#pragma once

#include "nfopidn/math/math.hpp"

namespace nfopidn {

namespace exact {

template <class Base>
constexpr Base rounding = Base(4096) * kernel::Coefficients<Base>::epsilon;

// The first time in (0, span] at which the function, positive just after 0, becomes negative;
// span if it does not. The function rises and falls at most once each, `slope` being its
// derivative; a dip below zero no deeper than rounding errors is none. Both take times of either
// type and give numbers of the same: the search needs none of a dual number's slopes.
template <class Scalar, class Base, class Function, class Slope>
constexpr Scalar first_crossing(const Function& function, const Slope& slope, Base span) {
  constexpr int bisections = 60;
  Base low = Base(0);
  Base high = span;
  if (!(function(span) < Base(0))) {
    if (!(slope(Base(0)) < Base(0)) || slope(span) < Base(0)) return Scalar(span);
    for (int i = 0; i < bisections; ++i) {  // to the bottom of the dip
      const Base middle = (low + high) * Base(0.5);
      (slope(middle) < Base(0) ? low : high) = middle;
    }
    if (!(function(low) < -rounding<Base>)) return Scalar(span);
    high = low;
    low = Base(0);
  }
  for (int i = 0; i < bisections; ++i) {
    const Base middle = (low + high) * Base(0.5);
    (function(middle) < Base(0) ? high : low) = middle;
  }
  // One Newton step in Scalar gives a dual number its partials.
  const Scalar root = Scalar(high);
  return root - function(root) / slope(root);
}

}  // namespace exact

}  // namespace nfopidn
