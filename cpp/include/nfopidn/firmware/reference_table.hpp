// L2. The reference on board: samples in flash, looked up by the number of the sample.
#pragma once

#include "nfopidn/control/reference.hpp"

namespace nfopidn {

// `samples` are borrowed, and there is at least one. A table with `lap` > 0 begins again after as
// many samples; of a closed path whose last sample is the first again that is `count` - 1. Without
// one it ends: the robot is to stand at the last pose.
template <class Base>
class ReferenceTable {
 public:
  constexpr ReferenceTable(const ReferenceSample<Base>* samples, int count, int lap = 0) noexcept
      : samples_(samples), count_(count), lap_(lap) {}

  // Of sample k = 0, 1, ...
  constexpr ReferenceSample<Base> at(unsigned long k) const noexcept {
    if (lap_ > 0) return samples_[k % static_cast<unsigned long>(lap_)];
    if (k < static_cast<unsigned long>(count_)) return samples_[k];
    const ReferenceSample<Base>& last = samples_[count_ - 1];
    return {last.x, last.y, last.theta, Base(0), Base(0), Base(0), Base(0), last.reverse};
  }

  constexpr int count() const noexcept { return count_; }

 private:
  const ReferenceSample<Base>* samples_;
  int count_;
  int lap_;
};

}  // namespace nfopidn
