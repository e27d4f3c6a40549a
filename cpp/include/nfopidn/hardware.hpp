// L2. Between the law and a real robot: bad measurements, signs, odometry.
#pragma once

#include <type_traits>

#include "nfopidn/controller.hpp"

namespace nfopidn {

// A real robot's wheels in the sense of REP-103: the left one drives the robot forward and turns it
// clockwise. The paper's left wheel turns it counter-clockwise, so the two change places.
template <class Scalar>
constexpr TorquePair<Scalar> to_rep103(const TorquePair<Scalar>& torque) {
  return {torque.right, torque.left};
}

// The pose after the wheels have rolled `left` and `right` metres (REP-103) on an arc of a circle,
// exactly, however long. `track_width` [m].
template <class Scalar>
State<Scalar> odometry(const State<Scalar>& state, Scalar left, Scalar right,
                       base_t<Scalar> track_width) {
  using M = math<Scalar>;
  const Scalar turned = (right - left) / track_width;
  const Scalar distance = (left + right) / 2;
  // The chord is the arc times sin(h)/h with h half the angle, and lies at the mean heading.
  const Scalar half = turned / 2;
  const bool straight = half < Scalar(1e-4) && half > Scalar(-1e-4);
  const Scalar shrink = straight ? 1 - half * half / 6 : M::heading(half).sine / half;
  const Heading<Scalar> mean = M::heading(state.theta + half);
  State<Scalar> next = state;
  next.x = state.x + distance * shrink * mean.cosine;
  next.y = state.y + distance * shrink * mean.sine;
  next.theta = M::wrap(state.theta + turned);
  return next;
}

// Metres that a wheel has rolled between two counts of its encoder. Counters may wrap around once:
// give them as unsigned integers.
template <class Scalar, class Count>
constexpr Scalar rolled(Count before, Count now, Scalar ticks_per_turn, Scalar wheel_radius) {
  using Signed = std::make_signed_t<Count>;
  const auto ticks = static_cast<Signed>(static_cast<Count>(now - before));
  return static_cast<Scalar>(ticks) * (2 * math<Scalar>::pi * wheel_radius / ticks_per_turn);
}

enum class Fault : unsigned char {
  none,
  held,     // the measurement was bad: the last torque stands
  stopped,  // it was bad for too long: no torque
};

// Runs a controller as long as its measurements and references are numbers. One that is not never
// reaches the law's memory: the last torque is held for `hold_samples`, then there is none until a
// good one comes. Numbers beyond a million metres or radians count as bad too: their errors could
// pass the greatest float within the law, and stay there as NaN. After `hold_samples` bad ones the
// law starts afresh, without a kick from errors of long ago.
template <class Law, class Scalar>
class Guarded {
 public:
  explicit constexpr Guarded(Law& law, int hold_samples) : law_(law), hold_samples_(hold_samples) {}

  constexpr TorquePair<Scalar> step(const Measurement<Scalar>& measured,
                                    const ReferenceSample<base_t<Scalar>>& reference) noexcept {
    if (is_good(measured, reference)) {
      if (fault_ == Fault::stopped) law_.reset();
      bad_ = 0;
      fault_ = Fault::none;
      return last_ = law_.step(measured, reference);
    }
    if (bad_ < hold_samples_) {
      ++bad_;
      fault_ = Fault::held;
      return last_;
    }
    fault_ = Fault::stopped;
    return last_ = {Scalar(0), Scalar(0)};
  }

  constexpr void reset() noexcept {
    law_.reset();
    bad_ = 0;
    fault_ = Fault::none;
    last_ = {Scalar(0), Scalar(0)};
  }
  constexpr Fault fault() const noexcept { return fault_; }

 private:
  // False for NaN.
  static constexpr bool is_small(Scalar value) noexcept {
    return math<Scalar>::absolute(value) <= Scalar(1e6);
  }
  static constexpr bool is_good(const Measurement<Scalar>& measured,
                                const ReferenceSample<base_t<Scalar>>& reference) noexcept {
    return is_small(measured.x) && is_small(measured.y) && is_small(measured.theta) &&
           is_small(reference.x) && is_small(reference.y) && is_small(reference.theta) &&
           is_small(reference.v) && is_small(reference.tau_left) && is_small(reference.tau_right);
  }

  Law& law_;
  int hold_samples_;
  int bad_ = 0;
  Fault fault_ = Fault::none;
  TorquePair<Scalar> last_ = {Scalar(0), Scalar(0)};
};

}  // namespace nfopidn
