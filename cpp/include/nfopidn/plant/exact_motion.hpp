// L1. The robot's motion under constant torques, with the pose integrated to 1e-10.
//
// Between samples v and omega obey dv/dt = a - k v with constant a: linear in time, exponential
// with viscous friction; Coulomb friction changes the constants each time a wheel stops, sticks or
// breaks loose, and scrub each time the robot stops turning, or goes straight until its moment
// exceeds it. Each piece between two such events is an exponential motion. All loops are bounded:
// a step with more than max_pieces events goes through the last piece without looking for more.
#pragma once

#include "nfopidn/plant/crossing.hpp"
#include "nfopidn/plant/exponential_motion.hpp"
#include "nfopidn/plant/friction.hpp"

namespace nfopidn {

namespace exact {

constexpr int max_pieces = 16;

// A step with Coulomb friction or scrub: pieces between the events at which a wheel or the turning
// stops or breaks loose.
template <class Scalar, class Base>
class Stepper {
 public:
  using M = math<Scalar>;
  static constexpr int turning = 2;  // the index of what has to come to rest besides both wheels

  constexpr Stepper(const Acceleration<Base>& acceleration,
                    const FrictionCoefficients<Base>& friction, const Scalar& linear,
                    const Scalar& angular, State<Scalar>& state)
      : acceleration_(acceleration),
        friction_(friction),
        linear_(linear),
        outer_(angular),
        angular_(angular),
        state_(state) {}

  constexpr void run(Base span) {
    Scalar rest = Scalar(span);
    for (int piece = 0; piece < max_pieces && M::value(rest) > Base(0); ++piece) {
      const bool is_straight = friction_.scrub != Base(0) && choose_scrub();
      choose_friction();
      if (is_straight) {  // the wheels are alike, but for rounding errors
        push_[1] = push_[0];
        stuck_[1] = stuck_[0];
      }
      if (stuck_[0] && stuck_[1]) {
        state_.v = Scalar(Base(0));
        state_.omega = Scalar(Base(0));
        return;
      }
      const bool watch = piece + 1 < max_pieces;
      rest = rest - (stuck_[0] || stuck_[1] ? pivot(rest, watch) : slide(rest, watch));
      if (is_straight) state_.omega = Scalar(Base(0));
    }
  }

 private:
  template <class T>
  constexpr T wheel(int side, const T& v, const T& omega) const {
    if (side == turning) return omega * (friction_.half_track / friction_.wheel_radius);
    const T turn = omega * (side == 0 ? friction_.half_track : -friction_.half_track);
    return (v + turn) * (Base(1) / friction_.wheel_radius);
  }

  // Settles which way the robot turns, and the acceleration with scrub. Whether scrub holds it
  // straight: until the wheels stop, for they are the same then, and nothing else turns it.
  constexpr bool choose_scrub() {
    const Base q = friction_.scrub;
    const Base speed = M::value(wheel(turning, state_.v, state_.omega));
    if (speed > rounding<Base> || speed < -rounding<Base>) {
      sign_[turning] = speed < 0 ? Base(-1) : Base(1);
      angular_ = outer_ - Scalar(q * sign_[turning]);
      return false;
    }
    const Base pull = M::value(outer_);
    sign_[turning] = pull < 0 ? Base(-1) : Base(1);
    angular_ = scrubbed(outer_, q);
    // A hair below the limit counts as loose, as for the wheels.
    if (!((pull < 0 ? -pull : pull) < q * (Base(1) - rounding<Base>))) return false;
    state_.omega = Scalar(Base(0));
    sign_[turning] = Base(0);
    return true;
  }

  constexpr void set_wheels(const Scalar& left, const Scalar& right) {
    state_.v = (left + right) * (friction_.wheel_radius * Base(0.5));
    state_.omega = (left - right) * (friction_.wheel_radius * Base(0.5) / friction_.half_track);
  }

