// L3. A controller on the host: settings, and taps where those are free instead of fused from gains
// and orders.
#pragma once

#include <vector>

#include "nfopidn/controller_settings.hpp"

namespace nfopidn {

struct ControllerDesign : ControllerSettings<double> {
  // [3][memory + 2], newest first, as fuse_taps() makes them; empty: those of gains and orders.
  std::vector<double> taps;

  ControllerDesign() = default;
  // Not explicit: whoever has settings has a design.
  ControllerDesign(const ControllerSettings<double>& settings)
      : ControllerSettings<double>(settings) {}

  const double* channel_taps(int channel) const {
    return taps.data() + static_cast<std::ptrdiff_t>(channel) * (memory + 2);
  }
};

constexpr Range tap_range = between(-1e6, 1e6);

}  // namespace nfopidn
