// The exact motion of lanes: what plant/exact_motion.hpp finds by branching, vector by vector.
//
// Coulomb friction makes events, at which a lane's wheel stops. Nearly all steps have none in any
// lane of a vector; where some have, the vector goes on in pieces until the last lane's step is
// over, and lanes that are through keep what they have.
#pragma once

#include "lanes_path.hpp"
#include "nfopidn/plant/exact_motion.hpp"

namespace nfopidn {

namespace lanes {

// The state after a displacement.
template <class V>
NFOPIDN_INLINE void move(const Displacement<V>& way, const Heading<V>& heading, State<V>& state) {
  state.x = state.x + (way.along * heading.cosine - way.across * heading.sine);
  state.y = state.y + (way.along * heading.sine + way.across * heading.cosine);
  state.theta = state.theta + way.turned;
}

// A step with Coulomb friction, in pieces between the events at which a lane's wheel stops.
// Without viscous friction a wheel that sticks breaks loose only where a piece begins.
template <class V>
class Stepper {
 public:
  using M = math<V>;
  using Mask = typename V::Mask;

  NFOPIDN_INLINE Stepper(const Acceleration<double>& acceleration,
                         const FrictionCoefficients<double>& friction, const V& linear,
                         const V& angular)
      : acceleration_(acceleration),
        friction_(friction),
        linear_(linear),
        angular_(angular),
        smooth_(wheels(linear, angular)) {}

  NFOPIDN_INLINE void run(double span, Heading<V> heading, State<V>& state) {
    V rest(span);
    for (int piece = 1; piece <= exact::max_pieces; ++piece) {
      const State<V> before = state;
      const V time = slide(rest, piece < exact::max_pieces, heading, state);
      if (piece > 1) keep_finished(rest, before, state);
      rest = rest - time;
      if (__builtin_expect(!M::any(rest > 0.0), 1)) return;
      heading = M::heading(state.theta);
    }
  }

 private:
  NFOPIDN_INLINE TorquePair<V> wheels(const V& v, const V& omega) const {
    return wheel_speeds_of(v, omega * friction_.half_track, 1 / friction_.wheel_radius);
  }
  NFOPIDN_INLINE static TorquePair<V> wheel_speeds_of(const V& v, const V& turn, double scale) {
    return {(v + turn) * scale, (v - turn) * scale};
  }
  NFOPIDN_INLINE V speed_of(const TorquePair<V>& wheel) const {
    return (wheel.left + wheel.right) * (friction_.wheel_radius * 0.5);
  }
  NFOPIDN_INLINE V turning_of(const TorquePair<V>& wheel) const {
    return (wheel.left - wheel.right) * (friction_.wheel_radius * 0.5 / friction_.half_track);
  }

  // Up to the next event of each lane. Returns the time it took.
  NFOPIDN_INLINE V slide(const V& rest, bool watch, const Heading<V>& heading, State<V>& state) {
    const double c = friction_.coulomb;
    TorquePair<V> wheel = wheels(state.v, state.omega);
    TorquePair<V> push = {M::select(wheel.left < 0.0, V(c), V(-c)),
                          M::select(wheel.right < 0.0, V(c), V(-c))};
    Motion<V> motion = {state.v,
                        state.omega,
                        linear_ + (push.left + push.right) * acceleration_.drive,
                        angular_ + (push.left - push.right) * acceleration_.steer,
                        0,
                        0};
    TorquePair<V> gain = gains(push);
    const Mask still_left = M::within_each(wheel.left, exact::rounding<double>);
    const Mask still_right = M::within_each(wheel.right, exact::rounding<double>);
    if (__builtin_expect(M::any(still_left | still_right), 0)) {
      TorquePair<V> own_wheel = wheel, own_push = push, own_gain = gain;
      Motion<V> own_motion = motion;
      stick(still_left, still_right, own_wheel, own_push, own_gain, own_motion);
      wheel = own_wheel;
      push = own_push;
      gain = own_gain;
      motion = own_motion;
    }
    V time = rest;
    const Mask stops_left = (wheel.left + gain.left * rest) * push.left > 0.0;
    const Mask stops_right = (wheel.right + gain.right * rest) * push.right > 0.0;
    const bool event = watch && M::any(stops_left | stops_right);
    V left_time, right_time;
    if (__builtin_expect(event, 0)) {
      left_time = stop_time(stops_left, wheel.left, gain.left, rest);
      right_time = stop_time(stops_right, wheel.right, gain.right, rest);
      time = M::minimum(left_time, right_time);
    }
    move(Travel<V>::unbraked(motion, time), heading, state);
    state.v = motion.v + motion.acceleration * time;
    state.omega = motion.omega + motion.turn_acceleration * time;
    if (__builtin_expect(event, 0)) {
      set_stopped(stops_left & (left_time <= right_time), stops_right & (right_time < left_time),
                  state);
    }
    return time;
  }

