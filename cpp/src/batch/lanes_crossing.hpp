// When what relaxes comes to zero, lane by lane: plant/exact_motion.hpp's first_crossing().
#pragma once

#include "lanes_path.hpp"
#include "nfopidn/plant/exact_motion.hpp"

namespace nfopidn {

namespace lanes {

// What is left at time t until an event: value + linear phi(rate t) + angular phi(turn_rate t).
template <class V>
struct Margin {
  V value, linear, angular;
};

// The first time at which a margin, positive just after 0, becomes negative. It rises and falls at
// most once each.
template <class V>
class Crossing {
 public:
  using M = math<V>;
  using Mask = typename V::Mask;

  NFOPIDN_INLINE Crossing(const V& rate, const V& turn_rate, double longest)
      : linear_(rate, longest), angular_(turn_rate, longest), rate_(rate), turn_rate_(turn_rate) {}

  // Of the lanes asked for; those have it in `crosses`, and the others get the end of the span.
  NFOPIDN_NOINLINE V find(const Margin<V>& margin, const V& span, const Mask& asked,
                          Mask& crosses) const {
    const At end = at(margin, span);
    V high = span;
    crosses = asked & (end.value < 0.0);
    look_into_dips(margin, end, asked, high, crosses);
    return M::any(crosses) ? M::select(crosses, root(margin, high, crosses), span) : span;
  }

 private:
  struct At {
    V value, slope;
  };

  NFOPIDN_INLINE At at(const Margin<V>& margin, const V& time) const {
    const exact::Decay<V> linear = linear_(time);
    const exact::Decay<V> angular = angular_(time);
    return {margin.value + (margin.linear * linear.phi + margin.angular * angular.phi),
            margin.linear * linear.left + margin.angular * angular.left};
  }

  // A margin may fall below zero and be back by the end: its least value is where both terms of
  // its slope are equal. A dip no deeper than rounding errors is none.
  NFOPIDN_INLINE void look_into_dips(const Margin<V>& margin, const At& end, const Mask& asked,
                                     V& high, Mask& crosses) const {
    const Mask dips = (asked & (margin.linear + margin.angular < 0.0)) &
                      ((V(0.0) <= end.value) & (end.slope > 0.0));
    if (!M::any(dips)) return;
    const V ratio = M::select(dips, margin.linear * -1.0 / margin.angular, V(1.0));
    const V difference = M::select(dips, rate_ - turn_rate_, V(1.0));
    const V bottom = M::minimum(M::maximum(M::log(ratio) / difference, V(0.0)), high);
    const Mask deep = dips & (at(margin, bottom).value < -exact::rounding<double>);
    high = M::select(deep, bottom, high);
    crosses = crosses | deep;
  }

  // Newton's method between times that enclose the crossing, and their middle where it leads out
  // from between them. A lane that has found it waits for the others.
  NFOPIDN_INLINE V root(const Margin<V>& margin, V high, Mask open) const {
    constexpr int most_steps = 100;
    constexpr double near = 2 * kernel::Coefficients<double>::epsilon;
    V low(0.0);
    const V straight = high * (margin.value / (margin.value - at(margin, high).value));
    V time = M::select(margin.value > 0.0, straight, high * 0.5);
    for (int i = 0; i < most_steps; ++i) {
      const At now = at(margin, time);
      const Mask below = now.value < 0.0;
      high = M::select(below, time, high);
      low = M::select(below, low, time);
      V next = time - now.value / now.slope;
      next = M::select((low <= next) & (next <= high), next, (low + high) * 0.5);
      const Mask moves = Travel<V>::magnitude(next - time) > high * near;
      time = M::select(open, next, time);
      open = open & moves;
      if (!M::any(open)) break;
    }
    return time;
  }

  Relaxation<V, V> linear_, angular_;
  V rate_, turn_rate_;
};

}  // namespace lanes

}  // namespace nfopidn
