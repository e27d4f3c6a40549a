// L4. The controller's filters with their memory laid open, for analysis: a state of few numbers.
#pragma once

#include <array>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/long_memory/modal.hpp"
#include "nfopidn/tuning/structures.hpp"

namespace nfopidn {

// The kernels of the channels x, y, theta. With `modal` a memory beyond the exact taps runs as
// modes good to 1e-6 of the weights' sum up to the memory; beyond it they go on, where a finite
// memory ends.
using StateKernels = std::array<LongKernel, channel_count>;

// Whether they can: free taps and orders beyond 1 have no modes.
NFOPIDN_HOST bool has_modes(const ControllerDesign& design);

NFOPIDN_HOST StateKernels state_kernels(const ControllerDesign& design, bool modal);

// What Fir is to a simulation: net(k) = sum_j taps[j] e(k - j), and the modes' share.
template <class Scalar>
class StateFilter {
 public:
  StateFilter() = default;
  explicit StateFilter(StateKernels kernels) : kernels_(std::move(kernels)) {
    for (std::size_t channel = 0; channel < channel_count; ++channel) {
      states_[channel].assign(state_count(kernels_[channel]), Scalar(0.0));
    }
  }

  // Numbers a channel: past errors, newest first; then the plus modes, then the minus modes.
  static std::size_t past_count(const LongKernel& kernel) {
    return kernel.taps.size() - (kernel.has_modes() ? 0 : 1);
  }
  static std::size_t state_count(const LongKernel& kernel) {
    return past_count(kernel) + static_cast<std::size_t>(kernel.plus.size()) +
           static_cast<std::size_t>(minus_count(kernel));
  }
  Scalar& state(int channel, int index) {
    return states_[static_cast<std::size_t>(channel)][static_cast<std::size_t>(index)];
  }

  void reset() {
    for (auto& channel : states_) std::fill(channel.begin(), channel.end(), Scalar(0.0));
  }

  Channels<Scalar> step(const Channels<Scalar>& error) {
    return {pass(0, error.x), pass(1, error.y), pass(2, error.theta)};
  }

 private:
  static Eigen::Index minus_count(const LongKernel& kernel) {
    return (kernel.minus != 0.0).any() ? kernel.minus.size() : 0;
  }

  Scalar pass(std::size_t channel, const Scalar& newest) {
    const LongKernel& kernel = kernels_[channel];
    std::vector<Scalar>& states = states_[channel];
    const std::size_t past = past_count(kernel);
    Scalar sum = newest * kernel.taps[0];
    for (std::size_t j = 1; j < kernel.taps.size(); ++j) {
      sum = sum + states[j - 1] * kernel.taps[j];
    }
    if (kernel.has_modes()) {
      const Scalar leaving = states[past - 1];
      auto mode = states.begin() + static_cast<std::ptrdiff_t>(past);
      for (Eigen::Index i = 0; i < kernel.plus.size(); ++i, ++mode) {
        *mode = (*mode - *mode * kernel.decays(i)) + leaving * kernel.plus(i);
        sum = sum + *mode;
      }
      for (Eigen::Index i = 0; i < minus_count(kernel); ++i, ++mode) {
        *mode = (*mode * kernel.decays(i) - *mode) + leaving * kernel.minus(i);
        sum = sum + *mode;
      }
    }
    const auto first = states.begin();
    std::move_backward(first, first + static_cast<std::ptrdiff_t>(past) - 1,
                       first + static_cast<std::ptrdiff_t>(past));
    states[0] = newest;
    return sum;
  }

  StateKernels kernels_;
  std::array<std::vector<Scalar>, channel_count> states_;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST bool has_modes(const ControllerDesign& design) {
  if (!design.taps.empty()) return false;
  for (int channel = 0; channel < channel_count; ++channel) {
    if (std::abs(design.alpha[channel]) >= 1 || std::abs(1 - design.sigma[channel]) >= 1)
      return false;
  }
  return true;
}

NFOPIDN_HOST StateKernels state_kernels(const ControllerDesign& design, bool modal) {
  StateKernels kernels;
  if (modal) {
    for (int channel = 0; channel < channel_count; ++channel) {
      kernels[static_cast<std::size_t>(channel)] =
          fused_kernel(design, channel, modes::coarse, modes::coarse.exact_taps);
    }
    return kernels;
  }
  const std::vector<double> taps = parameters_of(ParameterSet::taps, design);
  const auto count = static_cast<std::size_t>(design.memory + 2);
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    const double* first = taps.data() + channel * count;
    kernels[channel].taps.assign(first, first + count);
    kernels[channel].memory = design.memory;
  }
  return kernels;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
