// Settings, limits, measurements and references of arbitrary bits through a guarded control step.
#include <cmath>
#include <initializer_list>

#include "fuzz.hpp"
#include "nfopidn/control/controller.hpp"
#include "nfopidn/firmware/guarded.hpp"

using namespace nfopidn;

namespace {

template <class Base>
ControllerSettings<Base> take_settings(fuzz::Bytes& bytes) {
  ControllerSettings<Base> settings;
  const auto parts = bytes.take<std::uint8_t>();  // which of them to draw: all is seldom valid
  if (parts & 1) {
    for (auto& row : settings.gains) {
      for (Base& gain : row) gain = bytes.number<Base>();
    }
  }
  if (parts & 2) {
    for (Base& order : settings.alpha) order = bytes.number<Base>();
    for (Base& order : settings.sigma) order = bytes.number<Base>();
  }
  if (parts & 4) {
    for (auto& row : settings.allocation.matrix) {
      for (Base& share : row) share = bytes.number<Base>();
    }
  }
  if (parts & 8) settings.speed_scale = bytes.number<Base>();
  settings.memory = bytes.take<std::int8_t>() % 8;
  settings.form = static_cast<Form>(bytes.take<std::uint8_t>() % 2);
  settings.activation = static_cast<Activation>(bytes.take<std::uint8_t>() % 2);
  settings.frame = static_cast<Frame>(bytes.take<std::uint8_t>() % 2);
  settings.generator = static_cast<Generator>(bytes.take<std::uint8_t>() % 2);
  settings.lateral = static_cast<Lateral>(bytes.take<std::uint8_t>() % 3);
  settings.anti_windup = static_cast<AntiWindup>(bytes.take<std::uint8_t>() % 3);
  return settings;
}

template <class Base>
ReferenceSample<Base> take_reference(fuzz::Bytes& bytes) {
  ReferenceSample<Base> reference = {};
  for (Base* number : {&reference.x, &reference.y, &reference.theta, &reference.v, &reference.omega,
                       &reference.tau_left, &reference.tau_right}) {
    *number = bytes.number<Base>();
  }
  reference.reverse = bytes.take<std::uint8_t>() % 2 != 0;
  return reference;
}

template <class Scalar>
bool same(const TorquePair<Scalar>& a, const TorquePair<Scalar>& b) {
  return a.left == b.left && a.right == b.right;
}

// Steps a guarded law, and beside it one that sees the good samples only.
template <class Law, class Scalar>
void check_steps(const Law& configured, Scalar limit, fuzz::Bytes& bytes) {
  Law law = configured;
  Law good_only = configured;
  const int hold_samples = bytes.take<std::uint8_t>() % 4;
  Guarded<Law, Scalar> guarded(law, hold_samples);
  TorquePair<Scalar> last = {0, 0};
  int without = hold_samples;  // before the first good sample there is nothing to hold
  Fault before = Fault::none;
  for (int k = 0; k < 64 && !bytes.empty(); ++k) {
    const Measurement<Scalar> measured = {bytes.number<Scalar>(), bytes.number<Scalar>(),
                                          bytes.number<Scalar>(), bytes.number<Scalar>(),
                                          bytes.number<Scalar>()};
    const ReferenceSample<Scalar> reference = take_reference<Scalar>(bytes);
    const TorquePair<Scalar> torque = guarded.step(measured, reference);
    fuzz::require(std::fabs(torque.left) <= limit && std::fabs(torque.right) <= limit,
                  "torques are numbers within the limit");
    if (guarded.fault() == Fault::none) {
      if (before == Fault::stopped) good_only.reset_to(measured, reference);
      fuzz::require(same(torque, good_only.step(measured, reference)),
                    "bad samples leave no trace in the law");
      without = 0;
    } else {
      const bool stopped = without >= hold_samples;
      if (!stopped) ++without;
      fuzz::require((guarded.fault() == Fault::stopped) == stopped,
                    "the torque is held as long as was asked");
      fuzz::require(same(torque, stopped ? TorquePair<Scalar>{0, 0} : last),
                    "a bad sample gives the last torque, or none");
    }
    before = guarded.fault();
    last = torque;
  }
  guarded.reset();
  Law fresh = configured;
  const Measurement<Scalar> measured = {Scalar(0.2), Scalar(-0.1), Scalar(0.05), 0, 0};
  const ReferenceSample<Scalar> reference = {};
  fuzz::require(same(guarded.step(measured, reference), fresh.step(measured, reference)),
                "a law that is reset is as new");
  fuzz::require(guarded.fault() == Fault::none, "plain samples are good");
}

template <class Scalar, int slack>
void check(fuzz::Bytes bytes) {
  Controller<Scalar, Fir<Scalar, 7, slack>> law;
  const ControllerSettings<Scalar> settings = take_settings<Scalar>(bytes);
  ControlLimits<Scalar> limits;
  if (bytes.take<std::uint8_t>() % 4 == 0) {
    limits = {bytes.number<Scalar>(), bytes.number<Scalar>()};
  }
  if (law.configure(settings, limits) != Status::ok) {
    decltype(law) untouched;
    fuzz::require(law.filter().tap(0, 0) == untouched.filter().tap(0, 0) &&
                      law.filter().count() == untouched.filter().count(),
                  "refused settings change nothing");
    return;
  }
  check_steps(law, limits.torque, bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::Bytes bytes(data, size);
  check<float, 0>(bytes);
  check<double, 5>(bytes);
  return 0;
}
