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
  // Makes ready for a run: at rest, or, with `in_motion`, at the reference's speed already.
  void start(const ControllerDesign& design, const ControlLimits<double>& limits, bool in_motion);
  // Whether start() has told the sample time and the peak speed.
  bool is_started() const { return limits_.sample_time > 0; }
  double torque_limit() const { return limits_.torque; }
  // At the first call, and where the limit [N m] is another one, the law is set up.
  TorquePair<double> step(const ControllerDesign& design, double torque_limit,
                          const Measurement<double>& measured,
                          const ReferenceSample<double>& reference);
  void reset();
  TorquePair<double> feedback() const;

 private:
  struct Laws;

  void set_up(const ControllerDesign& design);

  std::unique_ptr<Laws> laws_;
  ControlLimits<double> limits_ = {0, 1, 0};
};

}  // namespace nfopidn::python
