// L2. New gains, another reference or another controller without a step in the torques.
#pragma once

#include "nfopidn/control/reference.hpp"
#include "nfopidn/foundation/traits.hpp"

namespace nfopidn {

namespace detail {

template <class Law, class = void>
constexpr bool stops_by_itself = false;
template <class Law>
constexpr bool stops_by_itself<Law, traits::void_t<decltype(traits::declval<Law&>().fault())>> =
    true;

}  // namespace detail

// After begin() the output starts at the last torque and glides to the law's own: what lies between
// them is added, in a share that falls from 1 to 0 at even steps. `torque_limit` [N m] bounds the
// sum. A Guarded goes around it, not into it, so that a stop is at once.
template <class Law, class Scalar>
class Bumpless {
 public:
  using Base = base_t<Scalar>;
  using Structure = typename Law::Structure;
  static_assert(!detail::stops_by_itself<Law>,
                "put Guarded around Bumpless: a stop must not be blended");

  constexpr Bumpless(Law& law, Base torque_limit) noexcept : law_(law), limit_(torque_limit) {}

  // The next step's torque is the last one's, and the `samples`-th after it the law's own. Call it
  // between a change of gains (Controller::configure, set_taps) or of the reference and the step.
  constexpr void begin(int samples) noexcept { begin_from(last_, samples); }

  // The same after torques of somebody else: another controller, or a hand on the joystick. Ones
  // that are no numbers count as none.
  constexpr void begin_from(const TorquePair<Scalar>& torque, int samples) noexcept {
    using M = math<Scalar>;
    last_ = M::is_finite(torque.left) && M::is_finite(torque.right) ? torque : none();
    remaining_ = samples > 0 ? samples : 0;
    beginning_ = remaining_ > 0;
  }

  constexpr TorquePair<Scalar> step(const Measurement<Scalar>& measured,
                                    const ReferenceSample<Base>& reference) noexcept {
    return blend(law_.step(measured, reference));
  }
  constexpr TorquePair<Scalar> repeat(const ReferenceSample<Base>& reference) noexcept {
    return blend(law_.repeat(reference));
  }
  constexpr void miss() noexcept { law_.miss(); }

  constexpr void reset() noexcept {
    law_.reset();
    begin_from(none(), 0);
  }
  constexpr void reset_to(const Measurement<Scalar>& measured,
                          const ReferenceSample<Base>& reference) noexcept {
    law_.reset_to(measured, reference);
    begin_from(none(), 0);
  }

  constexpr bool gliding() const noexcept { return remaining_ > 0; }

 private:
  static constexpr TorquePair<Scalar> none() noexcept { return {Scalar(0), Scalar(0)}; }

  constexpr TorquePair<Scalar> blend(const TorquePair<Scalar>& own) noexcept {
    if (remaining_ == 0) return last_ = own;
    if (beginning_) {
      const Base share = Base(1) / static_cast<Base>(remaining_);
      fall_ = {(last_.left - own.left) * share, (last_.right - own.right) * share};
      beginning_ = false;
      --remaining_;
      return last_ = {limited(last_.left), limited(last_.right)};
    }
    const Base steps = static_cast<Base>(remaining_);
    --remaining_;
    return last_ = {limited(own.left + fall_.left * steps),
                    limited(own.right + fall_.right * steps)};
  }

  constexpr Scalar limited(const Scalar& torque) const noexcept {
    using M = math<Scalar>;
    return M::maximum(M::minimum(torque, limit_), -limit_);
  }

  Law& law_;
  Base limit_;
  TorquePair<Scalar> last_ = none();
  TorquePair<Scalar> fall_ = none();  // what is added falls by this at each sample
  int remaining_ = 0;                 // samples until the law's own torque
  bool beginning_ = false;
};

}  // namespace nfopidn
