// L2. A delay of whole samples between the controller and the wheels.
#pragma once

#include "nfopidn/control/reference.hpp"

namespace nfopidn {

constexpr int maximum_delay = 64;  // [samples]

// Torques on their way from the controller to the wheels. The wheels have none until the first.
template <class Scalar>
class DelayLine {
 public:
  explicit constexpr DelayLine(int delay) : delay_(delay) {
    const Scalar zero = Scalar(base_t<Scalar>(0));
    for (int i = 0; i < delay_; ++i) torques_[i] = {zero, zero};
  }
  NFOPIDN_INLINE constexpr TorquePair<Scalar> pass(const TorquePair<Scalar>& torque) {
    return delay_ == 0 ? torque : exchange(torque);
  }
  // The torque that the wheels get `samples` from now, 0 <= samples < delay.
  constexpr TorquePair<Scalar>& ahead(int samples) { return torques_[(next_ + samples) % delay_]; }

 private:
  // Never inlined, so that a torque without delay need not lie in memory.
  NFOPIDN_NOINLINE constexpr TorquePair<Scalar> exchange(TorquePair<Scalar> torque) {
    const TorquePair<Scalar> oldest = torques_[next_];
    torques_[next_] = torque;
    next_ = next_ + 1 == delay_ ? 0 : next_ + 1;
    return oldest;
  }

  TorquePair<Scalar> torques_[maximum_delay];
  int delay_;
  int next_ = 0;
};

}  // namespace nfopidn
