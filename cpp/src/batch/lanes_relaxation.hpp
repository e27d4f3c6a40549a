// How speeds of lanes relax: plant/relaxation.hpp's decay, of one rate for all lanes or of a rate a
// lane.
#pragma once

#include "lanes_math.hpp"
#include "nfopidn/plant/relaxation.hpp"

namespace nfopidn {

namespace lanes {

// exact::decay() at any time up to `longest`.
template <class V, class Rate>
class Relaxation;

template <class V>
class Relaxation<V, double> {
 public:
  NFOPIDN_INLINE Relaxation(double rate, double longest)
      : rate_(rate), halvings_(exact::halvings(rate * longest)) {}
  NFOPIDN_INLINE exact::Decay<V> operator()(const V& time) const {
    return exact::decay(rate_, time, halvings_);
  }

 private:
  double rate_;
  int halvings_;
};

// By the series where rate and time are small, and elsewhere by the exponential function.
template <class V>
class Relaxation<V, V> {
 public:
  NFOPIDN_INLINE Relaxation(const V& rate, double /*longest*/) : rate_(rate) {}
  NFOPIDN_INLINE exact::Decay<V> operator()(const V& time) const {
    using M = math<V>;
    constexpr double near = 0.5;
    const V x = time * rate_;
    exact::Decay<V> share = exact::decay_shares<V, double>(M::minimum(x, V(near)));
    const auto far = x > near;
    if (M::any(far)) {
      const V left = M::exponential(x * -1.0);
      const V first = (1.0 - left) / x;
      share.left = M::select(far, left, share.left);
      share.phi = M::select(far, first, share.phi);
      share.psi = M::select(far, (1.0 - first) / x, share.psi);
    }
    return {share.left, time * share.phi, time * time * share.psi};
  }

 private:
  V rate_;
};

}  // namespace lanes

}  // namespace nfopidn
