#include "control.hpp"

#include "settings.hpp"

namespace {

using namespace nfopidn;

constexpr ControllerSettings<float> settings = control_settings<float>();
#ifdef CONTROL_ANY_STRUCTURE
using Structure = RuntimeVariant<float>;
#else
using Fixed = FixedVariant<float, settings.form, settings.allocation.kind(), settings.lateral,
                           settings.anti_windup, settings.activation>;
#ifdef CONTROL_TRACKING
using Structure = FixedTrackingVariant<float, Fixed>;
#else
using Structure = Fixed;
#endif
#endif
using Law = Controller<float, Fir<float, settings.memory + 2>, Structure>;

// Designed by the compiler: the arithmetic of the weights takes no room in flash.
struct Design {
  Law law;
  Status status = law.configure(settings);
};
constexpr Design design;
static_assert(design.status == Status::ok);
Law law = design.law;

}  // namespace

void control_reset() { law.reset(); }

Torques control_step(const Pose& measured, const Reference& reference) {
  return law.step(measured, reference);
}
