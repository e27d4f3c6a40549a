#include "running_controller.hpp"

#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn::python {

// One of them, by the memory.
struct RunningController::Laws {
  std::unique_ptr<
      Controller<double, Fir<double, maximum_memory + 2, maximum_memory>, TrackingVariant<double>>>
      taps;
  std::unique_ptr<LongController> modes;
};

RunningController::RunningController() = default;
RunningController::RunningController(RunningController&& other) noexcept = default;
RunningController& RunningController::operator=(RunningController&& other) noexcept = default;
RunningController::~RunningController() = default;

RunningController RunningController::copy() const {
  RunningController result;
  result.limits_ = limits_;
  if (!laws_) return result;
  result.laws_ = std::make_unique<Laws>();
  if (laws_->taps)
    result.laws_->taps = std::make_unique<decltype(Laws::taps)::element_type>(*laws_->taps);
  if (laws_->modes) result.laws_->modes = std::make_unique<LongController>(*laws_->modes);
  return result;
}

void RunningController::start(const ControllerDesign& design, const ControlLimits<double>& limits,
                              bool in_motion) {
  limits_ = limits;
  set_up(design);
  const auto restart = [in_motion](auto& law) { in_motion ? law.reset_in_motion() : law.reset(); };
  if (laws_->taps) restart(*laws_->taps);
  if (laws_->modes) restart(*laws_->modes);
}

void RunningController::set_up(const ControllerDesign& design) {
  if (!laws_) laws_ = std::make_unique<Laws>();
  if (design.memory.is_long()) {
    if (!laws_->modes) {
      laws_->modes = std::make_unique<LongController>(long_controller(design, limits_));
    }
    laws_->modes->configure_structure(design, limits_);
  } else {
    if (!laws_->taps) laws_->taps = std::make_unique<decltype(Laws::taps)::element_type>();
    laws_->taps->configure(design, limits_);
    if (!design.taps.empty()) {
      laws_->taps->set_taps(design.channel_taps(0), design.channel_taps(1), design.channel_taps(2),
                            design.memory + 2);
    }
  }
}

TorquePair<double> RunningController::step(const ControllerDesign& design, double torque_limit,
                                           const Measurement<double>& measured,
                                           const ReferenceSample<double>& reference) {
  if (limits_.torque != torque_limit) {
    limits_.torque = torque_limit;
    set_up(design);
  }
  return laws_->modes ? laws_->modes->step(measured, reference)
                      : laws_->taps->step(measured, reference);
}

void RunningController::reset() {
  if (!laws_) return;
  if (laws_->taps) laws_->taps->reset();
  if (laws_->modes) laws_->modes->reset();
}

TorquePair<double> RunningController::feedback() const {
  if (!laws_) return {0, 0};
  return laws_->modes ? laws_->modes->feedback() : laws_->taps->feedback();
}

}  // namespace nfopidn::python
