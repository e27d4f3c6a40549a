// L3. A controller on the host: settings, and taps where those are free instead of fused from gains
// and orders.
#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "nfopidn/control/controller_settings.hpp"
#include "nfopidn/plant/robot.hpp"

namespace nfopidn {

struct ControllerDesign : ControllerSettings<double> {
  // [3][memory + 2], newest first, as fuse_taps() makes them; empty: those of gains and orders.
  std::vector<double> taps;
  // That the gains are made for; none: not known, and not checked.
  std::optional<Robot<double>> robot;

  ControllerDesign() = default;
  // Not explicit: whoever has settings has a design.
  ControllerDesign(const ControllerSettings<double>& settings)
      : ControllerSettings<double>(settings) {}

  const double* channel_taps(int channel) const {
    return taps.data() + static_cast<std::ptrdiff_t>(channel) * (memory + 2);
  }
};

constexpr Range tap_range = between(-1e6, 1e6);

// What is wrong with settings as a whole, each being in range: memory beyond that of taps runs as
// modes, which only some orders have.
inline Finding check_consistency(const ControllerDesign& design) {
  const Finding tracking = check_tracking_law<double>(design);
  if (tracking.status != Status::ok) return tracking;
  // Free taps, and modes, stand for eq. 34 alone.
  if (design.needs_tracking_law() && (!design.taps.empty() || design.memory.is_long())) {
    return {Status::inconsistent, "net", static_cast<double>(design.net), between(0, 0)};
  }
  if (!design.memory.is_long()) return {};
  for (int channel = 0; channel < channel_count; ++channel) {
    const double alpha = design.alpha[channel];
    const double sigma = design.sigma[channel];
    if (!(std::abs(alpha) < 1)) return {Status::inconsistent, "alpha", alpha, {-1, 1, true, true}};
    if (!(std::abs(1 - sigma) < 1)) {
      return {Status::inconsistent, "sigma", sigma, {0, 2, true, true}};
    }
  }
  return {};
}

// Two sample times count as one up to this share of them: a log's stamps do not give the last
// digit.
constexpr double sample_time_tolerance = 1e-9;

// A controller that does not know its sample time fits any. One that does is another controller at
// a different sample time: its gains are those of differences and sums over samples.
inline Finding check_sample_time(const ControllerSettings<double>& settings, double dt) {
  const SampleTime<double>& own = settings.sample_time;
  if (!own.has_value() || std::abs(*own - dt) <= sample_time_tolerance * dt) return {};
  return {Status::inconsistent, "sample_time", *own, between(dt, dt)};
}

}  // namespace nfopidn