  // The wheels' accelerations.
  NFOPIDN_INLINE TorquePair<V> gains(const TorquePair<V>& push) const {
    const double a = friction_.own;
    const double b = friction_.other;
    return {smooth_.left + (push.left * a + push.right * b),
            smooth_.right + (push.right * a + push.left * b)};
  }

  // Settles the friction of wheels that stand, and holds those that stick.
  NFOPIDN_NOINLINE void stick(const Mask& still_left, const Mask& still_right, TorquePair<V>& wheel,
                              TorquePair<V>& push, TorquePair<V>& gain, Motion<V>& motion) const {
    const double c = friction_.coulomb;
    const double a = friction_.own;
    const double b = friction_.other;
    const auto clip = [c](const V& value) { return M::maximum(M::minimum(value, V(c)), V(-c)); };
    const TorquePair<V> both = opposing_friction(friction_, smooth_, c);
    const TorquePair<V> one = {clip((smooth_.left + push.right * b) * (-1 / a)),
                               clip((smooth_.right + push.left * b) * (-1 / a))};
    const Mask still = still_left & still_right;
    push.left = M::select(still_left, M::select(still, both.left, one.left), push.left);
    push.right = M::select(still_right, M::select(still, both.right, one.right), push.right);
    const double most = c * (1 - exact::rounding<double>);
    const V zero(0.0);
    const Mask stuck_left = still_left & (Travel<V>::magnitude(push.left) < most);
    const Mask stuck_right = still_right & (Travel<V>::magnitude(push.right) < most);
    gain = gains(push);
    motion.acceleration = linear_ + (push.left + push.right) * acceleration_.drive;
    motion.turn_acceleration = angular_ + (push.left - push.right) * acceleration_.steer;
    wheel = {M::select(stuck_left, zero, wheel.left), M::select(stuck_right, zero, wheel.right)};
    gain = {M::select(stuck_left, zero, gain.left), M::select(stuck_right, zero, gain.right)};
    const Mask stuck = stuck_left | stuck_right;
    motion.v = M::select(stuck, speed_of(wheel), motion.v);
    motion.omega = M::select(stuck, turning_of(wheel), motion.omega);
    motion.acceleration = M::select(stuck, speed_of(gain), motion.acceleration);
    motion.turn_acceleration = M::select(stuck, turning_of(gain), motion.turn_acceleration);
  }

  NFOPIDN_INLINE static V stop_time(const Mask& stops, const V& speed, const V& gain,
                                    const V& rest) {
    const V time = M::minimum(M::maximum(speed * -1.0 / gain, V(0.0)), rest);
    return M::select(stops, time, rest);
  }

  NFOPIDN_INLINE void set_stopped(const Mask& left, const Mask& right, State<V>& state) const {
    TorquePair<V> wheel = wheels(state.v, state.omega);
    const V zero(0.0);
    wheel = {M::select(left, zero, wheel.left), M::select(right, zero, wheel.right)};
    const Mask any = left | right;
    state.v = M::select(any, speed_of(wheel), state.v);
    state.omega = M::select(any, turning_of(wheel), state.omega);
  }

  // A lane whose time is over waits for the others.
  NFOPIDN_INLINE static void keep_finished(const V& rest, const State<V>& before, State<V>& state) {
    const Mask active = rest > 0.0;
    state.x = M::select(active, state.x, before.x);
    state.y = M::select(active, state.y, before.y);
    state.theta = M::select(active, state.theta, before.theta);
    state.v = M::select(active, state.v, before.v);
    state.omega = M::select(active, state.omega, before.omega);
  }