  // Settles, for both wheels, which way each slides or whether it sticks, and its friction.
  constexpr void choose_friction() {
    const Base c = friction_.coulomb;
    const Scalar linear = linear_ - state_.v * friction_.linear_rate;
    const Scalar angular = angular_ - state_.omega * friction_.angular_rate;
    const Scalar smooth[2] = {wheel(0, linear, angular), wheel(1, linear, angular)};
    bool still[2] = {};
    for (int side = 0; side < 2; ++side) {
      const Base speed = M::value(wheel(side, state_.v, state_.omega));
      still[side] = (speed < 0 ? -speed : speed) <= rounding<Base>;
      sign_[side] = speed < 0 ? Base(-1) : Base(1);
      stuck_[side] = false;
      push_[side] = Scalar(-c * sign_[side]);
    }
    if (still[0] && still[1]) {
      const TorquePair<Scalar> motion = {smooth[0], smooth[1]};
      const TorquePair<Scalar> both = opposing_friction(friction_, motion, c);
      push_[0] = both.left;
      push_[1] = both.right;
    } else {
      for (int side = 0; side < 2; ++side) {
        if (!still[side]) continue;
        const Scalar wanted =
            (smooth[side] + push_[1 - side] * friction_.other) * (Base(-1) / friction_.own);
        push_[side] = M::maximum(M::minimum(wanted, Scalar(c)), Scalar(-c));
      }
    }
    for (int side = 0; side < 2; ++side) {
      if (!still[side]) continue;
      const Base push = M::value(push_[side]);
      // A hair below the limit counts as loose: that is where a wheel has just broken away.
      stuck_[side] = (push < 0 ? -push : push) < c * (Base(1) - rounding<Base>);
      sign_[side] = push > 0 ? Base(-1) : Base(1);
    }
  }

  // Both wheels slide. Returns the time it took.
  constexpr Scalar slide(const Scalar& rest, bool watch) {
    const Scalar drive = (push_[0] + push_[1]) * acceleration_.drive;
    const Scalar steer = (push_[0] - push_[1]) * acceleration_.steer;
    const ExponentialMotion<Scalar, Base> motion = {
        state_.v,
        state_.omega,
        linear_ + drive - state_.v * friction_.linear_rate,
        angular_ + steer - state_.omega * friction_.angular_rate,
        friction_.linear_rate,
        friction_.angular_rate};
    const Base span = M::value(rest);
    Scalar time = rest;
    int stops = -1;
    for (int side = 0; watch && side < 3; ++side) {
      const Base limit = side == turning ? friction_.scrub : friction_.coulomb;
      if (limit == Base(0) || sign_[side] == Base(0)) continue;
      const auto speed = [&](auto t) {
        const auto speeds = as<decltype(t)>(motion);
        return wheel(side, speeds.speed(t), speeds.turning(t)) * sign_[side];
      };
      const auto slope = [&](auto t) {
        const auto gains = as<decltype(t)>(motion);
        return wheel(side, gains.acceleration * remaining(motion.rate, t),
                     gains.turn_acceleration * remaining(motion.turn_rate, t)) *
               sign_[side];
      };
      const Scalar crossing = first_crossing<Scalar>(speed, slope, span);
      if (M::value(crossing) < M::value(time)) {
        time = crossing;
        stops = side;
      }
    }
    travel(motion, time, state_);
    if (stops == 0) set_wheels(Scalar(Base(0)), wheel(1, state_.v, state_.omega));
    if (stops == 1) set_wheels(wheel(0, state_.v, state_.omega), Scalar(Base(0)));
    if (stops == turning) state_.omega = Scalar(Base(0));
    return time;
  }

