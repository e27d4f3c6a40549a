// L1. The three error channels' fractional PIDs as finite impulse response filters.
#pragma once

#include "nfopidn/math/math.hpp"

namespace nfopidn {

constexpr int channel_count = 3;  // x, y, theta, everywhere in this order

template <class Scalar>
struct Channels {
  Scalar x;
  Scalar y;
  Scalar theta;
};

// Eq. 34: net(k) = sum_j taps[j] e(k - j) in each channel.
//
// The newest error lies at history[head]; pushing moves head down by one, and when it reaches the
// start the Capacity - 1 errors still needed move to the end. With Slack = 0, the least memory,
// that is a plain shift at every sample; with a larger Slack the move is rare.
template <class Scalar, int Capacity, int Slack = 0>
class Fir {
 public:
  static_assert(Capacity >= 2 && Slack >= 0, "a channel has at least memory 0, that is two taps");
  using Base = base_t<Scalar>;
  static constexpr int capacity = Capacity;

  constexpr Fir() { reset(); }

  // `taps` point to `count` <= Capacity numbers a channel; `scale` multiplies a channel's taps.
  // Keeps the past errors.
  template <class Tap>
  constexpr void set_taps(const Channels<const Tap*>& taps, const Channels<Base>& scale,
                          int count) {
    set_channel(0, taps.x, scale.x, count);
    set_channel(1, taps.y, scale.y, count);
    set_channel(2, taps.theta, scale.theta, count);
    count_ = count;
  }

  constexpr void reset() {
    const Scalar zero = Scalar(Base(0));
    fill({zero, zero, zero});
  }

  // As if `error` had been given for ever.
  constexpr void fill(const Channels<Scalar>& error) {
    fill_channel(0, error.x);
    fill_channel(1, error.y);
    fill_channel(2, error.theta);
    head_ = Slack;
  }

  // The last error given.
  constexpr Channels<Scalar> newest() const {
    const int last = shifting ? 0 : head_;
    return {history_[0][last], history_[1][last], history_[2][last]};
  }

  NFOPIDN_INLINE constexpr Channels<Scalar> step(const Channels<Scalar>& error) {
    if constexpr (shifting) return {pass(0, error.x), pass(1, error.y), pass(2, error.theta)};
    make_room();
    history_[0][head_] = error.x;
    history_[1][head_] = error.y;
    history_[2][head_] = error.theta;
    return {dot(0, error.x), dot(1, error.y), dot(2, error.theta)};
  }

  constexpr const Scalar& tap(int channel, int j) const { return taps_[channel][j]; }
  constexpr int count() const { return count_; }

 private:
  // The least memory and the fewest instructions: the shift is done within the sum, and the newest
  // error needs no place before it.
  static constexpr bool shifting = Slack == 0 && Capacity <= 16;

  template <class Tap>
  constexpr void set_channel(int channel, const Tap* taps, Base scale, int count) {
    for (int j = 0; j < Capacity; ++j) {
      taps_[channel][j] = j < count ? Scalar(taps[j] * scale) : Scalar(Base(0));
    }
  }

  constexpr void fill_channel(int channel, const Scalar& value) {
    for (auto& error : history_[channel]) error = value;
  }

  NFOPIDN_INLINE constexpr void make_room() {
    if (Slack > 0 && head_ > 0) {
      --head_;
      return;
    }
    for (auto& errors : history_) {
      for (int j = Capacity - 2; j >= 0; --j) errors[Slack + 1 + j] = errors[j];
    }
    head_ = Slack;
  }

  NFOPIDN_INLINE constexpr Scalar pass(int channel, const Scalar& newest) {
    const Scalar* taps = taps_[channel];
    Scalar* errors = history_[channel];  // e(k - 1) and older
    Scalar sum = taps[Capacity - 1] * errors[Capacity - 2];
#pragma GCC unroll 16
    for (int j = Capacity - 2; j >= 1; --j) {
      const Scalar error = errors[j - 1];
      sum = sum + taps[j] * error;
      errors[j] = error;
    }
    errors[0] = newest;
    return sum + taps[0] * newest;
  }

  // Oldest first, so that the sum waits for the newest error with one multiplication only.
  NFOPIDN_INLINE constexpr Scalar dot(int channel, const Scalar& newest) const {
    // A small filter always runs to its capacity (the rest of its taps is zero), so that the
    // compiler unrolls it.
    const int last = (Capacity <= 16 ? Capacity : count_) - 1;
    const Scalar* taps = taps_[channel];
    const Scalar* errors = history_[channel] + head_;
    Scalar sum = taps[last] * errors[last];
    for (int j = last - 1; j >= 1; --j) sum = sum + taps[j] * errors[j];
    sum = sum + taps[0] * newest;
    return sum;
  }

  Scalar taps_[channel_count][Capacity] = {};
  Scalar history_[channel_count][shifting ? Capacity - 1 : Capacity + Slack] = {};
  int count_ = 2;
  int head_ = Slack;
};

}  // namespace nfopidn
