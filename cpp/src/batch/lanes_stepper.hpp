// The exact motion of lanes under Coulomb friction: pieces between events.
//
// At an event a lane's wheel stops, or with scrub its turn. Nearly all steps have none in any lane
// of a vector; where some have, the vector goes on in pieces until the last lane's step is over,
// and lanes that are through keep what they have.
#pragma once

#include <type_traits>

#include "lanes_crossing.hpp"
#include "lanes_scrub.hpp"

namespace nfopidn {

namespace lanes {

// The state after a displacement.
template <class V>
NFOPIDN_INLINE void move(const Displacement<V>& way, const Heading<V>& heading, State<V>& state) {
  state.x = state.x + (way.along * heading.cosine - way.across * heading.sine);
  state.y = state.y + (way.along * heading.sine + way.across * heading.cosine);
  state.theta = state.theta + way.turned;
}

// Robot and friction are those of all lanes, or of each its own. `braked`: with viscous friction,
// under which speeds relax, and a wheel that sticks may break loose at any time. Without it that
// happens only where a piece begins. `scrubs`: with Coulomb scrub in some of the lanes; then
// braked.
template <class V, class Number, bool braked, bool scrubs = false>
class Stepper {
 public:
  using M = math<V>;
  using Mask = typename V::Mask;
  using Rate = std::conditional_t<braked, V, double>;

  NFOPIDN_INLINE Stepper(const Acceleration<Number>& acceleration,
                         const FrictionCoefficients<Number>& friction, const V& linear,
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
      const bool watch = piece < exact::max_pieces;
      V time;
      if constexpr (braked) {
        time = relax(rest, watch, span, heading, state);
      } else {
        time = slide(rest, watch, heading, state);
      }
      if (piece > 1) keep_finished(rest, before, state);
      rest = rest - time;
      if (__builtin_expect(!M::any(rest > 0.0), 1)) return;
      heading = M::heading(state.theta);
    }
  }

 private:
  struct Sides {
    Mask left, right;
  };

  // How lanes move until their next events: with both wheels, their friction and accelerations.
  struct Piece {
    exact::ExponentialMotion<V, Rate> motion;
    TorquePair<V> wheel, push, gain;
  };

  NFOPIDN_INLINE TorquePair<V> wheels(const V& v, const V& omega) const {
    return wheel_speeds_of(v, omega * friction_.half_track, 1.0 / friction_.wheel_radius);
  }
  NFOPIDN_INLINE static TorquePair<V> wheel_speeds_of(const V& v, const V& turn,
                                                      const Number& scale) {
    return {(v + turn) * scale, (v - turn) * scale};
  }
  NFOPIDN_INLINE V speed_of(const TorquePair<V>& wheel) const {
    return (wheel.left + wheel.right) * (friction_.wheel_radius * 0.5);
  }
  NFOPIDN_INLINE V turning_of(const TorquePair<V>& wheel) const {
    return (wheel.left - wheel.right) * (friction_.wheel_radius * 0.5 / friction_.half_track);
  }

  // Both wheels slide under the accelerations without Coulomb friction.
  NFOPIDN_INLINE Piece begin(const State<V>& state, const V& linear, const V& angular,
                             const Rate& rate, const Rate& turn_rate) const {
    const V with(friction_.coulomb), against(friction_.coulomb * -1.0);
    const TorquePair<V> wheel = wheels(state.v, state.omega);
    const TorquePair<V> push = {M::select(wheel.left < 0.0, with, against),
                                M::select(wheel.right < 0.0, with, against)};
    return {{state.v, state.omega, linear + (push.left + push.right) * acceleration_.drive,
             angular + (push.left - push.right) * acceleration_.steer, rate, turn_rate},
            wheel,
            push,
            gains(push)};
  }

  NFOPIDN_INLINE static Sides still_sides(const TorquePair<V>& wheel) {
    return {M::within_each(wheel.left, exact::rounding<double>),
            M::within_each(wheel.right, exact::rounding<double>)};
  }

