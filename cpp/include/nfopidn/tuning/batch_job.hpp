// L2. What the units per instruction set are given: raw pointers, borrowed.
#pragma once

#include "nfopidn/loop/closed_loop.hpp"
#include "nfopidn/plant/robot_drive.hpp"

namespace nfopidn {

constexpr int batch_capacity = 34;  // most taps a channel: memory 32
constexpr int small_capacity = 7;   // memory 5, the paper's

constexpr double no_bound = __builtin_huge_val();

// Takes a component as diverged once its cost over the inputs' samples is sure to be over `bound`:
// it then has some cost over it.
template <class Scalar>
class BoundedMeter : public CostMeter<Scalar> {
 public:
  using Base = base_t<Scalar>;
  using M = math<Scalar>;

  constexpr BoundedMeter(const LoopInputs<Base>& inputs, const Scalar& bound)
      : CostMeter<Scalar>(inputs.divergence_distance, inputs.cost_weights),
        most_(bound * (Base(inputs.samples) * rounding)) {}

  constexpr void check_bound() {
    this->running_ = M::both(this->running_, this->sum_ <= most_);
    this->all_running_ = M::every(this->running_);
  }

 private:
  static constexpr Base rounding = Base(1.000001);

  Scalar most_;
};

struct BatchJob {
  const RobotDrive<double>* plant;
  const LoopInputs<double>* inputs;  // for costs with headings, for gradients without
  const State<double>* start;
  const ControllerSettings<double>* structure;
  const ControlLimits<double>* limits;
  const double* laws;  // [candidates][law_size]: taps, [3][tap_count], and LawParameters if any
  int tap_count;
  int law_size;
  bool in_motion;  // the robot starts with the reference's speed
  int candidates;
  double* costs;  // [candidates]
  const double*
      bounds;  // [candidates], or null: a candidate over its bound gets some cost above it
  Poll poll;   // what it stops has no costs
};

// One candidate and the slopes of its law's numbers in several directions.
struct GradientJob {
  BatchJob batch;        // its law is that of the one candidate, costs its cost
  const double* slopes;  // [directions][law_size]
  int directions;
  double* gradient;  // [directions]: the cost's slopes
};

}  // namespace nfopidn
