// L2. The robot's heading in the loop: its cosine and sine, and its angle to the reference.
#pragma once

#include "nfopidn/foundation/traits.hpp"
#include "nfopidn/loop/inputs.hpp"

namespace nfopidn {

namespace detail {

template <class Scalar, class = void>
constexpr bool remembers_quadrant = false;
template <class Scalar>
constexpr bool remembers_quadrant<Scalar, traits::void_t<typename math<Scalar>::Turn>> = true;
template <class Scalar, class = void>
constexpr bool has_heading_relative_to = false;
template <class Scalar>
constexpr bool
    has_heading_relative_to<Scalar, traits::void_t<decltype(&math<Scalar>::heading_relative_to)>> =
        true;

// Follows the robot's heading sample by sample: wraps the angle between the robot and its reference
// to [-pi, pi], and finds the heading's cosine and sine.
template <class Scalar, bool remembers = remembers_quadrant<Scalar>,
          bool beside = has_heading_relative_to<Scalar>>
struct HeadingTracker {
  using Base = base_t<Scalar>;
  NFOPIDN_INLINE Heading<Scalar> track(Scalar& between, const Scalar& angle,
                                       const LoopInputs<Base>& /*inputs*/, int /*k*/) {
    between = math<Scalar>::wrap(between);
    return math<Scalar>::heading(angle);
  }
};
// For a Scalar that remembers its quadrant: angles change little from one sample to the next.
template <class Scalar>
struct HeadingTracker<Scalar, true, false> {
  using Base = base_t<Scalar>;
  typename math<Scalar>::Turn turn = math<Scalar>::no_turn();
  NFOPIDN_INLINE Heading<Scalar> track(Scalar& between, const Scalar& angle,
                                       const LoopInputs<Base>& /*inputs*/, int /*k*/) {
    between = math<Scalar>::wrap(between);
    return math<Scalar>::heading(angle, turn);
  }
};
// For lanes: the reference's cosine and sine, one pair for all lanes, are known.
template <class Scalar>
struct HeadingTracker<Scalar, false, true> {
  using Base = base_t<Scalar>;
  NFOPIDN_INLINE Heading<Scalar> track(Scalar& between, const Scalar& /*angle*/,
                                       const LoopInputs<Base>& inputs, int k) {
    return math<Scalar>::heading_relative_to(inputs.headings[k], between);
  }
};

}  // namespace detail

}  // namespace nfopidn