  // Up to the next event of each lane, without viscous friction. Returns the time it took.
  NFOPIDN_INLINE V slide(const V& rest, bool watch, const Heading<V>& heading, State<V>& state) {
    Piece piece = begin(state, linear_, angular_, 0, 0);
    const Sides still = still_sides(piece.wheel);
    if (__builtin_expect(M::any(still.left | still.right), 0)) {
      Piece own = piece;  // copies: what a call is given lies in memory, and the rest need not
      stick(still, linear_, angular_, own);
      piece = own;
    }
    const auto& [motion, wheel, push, gain] = piece;
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

  // The same with it.
  NFOPIDN_INLINE V relax(const V& rest, bool watch, double span, const Heading<V>& heading,
                         State<V>& state) {
    const V linear = linear_ - state.v * friction_.linear_rate;
    std::conditional_t<scrubs, Scrub<V>, NoScrub<V>> scrub(friction_, angular_, state.omega);
    const V angular = scrub.angular - state.omega * friction_.angular_rate;
    smooth_ = wheels(linear, angular);
    Piece piece =
        begin(state, linear, angular, V(friction_.linear_rate), V(friction_.angular_rate));
    const Sides still = still_sides(piece.wheel);
    const Mask none = still.left & ~still.left;
    Sides stuck = {none, none}, stops = {none, none};
    if (M::any(still.left | still.right)) {
      stuck = stick(still, linear, angular, piece);
      if constexpr (scrubs) {  // going straight both are alike, but for rounding errors
        stuck.right = (stuck.right & ~scrub.straight) | (stuck.left & scrub.straight);
      }
      pivot(stuck, piece.motion);
    }
    scrub.keep_straight(piece.motion);
    const auto& motion = piece.motion;
    V time = rest, left_time = rest, right_time = rest;
    if (watch) {
      const Mask acts = (rest > 0.0) & (V(friction_.coulomb) > 0.0);
      const Crossing<V> crossing(motion.rate, motion.turn_rate, span);
      left_time = crossing.find(
          margin(piece, stuck.left, 1, piece.wheel.left, piece.push.left, piece.gain.right), rest,
          acts, stops.left);
      right_time = crossing.find(
          margin(piece, stuck.right, -1, piece.wheel.right, piece.push.right, piece.gain.left),
          rest, acts, stops.right);
      time = M::minimum(left_time, right_time);
      if constexpr (scrubs) {
        scrub.find_end(crossing, friction_, motion, rest);
        stops.left = stops.left & (left_time <= scrub.end);
        stops.right = stops.right & (right_time <= scrub.end);
        time = M::minimum(time, scrub.end);
      }
    }
    move(Travel<V>::by_quadrature(motion, time, span), heading, state);
    state.v = motion.v + motion.acceleration * Relaxation<V, V>(motion.rate, span)(time).phi;
    state.omega = motion.omega +
                  motion.turn_acceleration * Relaxation<V, V>(motion.turn_rate, span)(time).phi;
    if (M::any(stops.left | stops.right)) {
      set_stopped((stops.left & ~stuck.left) & (left_time <= right_time),
                  (stops.right & ~stuck.right) & (right_time < left_time), state);
    }
    scrub.stop(time, state.omega);
    return time;
  }

  // How far a wheel is from its event: one that slides from standing still, one that sticks, while
  // the other one moves, from what friction can hold.
  NFOPIDN_INLINE Margin<V> margin(const Piece& piece, const Mask& stuck, double side,
                                  const V& wheel, const V& push, const V& other_gain) const {
    const V sign = M::select(push > 0.0, V(-1.0), V(1.0));
    const V way = sign * (1.0 / friction_.wheel_radius);
    const Number turn = friction_.half_track * side;
    const V held = other_gain * (friction_.pivot_coupling() / friction_.own);
    const V bar = M::select(held < 0.0, V(friction_.coulomb) + push, V(friction_.coulomb) - push);
    return {M::select(stuck, bar, wheel * sign),
            M::select(stuck, Travel<V>::magnitude(held) * -1.0, piece.motion.acceleration * way),
            M::select(stuck, V(0.0), (piece.motion.turn_acceleration * way) * turn)};
  }

  // Lanes with a wheel that sticks turn about it, and their speeds relax at one rate.
  NFOPIDN_INLINE void pivot(const Sides& stuck, exact::ExponentialMotion<V, Rate>& motion) const {
    const V rate(friction_.pivot_rate());
    motion.rate = M::select(stuck.left | stuck.right, rate, motion.rate);
    motion.turn_rate = M::select(stuck.left | stuck.right, rate, motion.turn_rate);
  }

  // The wheels' accelerations.
  NFOPIDN_INLINE TorquePair<V> gains(const TorquePair<V>& push) const {
    const Number& a = friction_.own;
    const Number& b = friction_.other;
    return {smooth_.left + (push.left * a + push.right * b),
            smooth_.right + (push.right * a + push.left * b)};
  }

  // Settles the friction of wheels that stand, and holds those that stick, which it returns.
  NFOPIDN_NOINLINE Sides stick(const Sides& still, const V& linear, const V& angular,
                               Piece& piece) const {
    auto& [motion, wheel, push, gain] = piece;
    const Number& c = friction_.coulomb;
    const Number& a = friction_.own;
    const Number& b = friction_.other;
    const V high(c), low(c * -1.0);
    const auto clip = [&](const V& value) { return M::maximum(M::minimum(value, high), low); };
    const TorquePair<V> both = opposing_friction(friction_, smooth_, c);
    const TorquePair<V> one = {clip((smooth_.left + push.right * b) * (-1.0 / a)),
                               clip((smooth_.right + push.left * b) * (-1.0 / a))};
    const Mask all_still = still.left & still.right;
    push.left = M::select(still.left, M::select(all_still, both.left, one.left), push.left);
    push.right = M::select(still.right, M::select(all_still, both.right, one.right), push.right);
    const Number most = c * (1 - exact::rounding<double>);
    const V zero(0.0);
    const Sides stuck = {still.left & (Travel<V>::magnitude(push.left) < most),
                         still.right & (Travel<V>::magnitude(push.right) < most)};
    gain = gains(push);
    motion.acceleration = linear + (push.left + push.right) * acceleration_.drive;
    motion.turn_acceleration = angular + (push.left - push.right) * acceleration_.steer;
    wheel = {M::select(stuck.left, zero, wheel.left), M::select(stuck.right, zero, wheel.right)};
    gain = {M::select(stuck.left, zero, gain.left), M::select(stuck.right, zero, gain.right)};
    const Mask any = stuck.left | stuck.right;
    motion.v = M::select(any, speed_of(wheel), motion.v);
    motion.omega = M::select(any, turning_of(wheel), motion.omega);
    motion.acceleration = M::select(any, speed_of(gain), motion.acceleration);
    motion.turn_acceleration = M::select(any, turning_of(gain), motion.turn_acceleration);
    return stuck;
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

  const Acceleration<Number>& acceleration_;
  const FrictionCoefficients<Number>& friction_;
  const V& linear_;
  const V& angular_;
  TorquePair<V> smooth_;  // accelerations of the wheels without Coulomb friction
};

// With viscous friction: so much more work that a call costs little beside it.
template <class V, class Number>
NFOPIDN_NOINLINE void braked_step(const Acceleration<Number>& acceleration,
                                  const FrictionCoefficients<Number>& friction, double span,
                                  const V& linear, const V& angular, const Heading<V>& heading,
                                  State<V>& state) {
  Stepper<V, Number, true>(acceleration, friction, linear, angular).run(span, heading, state);
}

// With Coulomb scrub in some lanes.
template <class V, class Number>
NFOPIDN_NOINLINE void scrubbed_step(const Acceleration<Number>& acceleration,
                                    const FrictionCoefficients<Number>& friction, double span,
                                    const V& linear, const V& angular, const Heading<V>& heading,
                                    State<V>& state) {
  Stepper<V, Number, true, true>(acceleration, friction, linear, angular).run(span, heading, state);
}

}  // namespace lanes

}  // namespace nfopidn
