// L1. Speeds that relax at a constant rate, and the quadrature of the way under them.
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

// How often a product of rate and time must be halved to be 1/2 at most.
template <class Base>
NFOPIDN_INLINE constexpr int halvings(Base product) {
  int count = 0;
  for (; product > Base(0.5) && count < 64; ++count) product = product * Base(0.5);
  return count;
}

// The same as shares of t and t^2, so that they depend on x = k t alone: e^-x, (1 - e^-x)/x and
// (x - 1 + e^-x)/x^2 by their series, |x| <= 1/2. `User` is for whom it is compiled: code for
// different instruction sets must not share it.
template <class Scalar, class Base, class User = Scalar>
constexpr Decay<Scalar> decay_shares(const Scalar& x) {
  Scalar first = Scalar(Base(0));
  Scalar second = Scalar(Base(0));
  for (int n = 14; n >= 1; --n) {
    first = (Scalar(Base(1)) - first * x) * (Base(1) / Base(n));
    second = (Scalar(Base(1)) - second * x) * (Base(1) / Base(n + 1));
  }
  return {Scalar(Base(1)) - x * first, first, second};
}

// By its value at a time 2^halvings sooner.
template <class Scalar, class Base, class User = Scalar>
constexpr Decay<Scalar> decay(Base rate, const Scalar& time, int halvings) {
  if (rate == Base(0)) return {Scalar(Base(1)), time, time * time * Base(0.5)};
  Scalar x = time * rate;
  for (int i = 0; i < halvings; ++i) x = x * Base(0.5);
  auto [left, first, second] = decay_shares<Scalar, Base, User>(x);
  for (int i = 0; i < halvings; ++i) {
    first = first * (Scalar(Base(1)) + left) * Base(0.5);
    left = left * left;
    x = x * Base(2);
    second = (Scalar(Base(1)) - first) / x;
  }
  return {left, time * first, time * time * second};
}

template <class Scalar, class Base, class User = Scalar>
constexpr Decay<Scalar> decay(Base rate, const Scalar& time) {
  return decay<Scalar, Base, User>(rate, time, halvings(math<Scalar>::value(time * rate)));
}

// Gauss and Legendre's rule of eight nodes.
template <class Base>
struct Quadrature {
  static constexpr int count = 8;
  NFOPIDN_INLINE static constexpr Base abscissa(int node) {
    constexpr Base nodes[] = {Base(0.18343464249564980494), Base(0.52553240991632898582),
                              Base(0.79666647741362673959), Base(0.96028985649753623168)};
    return node < 4 ? nodes[node] : -nodes[node - 4];
  }
  NFOPIDN_INLINE static constexpr Base weight(int node) {
    constexpr Base weights[] = {Base(0.36268378337836198297), Base(0.31370664587788728734),
                                Base(0.22238103445337447054), Base(0.10122853629037625915)};
    return weights[node & 3];
  }
};

// v and omega from known start values, each relaxing at its own rate.
template <class Scalar, class Base, class User = Scalar>
struct ExponentialMotion {
  Scalar v, omega;                         // at the start
  Scalar acceleration, turn_acceleration;  // at the start
  Base rate, turn_rate;                    // [1/s]

  constexpr Scalar speed(const Scalar& t) const {
    return v + acceleration * decay<Scalar, Base, User>(rate, t).phi;
  }
  constexpr Scalar turning(const Scalar& t) const {
    return omega + turn_acceleration * decay<Scalar, Base, User>(turn_rate, t).phi;
  }
  constexpr Scalar angle(const Scalar& t) const {
    return omega * t + turn_acceleration * decay<Scalar, Base, User>(turn_rate, t).psi;
  }
};

// How many panels a quadrature of the motion needs.
template <class Scalar, class Base>
constexpr int panels_for(const ExponentialMotion<Scalar, Base>& motion, Base span) {
  using M = math<Scalar>;
  const Base omega = M::value(motion.omega);
  const Base last = omega + M::value(motion.turn_acceleration) *
                                decay<Base, Base, Scalar>(motion.turn_rate, span).phi;
  const Base turned = ((omega < 0 ? -omega : omega) + (last < 0 ? -last : last)) * span;
  const Base slowed = (motion.rate > motion.turn_rate ? motion.rate : motion.turn_rate) * span;
  const Base wanted = (turned > slowed ? turned : slowed) * Base(0.5);
  return wanted < Base(max_panels - 1) ? 1 + static_cast<int>(wanted) : max_panels;
}

}  // namespace exact

}  // namespace nfopidn
