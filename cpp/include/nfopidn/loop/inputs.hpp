// L2. What acts on the closed loop from outside: reference, noise, disturbance, delay.
#pragma once

#include "nfopidn/control/reference.hpp"
#include "nfopidn/loop/cost.hpp"
#include "nfopidn/loop/encoders.hpp"
#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

// What happens to the loop from outside. Pointers are borrowed.
template <class Base>
struct LoopInputs {
  const ReferenceSample<Base>* reference = nullptr;  // `samples` of them
  int samples = 0;
  const Heading<Base>* headings = nullptr;   // of the reference's angles; only lanes need them
  const Measurement<Base>* noise = nullptr;  // added to the measurement, per sample; may be null
  const Encoders<Base>* encoders = nullptr;  // the pose is by odometry; null: it is measured
  const Disturbance<Base>* disturbance = nullptr;  // may be null
  bool disturbance_by_sample = false;   // else disturbance points to one, which is constant
  int delay = 0;                        // samples from measurement to applied torque
  bool feedforward = true;              // the law is given the reference torques
  Base divergence_distance = Base(10);  // [m]
  CostWeights<Base> cost_weights;

  // What acts on the robot at sample k; may be null.
  constexpr const Disturbance<Base>* disturbance_at(int k) const {
    return disturbance != nullptr && disturbance_by_sample ? disturbance + k : disturbance;
  }
};

// The same with a pose by odometry.
template <class Scalar>
class SensedInputs : public LoopInputs<base_t<Scalar>> {
 public:
  using Base = base_t<Scalar>;

  constexpr SensedInputs(const LoopInputs<Base>& inputs, const State<Scalar>& start)
      : LoopInputs<Base>(inputs), odometry_(*inputs.encoders, values_of(start)) {}

  // What the measured pose has besides the true one. Counts do not change with a slope: the
  // slopes of a dual number's pose are those of the true one.
  constexpr Measurement<Base> error_at(int k, const State<Scalar>& state) {
    const State<Base> truth = values_of(state);
    const State<Base>& pose = odometry_.sense(truth);
    Measurement<Base> error = {pose.x - truth.x, pose.y - truth.y,
                               math<Base>::wrap(pose.theta - truth.theta), Base(0), Base(0)};
    if (this->noise != nullptr) {
      error.x = error.x + this->noise[k].x;
      error.y = error.y + this->noise[k].y;
      error.theta = error.theta + this->noise[k].theta;
    }
    return error;
  }

 private:
  static constexpr Base value_of(Base number) { return number; }
  template <class Number>
  static constexpr Base value_of(const Number& number) {
    return number.value;
  }
  static constexpr State<Base> values_of(const State<Scalar>& state) {
    return {value_of(state.x), value_of(state.y), value_of(state.theta), value_of(state.v),
            value_of(state.omega)};
  }

  EncoderOdometry<Base> odometry_;
};

}  // namespace nfopidn
