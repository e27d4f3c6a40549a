// L2. The cost of a run, eq. 41, and the rule by which a run counts as diverged.
#pragma once

#include "nfopidn/control/reference.hpp"

namespace nfopidn {

// How much the squares of the errors count in the cost. Eq. 41 has 1 for each.
template <class Base>
struct CostWeights {
  Base position = Base(1);
  Base heading = Base(1);
  Base torque = Base(1);
};

// Eq. 41's sum, and the divergence rule: a run diverges when its state is not finite or the robot
// is more than a given distance from its reference; each sample from there on costs that distance
// squared, as a position error of it would, and the sample count stays the full one.
template <class Scalar>
class CostMeter {
 public:
  using Base = base_t<Scalar>;
  using M = math<Scalar>;

  explicit constexpr CostMeter(Base divergence_distance, const CostWeights<Base>& weights = {})
      : square_limit_(divergence_distance * divergence_distance),
        missing_(weights.position * square_limit_),
        surely_running_(weights.position < Base(1) ? missing_ : square_limit_),
        weights_(weights) {}

  // True errors, total torque after the limit. Returns whether any component is still running.
  NFOPIDN_INLINE constexpr bool add(const Channels<Scalar>& error, const TorquePair<Scalar>& torque,
                                    const ReferenceSample<Base>& reference) {
    const Scalar distance = error.x * error.x + error.y * error.y;
    const Scalar angle_square = error.theta * error.theta;
    const Scalar left = reference.tau_left - torque.left;
    const Scalar right = reference.tau_right - torque.right;
    const Scalar term = weights_.position * distance + weights_.heading * angle_square +
                        weights_.torque * (left * left + right * right);
    // The rule in one comparison while all is well: a term within the limit, weighted as positions
    // are where that is less, has every part of it within, and is a number.
    if (all_running_ && M::surely_under(term, surely_running_)) {
      sum_ = sum_ + term;
      return true;
    }
    running_ = M::both(running_, M::both(distance <= square_limit_, angle_square == angle_square));
    all_running_ = M::every(running_);
    sum_ = sum_ + M::select(running_, term, Scalar(missing_));
    return M::any(running_);
  }

  // Whether no component has diverged.
  constexpr bool all_running() const { return all_running_; }
  // An error that is zero where a component has diverged.
  constexpr Channels<Scalar> of_running(const Channels<Scalar>& error) const {
    const Scalar zero = Scalar(Base(0));
    return {M::select(running_, error.x, zero), M::select(running_, error.y, zero),
            M::select(running_, error.theta, zero)};
  }
  // Another value where a component has diverged.
  constexpr Scalar if_running(const Scalar& value, Base other) const {
    return M::select(running_, value, Scalar(other));
  }

  // Counts `samples` more as missing.
  constexpr void miss(int samples) {
    // One by one, so that a component's sum does not depend on when the others diverged.
    for (int k = 0; k < samples; ++k) sum_ = sum_ + missing_;
  }

  constexpr Scalar mean(int samples) const { return sum_ * (Base(1) / Base(samples)); }

  // Called every few samples. A meter with a bound abandons the run here; this one has none.
  constexpr void check_bound() {}

 protected:
  Scalar sum_ = Scalar(Base(0));
  Base square_limit_;
  Base missing_;         // the cost of a sample after divergence
  Base surely_running_;  // no component whose term is less has diverged
  CostWeights<Base> weights_;
  typename M::Mask running_ = M::all();
  bool all_running_ = true;
};

template <class Scalar>
struct LoopResult {
  Scalar cost;    // eq. 41, E
  int completed;  // samples until every component has diverged, all of them if one did not
};

}  // namespace nfopidn
