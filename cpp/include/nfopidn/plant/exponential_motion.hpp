// L1. Motion in which v and omega each relax at a constant rate: closed form in speed and heading,
// quadrature in the pose.
#pragma once

#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

namespace exact {

constexpr int max_panels = 256;

// left = e^{-k t}, phi its integral from 0 to t, and psi, the integral of phi.
template <class Scalar>
struct Decay {
  Scalar left;
  Scalar phi;
  Scalar psi;
};

template <class Scalar, class Base>
constexpr Decay<Scalar> decay(Base rate, const Scalar& time) {
  if (rate == Base(0)) return {Scalar(Base(1)), time, time * time * Base(0.5)};
  Scalar x = time * rate;
  int halvings = 0;
  while (math<Scalar>::value(x) > Base(0.5) && halvings < 64) {
    x = x * Base(0.5);
    ++halvings;
  }
  // (1 - e^-x)/x and (x - 1 + e^-x)/x^2 by their series, |x| <= 1/2.
  Scalar first = Scalar(Base(0));
  Scalar second = Scalar(Base(0));
  for (int n = 14; n >= 1; --n) {
    first = (Scalar(Base(1)) - first * x) * (Base(1) / Base(n));
    second = (Scalar(Base(1)) - second * x) * (Base(1) / Base(n + 1));
  }
  Scalar left = Scalar(Base(1)) - x * first;
  for (int i = 0; i < halvings; ++i) {
    first = first * (Scalar(Base(1)) + left) * Base(0.5);
    left = left * left;
    x = x * Base(2);
    second = (Scalar(Base(1)) - first) / x;
  }
  return {left, time * first, time * time * second};
}

// v and omega from known start values, each relaxing at its own rate.
template <class Scalar, class Base>
struct ExponentialMotion {
  Scalar v, omega;                         // at the start
  Scalar acceleration, turn_acceleration;  // at the start
  Base rate, turn_rate;                    // [1/s]

  constexpr Scalar speed(const Scalar& t) const { return v + acceleration * decay(rate, t).phi; }
  constexpr Scalar turning(const Scalar& t) const {
    return omega + turn_acceleration * decay(turn_rate, t).phi;
  }
  constexpr Scalar angle(const Scalar& t) const {
    return omega * t + turn_acceleration * decay(turn_rate, t).psi;
  }
};

// Moves the state along an exponential motion for a time [s].
template <class Scalar, class Base>
constexpr void travel(const ExponentialMotion<Scalar, Base>& motion, const Scalar& time,
                      State<Scalar>& state) {
  // Eight nodes on panels of at most 2 rad and 2 time constants: below 1e-15 of the path's length.
  constexpr Base nodes[] = {Base(0.18343464249564980494), Base(0.52553240991632898582),
                            Base(0.79666647741362673959), Base(0.96028985649753623168)};
  constexpr Base weights[] = {Base(0.36268378337836198297), Base(0.31370664587788728734),
                              Base(0.22238103445337447054), Base(0.10122853629037625915)};
  using M = math<Scalar>;
  const Base span = M::value(time);
  const Base turned =
      (M::value(M::absolute(motion.omega)) + M::value(M::absolute(motion.turning(time)))) * span;
  const Base slowed = (motion.rate > motion.turn_rate ? motion.rate : motion.turn_rate) * span;
  const Base wanted = (turned > slowed ? turned : slowed) * Base(0.5);
  const int panels = wanted < Base(max_panels - 1) ? 1 + static_cast<int>(wanted) : max_panels;

  Scalar x = Scalar(Base(0));
  Scalar y = Scalar(Base(0));
  const Scalar half = time * (Base(0.5) / Base(panels));
  for (int panel = 0; panel < panels; ++panel) {
    for (int node = 0; node < 8; ++node) {
      const Base abscissa = node < 4 ? nodes[node] : -nodes[node - 4];
      const Scalar t = half * (Base(2 * panel + 1) + abscissa);
      const Heading<Scalar> heading = M::heading(state.theta + motion.angle(t));
      const Scalar distance = motion.speed(t) * weights[node & 3];
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
