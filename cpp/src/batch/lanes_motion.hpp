// The exact motion of lanes: what plant/exact_motion.hpp finds by branching, vector by vector.
#pragma once

#include "lanes_nodes.hpp"
#include "lanes_stepper.hpp"

namespace nfopidn {

namespace lanes {

// One vector, without friction.
template <class V>
NFOPIDN_INLINE void unbraked_step(const Motion<V>& motion, double span, const Heading<V>& heading,
                                  State<V>& state) {
  move(Travel<V>::unbraked(motion, V(span)), heading, state);
  state.v = state.v + motion.acceleration * span;
  state.omega = state.omega + motion.turn_acceleration * span;
}

// One vector, of one robot.
template <class V>
NFOPIDN_INLINE void exact_step(const Acceleration<double>& acceleration,
                               const FrictionCoefficients<double>& friction, double span,
                               const V& linear, const V& angular, const Heading<V>& heading,
                               State<V>& state) {
  if (friction.scrub != 0) {
    scrubbed_step(acceleration, friction, span, linear, angular, heading, state);
    return;
  }
  if (friction.coulomb != 0) {
    if (friction.angular_rate == 0) {
      Stepper<V, double, false>(acceleration, friction, linear, angular).run(span, heading, state);
    } else {
      braked_step(acceleration, friction, span, linear, angular, heading, state);
    }
    return;
  }
  const Motion<V> motion = {state.v,
                            state.omega,
                            linear - state.v * friction.linear_rate,
                            angular - state.omega * friction.angular_rate,
                            friction.linear_rate,
                            friction.angular_rate};
  if (friction.angular_rate == 0) return unbraked_step(motion, span, heading, state);
  move(Travel<V>::by_quadrature(motion, V(span), span), heading, state);
  state.v = state.v + motion.acceleration * exact::decay<double, double, V>(motion.rate, span).phi;
  state.omega = state.omega + motion.turn_acceleration *
                                  exact::decay<double, double, V>(motion.turn_rate, span).phi;
}

// One vector, of a robot a lane: with viscous friction or scrub in all of its lanes, or in none.
template <class V>
NFOPIDN_INLINE void exact_step(const Acceleration<V>& acceleration,
                               const FrictionCoefficients<V>& friction, double span,
                               const V& linear, const V& angular, const Heading<V>& heading,
                               State<V>& state) {
  using M = math<V>;
  if (M::any(friction.scrub > 0.0)) {
    scrubbed_step(acceleration, friction, span, linear, angular, heading, state);
  } else if (M::any(friction.angular_rate > 0.0)) {
    braked_step(acceleration, friction, span, linear, angular, heading, state);
  } else if (M::any(friction.coulomb > 0.0)) {
    Stepper<V, V, false>(acceleration, friction, linear, angular).run(span, heading, state);
  } else {
    unbraked_step(Motion<V>{state.v, state.omega, linear, angular, 0, 0}, span, heading, state);
  }
}

}  // namespace lanes

template <int width, int count>
struct ExactMotion<Lanes<width, count>> {
  using Scalar = Lanes<width, count>;
  using V = Lanes<width, 1>;

  template <class Number>
  NFOPIDN_NOINLINE static void advance(const Acceleration<Number>& acceleration,
                                       const FrictionCoefficients<Number>& friction, double span,
                                       int substeps, const Scalar& linear, const Scalar& angular,
                                       const Heading<Scalar>& heading, State<Scalar>& state) {
    for (int i = 0; i < count; ++i) {
      const auto& own_acceleration = of_vector(acceleration, i);
      const auto& own_friction = of_vector(friction, i);
      State<V> own = {part(state.x, i), part(state.y, i), part(state.theta, i), part(state.v, i),
                      part(state.omega, i)};
      Heading<V> facing = {part(heading.cosine, i), part(heading.sine, i)};
      const V forward = part(linear, i), turning = part(angular, i);
      for (int k = 0; k < substeps; ++k) {
        if (k > 0) facing = math<V>::heading(own.theta);
        lanes::exact_step(own_acceleration, own_friction, span, forward, turning, facing, own);
      }
      state.x.part[i] = own.x.part[0];
      state.y.part[i] = own.y.part[0];
      state.theta.part[i] = own.theta.part[0];
      state.v.part[i] = own.v.part[0];
      state.omega.part[i] = own.omega.part[0];
    }
  }

 private:
  NFOPIDN_INLINE static V part(const Scalar& all, int i) {
    V one;
    one.part[0] = all.part[i];
    return one;
  }

  // The coefficients of one vector: of one robot they are those of all.
  template <template <class> class Coefficients>
  NFOPIDN_INLINE static const Coefficients<double>& of_vector(const Coefficients<double>& all,
                                                              int /*i*/) {
    return all;
  }
  template <template <class> class Coefficients>
  NFOPIDN_INLINE static Coefficients<V> of_vector(const Coefficients<Scalar>& all, int i) {
    return {all, [i](const Scalar& number) { return part(number, i); }};
  }
};

}  // namespace nfopidn
