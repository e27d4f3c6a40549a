// Coulomb scrub of lanes in a piece: what plant/exact_motion.hpp does for a single number.
#pragma once

#include "lanes_crossing.hpp"
#include "nfopidn/plant/friction.hpp"

namespace nfopidn {

namespace lanes {

// `angular` is the turning acceleration without friction of the wheels.
template <class V>
struct NoScrub {
  const V& angular;

  template <class Number>
  NFOPIDN_INLINE NoScrub(const FrictionCoefficients<Number>& /*friction*/, const V& outer,
                         const V& /*omega*/)
      : angular(outer) {}
  template <class Motion>
  NFOPIDN_INLINE void keep_straight(Motion& /*motion*/) const {}
  NFOPIDN_INLINE void stop(const V& /*time*/, V& /*omega*/) const {}
};

template <class V>
struct Scrub {
  using M = math<V>;
  using Mask = typename V::Mask;

  V angular;
  V way;          // in which lanes turn, or begin to: +-1
  Mask straight;  // lanes that scrub holds on their heading until their wheels stop
  Mask acts;      // the other lanes that have scrub
  V end;          // when a lane stops turning, if it is among those that do
  Mask ends;

  // `outer` is the turning acceleration of torque and disturbance. Sets omega of lanes that go
  // straight to zero.
  template <class Number>
  NFOPIDN_INLINE Scrub(const FrictionCoefficients<Number>& friction, const V& outer, V& omega) {
    const V limit(friction.scrub);
    const V turn = at_wheels(friction, omega);
    const Mask still = M::within_each(turn, exact::rounding<double>);
    way = M::select(M::select(still, outer, turn) < 0.0, V(-1.0), V(1.0));
    angular = M::select(still, scrubbed(outer, friction.scrub), outer - limit * way);
    straight = still & (Travel<V>::magnitude(outer) < limit * (1 - exact::rounding<double>));
    acts = (limit > 0.0) & ~straight;
    end = V(0.0);
    ends = straight & ~straight;
    omega = M::select(straight, V(0.0), omega);
  }

  template <class Motion>
  NFOPIDN_INLINE void keep_straight(Motion& motion) const {
    motion.omega = M::select(straight, V(0.0), motion.omega);
    motion.turn_acceleration = M::select(straight, V(0.0), motion.turn_acceleration);
  }

  template <class Number, class Motion>
  NFOPIDN_INLINE void find_end(const Crossing<V>& crossing,
                               const FrictionCoefficients<Number>& friction, const Motion& motion,
                               const V& rest) {
    const Margin<V> margin = {at_wheels(friction, motion.omega) * way, V(0.0),
                              at_wheels(friction, motion.turn_acceleration) * way};
    end = crossing.find(margin, rest, acts & (rest > 0.0), ends);
  }

  // At the end of the piece.
  NFOPIDN_INLINE void stop(const V& time, V& omega) const {
    omega = M::select(straight | (ends & (end <= time)), V(0.0), omega);
  }

 private:
  // What a turning rate adds to the wheels' speeds.
  template <class Number>
  NFOPIDN_INLINE static V at_wheels(const FrictionCoefficients<Number>& friction, const V& omega) {
    return omega * (friction.half_track / friction.wheel_radius);
  }
};

}  // namespace lanes

}  // namespace nfopidn
