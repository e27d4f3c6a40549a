// L3. The controller's three channels with long memory: what Fir is to a short one.
#pragma once

#include <array>

#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/long_memory/long_memory.hpp"

namespace nfopidn {

// The fused taps of fuse_taps() as a kernel, of gains kp, ki, kd and orders |alpha| < 1,
// 0 < sigma < 2. Both operators have the same modes, so that their residues add up: a factor 1 - w
// turns a plus mode's residue r into r (1 - e^s), 1 + w into r (1 + e^s), and the other way round
// for the minus modes.
NFOPIDN_HOST LongKernel fused_kernel(const ControllerSettings<double>& settings, int channel,
                                     const modes::Grid& grid = modes::fine,
                                     int longest_exact = short_memory);

class Modal {
 public:
  Modal() = default;
  explicit Modal(const ControllerSettings<double>& settings) {
    for (int channel = 0; channel < channel_count; ++channel) {
      channels_[static_cast<std::size_t>(channel)] = LongMemory(fused_kernel(settings, channel));
    }
  }

  void reset() {
    for (LongMemory& channel : channels_) channel.reset();
  }
  Channels<double> step(const Channels<double>& error) {
    return {channels_[0].step(error.x), channels_[1].step(error.y), channels_[2].step(error.theta)};
  }

 private:
  std::array<LongMemory, channel_count> channels_;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST LongKernel fused_kernel(const ControllerSettings<double>& settings, int channel,
                                     const modes::Grid& grid, int longest_exact) {
  const auto& [kp, ki, kd] = settings.gains[channel];
  const double alpha = settings.alpha[channel];
  const double integral = 1 - settings.sigma[channel];
  const bool tustin = settings.generator == Generator::tustin;
  const auto series = [&](double order) {
    return series_kernel(pole_of<double>(settings.generator), order, settings.memory,
                         certified_horizon, grid, longest_exact);
  };
  const LongKernel derivative = series(alpha);
  const LongKernel sum = series(integral);
  LongKernel kernel = derivative;
  // One tap more, which is then left out: it alone knows that the sums end.
  const int count = static_cast<int>(kernel.taps.size());
  std::vector<double> taps(static_cast<std::size_t>(count) + 1), work(taps.size());
  fuse_taps(settings.generator, kp, ki, kd, alpha, settings.sigma[channel], count - 1, taps.data(),
            work.data());
  taps.pop_back();
  kernel.taps = taps;
  const Eigen::ArrayXd back = 1 / (1 - kernel.decays);  // e^s
  const Eigen::ArrayXd rise = kernel.decays * back;     // e^s - 1, without loss
  const Eigen::ArrayXd both = 1 + back;
  const double twice = tustin ? ki : 0;
  kernel.plus = -kd * rise * derivative.plus + twice * both * sum.plus;
  kernel.minus = kd * both * derivative.minus - twice * rise * sum.minus;
  if (!tustin) {
    kernel.plus += ki * sum.plus;
    kernel.minus += ki * sum.minus;
  }
  if (!settings.memory.is_infinite()) {
    std::vector<double> weights(static_cast<std::size_t>(settings.memory) + 1);
    generator_weights(settings.generator, alpha, settings.memory, weights.data());
    kernel.final_tap = -kd * weights.back();
    generator_weights(settings.generator, integral, settings.memory, weights.data());
    kernel.final_tap += twice * weights.back();
  }
  return kernel;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
