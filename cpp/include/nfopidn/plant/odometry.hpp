// L1. Where the wheels lead a robot that does not slip.
#pragma once

#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

// The pose after the wheels have rolled `left` and `right` metres (REP-103) on an arc of a circle,
// exactly, however long. `track_width` [m].
template <class Scalar>
State<Scalar> odometry(const State<Scalar>& state, Scalar left, Scalar right,
                       base_t<Scalar> track_width) noexcept {
  using M = math<Scalar>;
  const Scalar turned = (right - left) / track_width;
  const Scalar distance = (left + right) / 2;
  // The chord is the arc times sin(h)/h with h half the angle, and lies at the mean heading.
  const Scalar half = turned / 2;
  const bool straight = half < Scalar(1e-4) && half > Scalar(-1e-4);
  const Scalar shrink = straight ? 1 - half * half / 6 : M::heading(half).sine / half;
  const Heading<Scalar> mean = M::heading(state.theta + half);
  State<Scalar> next = state;
  next.x = state.x + distance * shrink * mean.cosine;
  next.y = state.y + distance * shrink * mean.sine;
  next.theta = M::wrap(state.theta + turned);
  return next;
}

}  // namespace nfopidn
