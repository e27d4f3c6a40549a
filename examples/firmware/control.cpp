#include "control.hpp"

#ifndef CONTROL_MEMORY
#define CONTROL_MEMORY 5
#endif

namespace {

using namespace nfopidn;

constexpr int memory = CONTROL_MEMORY;
#ifdef CONTROL_LINEAR
constexpr Activation activation = Activation::linear;
#else
constexpr Activation activation = Activation::sigmoid;
#endif
#ifdef CONTROL_ANY_STRUCTURE
using Structure = RuntimeVariant<float>;
#else
using Structure = FixedVariant<float, Form::positional, AllocationKind::paper, Lateral::direction,
                               AntiWindup::none, activation>;
#endif
using Law = Controller<float, Fir<float, memory + 2>, Structure>;

constexpr ControllerSettings<float> settings() {
  ControllerSettings<float> chosen;  // the paper's gains and orders
  chosen.memory = memory;
  chosen.activation = activation;
  return chosen;
}

// Designed by the compiler: the arithmetic of the weights takes no room in flash.
struct Design {
  Law law;
  Status status = law.configure(settings());
};
constexpr Design design;
static_assert(design.status == Status::ok);
Law law = design.law;

}  // namespace

void control_reset() { law.reset(); }

Torques control_step(const Pose& measured, const Reference& reference) {
  return law.step(measured, reference);
}
