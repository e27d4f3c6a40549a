// L1. The slopes of an exponential motion, for dual numbers: the partial derivatives of where it
// ends are integrals like the path's own, taken once for all directions of the slopes.
#pragma once

#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/plant/relaxation.hpp"

namespace nfopidn {

namespace exact {

// Dual numbers, by what they have.
template <class Scalar, class = void>
constexpr bool has_slopes = false;
template <class Scalar>
constexpr bool has_slopes<Scalar, traits::void_t<decltype(traits::declval<Scalar&>().slope)>> =
    traits::is_same<decltype(Scalar::value), base_t<Scalar>>;

// Partial derivatives of the way along x and y.
template <class Base>
struct Partials {
  Base x = Base(0);
  Base y = Base(0);

  constexpr void add(Base weight, Base x_part, Base y_part) {
    x = x + weight * x_part;
    y = y + weight * y_part;
  }
};

// Cosines and sines at a panel's nodes. Dual numbers with lanes specialise it: all at once, to the
// same bits.
template <class Scalar>
struct NodeHeadings {
  template <class Base, int count>
  static constexpr void find(const Base (&angle)[count], Base (&cosine)[count],
                             Base (&sine)[count]) {
    for (int i = 0; i < count; ++i) {
      const Heading<Base> heading = math<Base>::heading(angle[i]);
      cosine[i] = heading.cosine;
      sine[i] = heading.sine;
    }
  }
};

template <class Scalar, class Base>
constexpr void travel_with_slopes(const ExponentialMotion<Scalar, Base>& motion, const Scalar& time,
                                  State<Scalar>& state) {
  using Rule = Quadrature<Base>;
  using M = math<Base>;
  const ExponentialMotion<Base, Base> values = {
      motion.v.value, motion.omega.value, motion.acceleration.value, motion.turn_acceleration.value,
      motion.rate,    motion.turn_rate};
  const Base span = time.value;
  const int panels = panels_for(motion, span);
  const Base half = span * (Base(0.5) / Base(panels));
  Partials<Base> way, speed, gain, turning,
      turn_gain;  // sums, and theirs by the motion's four numbers
  for (int panel = 0; panel < panels; ++panel) {
    Base time_at[Rule::count] = {};
    Base phi[Rule::count] = {}, psi[Rule::count] = {};  // of the speed, of the turning rate
    Base angle[Rule::count] = {}, cosine[Rule::count] = {}, sine[Rule::count] = {};
    for (int node = 0; node < Rule::count; ++node) {
      const Base t = half * (Base(2 * panel + 1) + Rule::abscissa(node));
      time_at[node] = t;
      phi[node] = decay<Base, Base, Scalar>(values.rate, t).phi;
      psi[node] = decay<Base, Base, Scalar>(values.turn_rate, t).psi;
      const Base turned = values.omega * t + values.turn_acceleration * psi[node];
      angle[node] = state.theta.value + turned;
    }
    NodeHeadings<Scalar>::find(angle, cosine, sine);
    for (int node = 0; node < Rule::count; ++node) {
      const Base weight = Rule::weight(node);
      const Base distance = (values.v + values.acceleration * phi[node]) * weight;
      way.add(distance, cosine[node], sine[node]);
      speed.add(weight, cosine[node], sine[node]);
      gain.add(weight * phi[node], cosine[node], sine[node]);
      turning.add(distance * time_at[node], -sine[node], cosine[node]);
      turn_gain.add(distance * psi[node], -sine[node], cosine[node]);
    }
  }
  const Decay<Base> linear = decay<Base, Base, Scalar>(values.rate, span);
  const Decay<Base> angular = decay<Base, Base, Scalar>(values.turn_rate, span);
  const Base turned = values.omega * span + values.turn_acceleration * angular.psi;
  const Heading<Base> last = M::heading(state.theta.value + turned);
  const Base last_speed = values.v + values.acceleration * linear.phi;
  const Base last_turning = values.omega + values.turn_acceleration * angular.phi;
  const auto slope = [&](Base by_theta, Base by_speed, Base by_gain, Base by_turning,
                         Base by_turn_gain, Base by_time) {
    return state.theta.slope * by_theta + motion.v.slope * by_speed +
           motion.acceleration.slope * by_gain + motion.omega.slope * by_turning +
           motion.turn_acceleration.slope * by_turn_gain + time.slope * by_time;
  };
  state.x.slope =
      state.x.slope + slope(-half * way.y, half * speed.x, half * gain.x, half * turning.x,
                            half * turn_gain.x, last_speed * last.cosine);
  state.y.slope =
      state.y.slope + slope(half * way.x, half * speed.y, half * gain.y, half * turning.y,
                            half * turn_gain.y, last_speed * last.sine);
  state.theta.slope = state.theta.slope + motion.omega.slope * span +
                      motion.turn_acceleration.slope * angular.psi + time.slope * last_turning;
  state.v.slope = motion.v.slope + motion.acceleration.slope * linear.phi +
                  time.slope * (values.acceleration * linear.left);
  state.omega.slope = motion.omega.slope + motion.turn_acceleration.slope * angular.phi +
                      time.slope * (values.turn_acceleration * angular.left);
  state.x.value = state.x.value + way.x * half;
  state.y.value = state.y.value + way.y * half;
  state.theta.value = state.theta.value + turned;
  state.v.value = last_speed;
  state.omega.value = last_turning;
}

}  // namespace exact

}  // namespace nfopidn
