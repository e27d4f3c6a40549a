// L2. The limit of the wheel torques, and when it need not be looked at.
#pragma once

#include "nfopidn/control/controller_settings.hpp"
#include "nfopidn/control/reference.hpp"
#include "nfopidn/foundation/traits.hpp"

namespace nfopidn {

// Both torques clipped to [-limit, limit].
template <class Scalar>
NFOPIDN_INLINE constexpr TorquePair<Scalar> limited(const TorquePair<Scalar>& torque,
                                                    base_t<Scalar> limit) {
  using M = math<Scalar>;
  if constexpr (traits::is_same<Scalar, float>) {
    return {single::limited(torque.left, limit), single::limited(torque.right, limit)};
  } else {
    if (M::within(torque.left, torque.right, limit)) return torque;
    const Scalar high = Scalar(limit);
    const Scalar low = Scalar(-limit);
    return {M::maximum(M::minimum(torque.left, high), low),
            M::maximum(M::minimum(torque.right, high), low)};
  }
}

namespace detail {

// The feedforward torque that no feedback can take beyond the torque limit. Many lanes share one
// reference, so that one comparison replaces one for each lane. A single number has nothing to
// save.
template <class Scalar, class = void>
struct FeedforwardHeadroom {
  using Base = base_t<Scalar>;
  Base headroom = Base(-1);  // negative: there is none

  template <class Structure>
  constexpr void configure_headroom(const Structure& structure, Base limit) {
    headroom = Base(-1);
    if (structure.form != Form::positional || structure.activation != Activation::sigmoid) return;
    constexpr Base most = Base(1.000001);  // an output of a neuron, whatever the rounding
    Base reach = Base(0);
    for (const auto& row : structure.allocation.matrix) {
      Base sum = Base(0);
      for (const Base share : row) sum += share < Base(0) ? -share : share;
      if (sum > reach) reach = sum;
    }
    headroom = limit - most * reach;
  }
  NFOPIDN_INLINE constexpr bool has_headroom_for(Base feedforward) const {
    return feedforward <= headroom && feedforward >= -headroom;
  }
};
template <class Scalar>
struct FeedforwardHeadroom<Scalar, traits::enable_if_t<traits::is_floating_point<Scalar>>> {
  template <class Structure>
  constexpr void configure_headroom(const Structure& /*structure*/, Scalar /*limit*/) {}
  static constexpr bool has_headroom_for(Scalar /*feedforward*/) { return false; }
};

}  // namespace detail

}  // namespace nfopidn
