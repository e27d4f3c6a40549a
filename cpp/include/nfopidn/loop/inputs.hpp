// L2. What acts on the closed loop from outside: reference, noise, disturbance, delay.
#pragma once

#include "nfopidn/control/reference.hpp"
#include "nfopidn/loop/cost.hpp"
#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

// What happens to the loop from outside. Pointers are borrowed.
template <class Base>
struct LoopInputs {
  const ReferenceSample<Base>* reference = nullptr;  // `samples` of them
  int samples = 0;
  const Heading<Base>* headings = nullptr;   // of the reference's angles; only lanes need them
  const Measurement<Base>* noise = nullptr;  // added to the measurement, per sample; may be null
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

}  // namespace nfopidn
