// L2. A controller in a world where measurements are missing or wrong.
#pragma once

#include "nfopidn/control/reference.hpp"

namespace nfopidn {

enum class Fault : unsigned char {
  none,
  held,     // no measurement, or a bad one: the sample was bridged
  stopped,  // for too long, or there never was one: no torque
};

// How a sample with a bad measurement is bridged.
enum class Bridge : unsigned char {
  hold,    // the last torque stands, and the law does not run
  repeat,  // the law runs on its last error, with the present feedforward: as a missed sample
};

// Runs a controller as long as it is given measurements and references. A bad one (NaN, infinite,
// or so large that Scalar's arithmetic would not survive it) never reaches the law's memory. Up to
// `hold_samples` in a row without a good one are bridged; then there is no torque until a good one
// comes, with which the law starts again, without a kick. Law is a Controller, or a Bumpless
// around one.
template <class Law, class Scalar>
class Guarded {
 public:
  using Base = base_t<Scalar>;

  // Metres, and radians, beyond which a measurement is bad: so far out a float's digits are 6 cm
  // apart.
  static constexpr Base farthest = Base(1e6);

  constexpr Guarded(Law& law, int hold_samples, Bridge bridge = Bridge::hold) noexcept
      : law_(law), hold_samples_(hold_samples), bridge_(bridge), without_(hold_samples) {}

  constexpr TorquePair<Scalar> step(const Measurement<Scalar>& measured,
                                    const ReferenceSample<Base>& reference) noexcept {
    if (!usable(measured) || !usable(reference)) {
      if (bridge_ == Bridge::repeat) return missed(reference);
      if (!bridged()) return last_ = none();
      law_.miss();
      return last_;
    }
    if (fault_ == Fault::stopped) law_.reset_to(measured, reference);
    without_ = 0;
    fault_ = Fault::none;
    return last_ = law_.step(measured, reference);
  }

  // The timer ticked and no measurement came: the law takes its last error once more, so that its
  // memory keeps pace with time, and adds the present feedforward.
  constexpr TorquePair<Scalar> missed(const ReferenceSample<Base>& reference) noexcept {
    if (!bridged()) return last_ = none();
    if (usable(reference)) return last_ = law_.repeat(reference);
    law_.miss();
    return last_;
  }

  constexpr void reset() noexcept {
    law_.reset();
    forget();
  }

  // Without a kick at the next step; a bad measurement is as none.
  constexpr void reset_to(const Measurement<Scalar>& measured,
                          const ReferenceSample<Base>& reference) noexcept {
    if (!usable(measured) || !usable(reference)) return reset();
    law_.reset_to(measured, reference);
    forget();
  }

  constexpr Fault fault() const noexcept { return fault_; }

  // False for NaN too.
  static constexpr bool usable(const Measurement<Scalar>& measured) noexcept {
    using M = math<Scalar>;
    return M::absolute(measured.x) <= farthest && M::absolute(measured.y) <= farthest &&
           M::absolute(measured.theta) <= farthest;
  }
  static constexpr bool usable(const ReferenceSample<Base>& reference) noexcept {
    using M = math<Base>;
    return M::absolute(reference.x) <= farthest && M::absolute(reference.y) <= farthest &&
           M::absolute(reference.theta) <= farthest && M::absolute(reference.v) <= farthest &&
           M::absolute(reference.tau_left) <= farthest &&
           M::absolute(reference.tau_right) <= farthest && usable_turn_rate(reference.omega);
  }

 private:
  // The tracking law alone reads it.
  static constexpr bool usable_turn_rate(Base omega) noexcept {
    return !Law::Structure::has_tracking_law || math<Base>::absolute(omega) <= farthest;
  }

  static constexpr TorquePair<Scalar> none() noexcept { return {Scalar(0), Scalar(0)}; }

  // Counts a sample without a measurement. Before the first one there is nothing to bridge from.
  constexpr bool bridged() noexcept {
    const bool possible = without_ < hold_samples_;
    if (possible) ++without_;
    fault_ = possible ? Fault::held : Fault::stopped;
    return possible;
  }

  constexpr void forget() noexcept {
    without_ = hold_samples_;
    fault_ = Fault::none;
  }

  Law& law_;
  int hold_samples_;
  Bridge bridge_;
  Fault fault_ = Fault::none;
  int without_;  // samples in a row without a good measurement
  TorquePair<Scalar> last_ = none();
};

}  // namespace nfopidn