  const Acceleration<double>& acceleration_;
  const FrictionCoefficients<double>& friction_;
  const V& linear_;
  const V& angular_;
  TorquePair<V> smooth_;  // accelerations of the wheels without Coulomb friction
};

// One vector, without friction.
template <class V>
NFOPIDN_INLINE void unbraked_step(const Motion<V>& motion, double span, const Heading<V>& heading,
                                  State<V>& state) {
  move(Travel<V>::unbraked(motion, V(span)), heading, state);
  state.v = state.v + motion.acceleration * span;
  state.omega = state.omega + motion.turn_acceleration * span;
}

// One vector.
template <class V>
NFOPIDN_INLINE void exact_step(const Acceleration<double>& acceleration,
                               const FrictionCoefficients<double>& friction, double span,
                               const V& linear, const V& angular, const Heading<V>& heading,
                               State<V>& state) {
  if (friction.coulomb != 0) {
    Stepper<V>(acceleration, friction, linear, angular).run(span, heading, state);
    return;
  }
  const Motion<V> motion = {state.v,
                            state.omega,
                            linear - state.v * friction.linear_rate,
                            angular - state.omega * friction.angular_rate,
                            friction.linear_rate,
                            friction.angular_rate};
  if (friction.viscous == 0) return unbraked_step(motion, span, heading, state);
  move(Travel<V>::by_quadrature(motion, V(span), span), heading, state);
  state.v = state.v + motion.acceleration * exact::decay<double, double, V>(motion.rate, span).phi;
  state.omega = state.omega + motion.turn_acceleration *
                                  exact::decay<double, double, V>(motion.turn_rate, span).phi;
}

}  // namespace lanes

template <int width, int count>
struct ExactMotion<Lanes<width, count>> {
  using Scalar = Lanes<width, count>;
  using V = Lanes<width, 1>;

  // Viscous and Coulomb friction at once are not for lanes.
  NFOPIDN_NOINLINE static void advance(const Acceleration<double>& acceleration,
                                       const FrictionCoefficients<double>& friction, double span,
                                       int substeps, const Scalar& linear, const Scalar& angular,
                                       const Heading<Scalar>& heading, State<Scalar>& state) {
    const auto step = [&](const V& forward, const V& turning, const Heading<V>& facing,
                          State<V>& own) {
      lanes::exact_step(acceleration, friction, span, forward, turning, facing, own);
    };
    each_vector(substeps, linear, angular, heading, state, step);
  }

  // Without friction: of lanes that are a robot each.
  NFOPIDN_NOINLINE static void glide(double span, int substeps, const Scalar& linear,
                                     const Scalar& angular, const Heading<Scalar>& heading,
                                     State<Scalar>& state) {
    const auto step = [&](const V& forward, const V& turning, const Heading<V>& facing,
                          State<V>& own) {
      const lanes::Motion<V> motion = {own.v, own.omega, forward, turning, 0, 0};
      lanes::unbraked_step(motion, span, facing, own);
    };
    each_vector(substeps, linear, angular, heading, state, step);
  }

 private:
  template <class Step>
  NFOPIDN_INLINE static void each_vector(int substeps, const Scalar& linear, const Scalar& angular,
                                         const Heading<Scalar>& heading, State<Scalar>& state,
                                         const Step& step) {
    for (int i = 0; i < count; ++i) {
      State<V> own = {part(state.x, i), part(state.y, i), part(state.theta, i), part(state.v, i),
                      part(state.omega, i)};
      Heading<V> facing = {part(heading.cosine, i), part(heading.sine, i)};
      const V forward = part(linear, i), turning = part(angular, i);
      for (int k = 0; k < substeps; ++k) {
        if (k > 0) facing = math<V>::heading(own.theta);
        step(forward, turning, facing, own);
      }
      state.x.part[i] = own.x.part[0];
      state.y.part[i] = own.y.part[0];
      state.theta.part[i] = own.theta.part[0];
      state.v.part[i] = own.v.part[0];
      state.omega.part[i] = own.omega.part[0];
    }
  }

  NFOPIDN_INLINE static V part(const Scalar& all, int i) {
    V one;
    one.part[0] = all.part[i];
    return one;
  }
};

}  // namespace nfopidn