  // One wheel sticks and the robot turns about it. Returns the time it took.
  constexpr Scalar pivot(const Scalar& rest, bool watch) {
    const int stuck = stuck_[0] ? 0 : 1;
    const int moving = 1 - stuck;
    const Base a = friction_.own;
    const Base b = friction_.other;
    const Base coupling = friction_.pivot_coupling();
    const Scalar held = wheel(stuck, linear_, angular_) + push_[moving] * b;
    const Scalar driven = wheel(moving, linear_, angular_) + push_[moving] * a;
    const Scalar start = wheel(moving, state_.v, state_.omega);
    const Base rate = friction_.pivot_rate();
    const Scalar gain = driven - held * (b / a) - start * rate;
    const auto moved = [&](auto t) {
      using T = decltype(t);
      return as<T>(start) + as<T>(gain) * decay<T, Base, Scalar>(rate, t).phi;
    };
    // The friction that holds the stuck wheel, and how it changes.
    const auto hold = [&](auto t) {
      return (moved(t) * coupling - as<decltype(t)>(held)) * (1 / a);
    };
    const auto hold_slope = [&](auto t) {
      return as<decltype(t)>(gain) * remaining(rate, t) * (coupling / a);
    };
    const Base c = friction_.coulomb;
    const Base span = M::value(rest);
    const Scalar stop = first_crossing<Scalar>(
        [&](auto t) { return moved(t) * sign_[moving]; },
        [&](auto t) { return as<decltype(t)>(gain) * remaining(rate, t) * sign_[moving]; }, span);
    const Scalar up =
        first_crossing<Scalar>([&](auto t) { return decltype(t)(c) - hold(t); },
                               [&](auto t) { return hold_slope(t) * Base(-1); }, span);
    const Scalar down =
        first_crossing<Scalar>([&](auto t) { return decltype(t)(c) + hold(t); }, hold_slope, span);
    Scalar time = rest;
    bool stops = false;
    if (watch && M::value(stop) < M::value(time)) {
      time = stop;
      stops = true;
    }
    const Scalar breaks = M::value(up) < M::value(down) ? up : down;
    if (watch && M::value(breaks) < M::value(time)) {
      time = breaks;
      stops = false;
    }
    const Base v_share = friction_.wheel_radius * Base(0.5);
    const Base omega_share = (moving == 0 ? Base(1) : Base(-1)) * v_share / friction_.half_track;
    travel(ExponentialMotion<Scalar, Base>{start * v_share, start * omega_share, gain * v_share,
                                           gain * omega_share, rate, rate},
           time, state_);
    if (stops) set_wheels(Scalar(Base(0)), Scalar(Base(0)));
    return time;
  }

  // e^{-rate t}
  template <class T>
  static constexpr T remaining(Base rate, const T& t) {
    return decay<T, Base, Scalar>(rate, t).left;
  }

  // A number or a motion, without its slopes where T has none.
  template <class T>
  static constexpr T as(const Scalar& number) {
    if constexpr (traits::is_same<T, Scalar>) {
      return number;
    } else {
      return M::value(number);
    }
  }
  template <class T>
  static constexpr ExponentialMotion<T, Base, Scalar> as(
      const ExponentialMotion<Scalar, Base>& motion) {
    return {as<T>(motion.v),
            as<T>(motion.omega),
            as<T>(motion.acceleration),
            as<T>(motion.turn_acceleration),
            motion.rate,
            motion.turn_rate};
  }

  const Acceleration<Base>& acceleration_;
  const FrictionCoefficients<Base>& friction_;
  const Scalar& linear_;
  const Scalar& outer_;  // of torque and disturbance, without scrub
  Scalar angular_;
  State<Scalar>& state_;
  Scalar push_[2] = {};  // friction at each wheel [N m]
  Base sign_[3] = {};    // the way each wheel slides and the robot turns
  bool stuck_[2] = {};
};

}  // namespace exact

// `linear` and `angular` are the accelerations of torque and disturbance, without friction.
template <class Scalar, class Base>
NFOPIDN_NOINLINE constexpr void exact_motion(const Acceleration<Base>& acceleration,
                                             const FrictionCoefficients<Base>& friction, Base span,
                                             const Scalar& linear, const Scalar& angular,
                                             State<Scalar>& state) {
  if (friction.coulomb != Base(0) || friction.scrub != Base(0)) {
    exact::Stepper<Scalar, Base>(acceleration, friction, linear, angular, state).run(span);
    return;
  }
  const exact::ExponentialMotion<Scalar, Base> motion = {
      state.v,
      state.omega,
      linear - state.v * friction.linear_rate,
      angular - state.omega * friction.angular_rate,
      friction.linear_rate,
      friction.angular_rate};
  exact::travel(motion, Scalar(span), state);
}

// Several such steps, `heading` being that of the first state. Lanes specialise it: what they
// decide differs from lane to lane.
template <class Scalar>
struct ExactMotion {
  template <class Base>
  static constexpr void advance(const Acceleration<Base>& acceleration,
                                const FrictionCoefficients<Base>& friction, Base span, int steps,
                                const Scalar& linear, const Scalar& angular,
                                const Heading<Scalar>& /*heading*/, State<Scalar>& state) {
    for (int i = 0; i < steps; ++i) {
      exact_motion(acceleration, friction, span, linear, angular, state);
    }
  }
};

}  // namespace nfopidn
