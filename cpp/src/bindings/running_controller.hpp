// The law that Controller.step() runs. It is compiled apart from the bindings, which are not
// optimised for speed.
#pragma once

#include <memory>

#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/control/reference.hpp"

namespace nfopidn::python {

class RunningController {
 public:
  RunningController();
  RunningController(RunningController&& other) noexcept;
  RunningController& operator=(RunningController&& other) noexcept;
  ~RunningController();

  // One that goes on from the same past errors and torque.
  RunningController copy() const;
  // At the first call, and where the limit [N m] is another one, the law is set up.
  TorquePair<double> step(const ControllerDesign& design, double torque_limit,
                          const Measurement<double>& measured,
                          const ReferenceSample<double>& reference);
  void reset();
  TorquePair<double> feedback() const;

 private:
  struct Laws;

  void set_up(const ControllerDesign& design, double torque_limit);

  std::unique_ptr<Laws> laws_;
  double torque_limit_ = 0;
};

}  // namespace nfopidn::python
