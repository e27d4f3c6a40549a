// L1. Motion in which v and omega each relax at a constant rate: closed form in speed and heading,
// quadrature in the pose.
#pragma once

#include "nfopidn/plant/motion_slopes.hpp"
#include "nfopidn/plant/relaxation.hpp"

namespace nfopidn {

namespace exact {

// Moves the state along an exponential motion for a time [s].
template <class Scalar, class Base>
constexpr void travel(const ExponentialMotion<Scalar, Base>& motion, const Scalar& time,
                      State<Scalar>& state) {
  if constexpr (has_slopes<Scalar>) return travel_with_slopes(motion, time, state);
  // Eight nodes on panels of at most 2 rad and 2 time constants: below 1e-15 of the path's length.
  using Rule = Quadrature<Base>;
  using M = math<Scalar>;
  const int panels = panels_for(motion, M::value(time));

  Scalar x = Scalar(Base(0));
  Scalar y = Scalar(Base(0));
  const Scalar half = time * (Base(0.5) / Base(panels));
  for (int panel = 0; panel < panels; ++panel) {
    for (int node = 0; node < Rule::count; ++node) {
      const Scalar t = half * (Base(2 * panel + 1) + Rule::abscissa(node));
      const Heading<Scalar> heading = M::heading(state.theta + motion.angle(t));
      const Scalar distance = motion.speed(t) * Rule::weight(node);
      x = x + distance * heading.cosine;
      y = y + distance * heading.sine;
    }
  }
  state.x = state.x + x * half;
  state.y = state.y + y * half;
  state.theta = state.theta + motion.angle(time);
  state.v = motion.speed(time);
  state.omega = motion.turning(time);
}

}  // namespace exact

}  // namespace nfopidn
