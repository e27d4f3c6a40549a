// L3. A convolution with a fractional operator's weights, any number of them at constant cost: the
// newest taps exactly, the rest as modes.
#pragma once

#include <algorithm>
#include <array>

#include "nfopidn/control/controller_settings.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/long_memory/modes.hpp"
#include "nfopidn/long_memory/wide.hpp"

namespace nfopidn {

constexpr int certified_horizon = 1'000'000;  // samples over which infinite memory is certified
constexpr int short_memory = 192;             // up to here every tap is exact

// sum_k c_k u_{n-k}, k = 0 .. memory + 1.
struct LongKernel {
  std::vector<double> taps;    // c_0 .. ; all of them when `memory` is short
  int memory = 0;              // the modes' last k, or infinite_memory
  double final_tap = 0;        // c_{memory+1}, which no mode has
  Eigen::ArrayXd decays;       // of both banks
  Eigen::ArrayXd plus, minus;  // residues: what a mode gives at k = taps.size()

  bool has_modes() const { return decays.size() > 0; }
  int mode_count() const {
    return static_cast<int>((plus != 0.0).count() + (minus != 0.0).count());
  }
};

namespace detail {

NFOPIDN_HOST Eigen::ArrayXd residues(double pole, double order, modes::Sign sign, double horizon,
                                     const Eigen::ArrayXd& decays, const modes::Grid& grid);

}  // namespace detail

// ((1 - w)/(1 + pole w))^order, |order| < 1 or whole, up to w^memory; infinite memory holds up to
// `horizon`. Up to `longest_exact` every tap is exact and any order will do.
NFOPIDN_HOST LongKernel series_kernel(double pole, double order, int memory,
                                      int horizon = certified_horizon,
                                      const modes::Grid& grid = modes::fine,
                                      int longest_exact = short_memory);

// Numbers filled up with zeros to a multiple of eight.
inline Eigen::ArrayXd in_eights(const Eigen::ArrayXd& numbers) {
  Eigen::ArrayXd filled = Eigen::ArrayXd::Zero((numbers.size() + 7) / 8 * 8);
  filled.head(numbers.size()) = numbers;
  return filled;
}

// Modes of one sign: x_i <- (1 - decay_i) x_i + residue_i u, their sum out.
class ModeBank {
 public:
  ModeBank() = default;
  ModeBank(const Eigen::ArrayXd& decays, const Eigen::ArrayXd& residues)
      : modes_(static_cast<std::size_t>((decays.size() + 7) / 8)) {
    for (Eigen::Index i = 0; i < decays.size(); ++i) {
      wide::Modes& block = modes_[static_cast<std::size_t>(i / 8)];
      block.decay[i % 8] = decays(i);
      block.residue[i % 8] = residues(i);
    }
  }

  // From now on a sample ends `age` samples after it came. Modes that have died out by then need no
  // end.
  void end_after(double age) {
    ending_ = 0;
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      for (std::size_t k = 0; k < 8; ++k) {
        wide::Modes& block = modes_[i];
        const double left = std::exp(age * std::log1p(-block.decay[k]));
        block.end[k] = left > 1e-18 ? block.residue[k] * left : 0;
        if (block.end[k] != 0) ending_ = static_cast<long>(i) + 1;
      }
    }
  }

  void reset() {
    for (wide::Modes& block : modes_)
      std::fill(std::begin(block.state), std::end(block.state), 0.0);
  }

  double step(const wide::Loops& loops, double coming, double ending) {
    return loops.advance(modes_.data(), static_cast<long>(modes_.size()), ending_, coming, ending);
  }

 private:
  std::vector<wide::Modes> modes_;
  long ending_ = 0;  // blocks, from the first on: the slowest come first
};

// Runs a kernel over samples.
class LongMemory {
 public:
  LongMemory() : LongMemory(LongKernel{{1.0}, 0, 0, {}, {}, {}}) {}
  explicit LongMemory(LongKernel kernel)
      : kernel_(std::move(kernel)), plus_(kernel_.decays, kernel_.plus) {
    if ((kernel_.minus != 0.0).any()) minus_ = ModeBank(kernel_.decays, kernel_.minus);
    if (kernel_.has_modes() && kernel_.memory != infinite_memory) {
      const int age = kernel_.memory + 1 - static_cast<int>(kernel_.taps.size());
      plus_.end_after(age);
      minus_.end_after(age);
      past_.resize(static_cast<std::size_t>(age));
    }
    const std::size_t count = kernel_.taps.size();
    std::copy_n(kernel_.taps.data(), std::min(count, newest_count), newest_taps_.data());
    if (count > newest_count) {
      older_taps_ = in_eights(Eigen::Map<const Eigen::ArrayXd>(
          kernel_.taps.data() + newest_count, static_cast<Eigen::Index>(count - newest_count)));
    }
    // Twice, so that the newest samples lie in a row wherever the newest is.
    window_ = std::max(newest_count + static_cast<std::size_t>(older_taps_.size()), count + 1);
    recent_.resize(2 * window_);
    reset();
  }

  const LongKernel& kernel() const { return kernel_; }

  void reset() {
    std::fill(recent_.begin(), recent_.end(), 0.0);
    std::fill(past_.begin(), past_.end(), 0.0);
    head_ = past_head_ = 0;
    plus_.reset();
    minus_.reset();
    turn_ = 1;
  }

  double step(double sample) {
    head_ = head_ == 0 ? window_ - 1 : head_ - 1;
    recent_[head_] = recent_[head_ + window_] = sample;
    const double* recent = &recent_[head_];
    const double older = loops_->dot(older_taps_.data(), recent + newest_count,
                                     static_cast<long>(older_taps_.size()));
    const double exact = newest(recent) + older;
    return kernel_.has_modes() ? exact + tail(recent[kernel_.taps.size()]) : exact;
  }

 private:
  // One by one: a wide load of what has just been stored would have to wait for the store.
  static constexpr std::size_t newest_count = 8;

  double newest(const double* recent) const {
    const auto pair = [&](std::size_t k) {
      return newest_taps_[k] * recent[k] + newest_taps_[k + 4] * recent[k + 4];
    };
    return (pair(0) + pair(2)) + (pair(1) + pair(3));
  }

  // The modes' share: `coming` has left the exact taps.
  double tail(double coming) {
    double ending = 0;
    if (!past_.empty()) {
      ending = past_[past_head_];
      past_[past_head_] = coming;
      past_head_ = past_head_ + 1 == past_.size() ? 0 : past_head_ + 1;
    }
    // The minus modes run as plus modes of the samples times (-1)^n.
    turn_ = -turn_;
    const double ending_turn = past_.size() % 2 == 0 ? turn_ : -turn_;
    return plus_.step(*loops_, coming, ending) +
           turn_ * minus_.step(*loops_, turn_ * coming, ending_turn * ending) +
           kernel_.final_tap * ending;
  }

  const wide::Loops* loops_ = &wide::loops();
  LongKernel kernel_;
  std::array<double, newest_count> newest_taps_ = {};
  Eigen::ArrayXd older_taps_;  // the rest
  ModeBank plus_, minus_;
  std::vector<double> recent_, past_;  // as long as the exact taps, and from there to the end
  std::size_t window_ = 0, head_ = 0, past_head_ = 0;
  double turn_ = 1;  // (-1)^n
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn::detail {

NFOPIDN_HOST Eigen::ArrayXd residues(double pole, double order, modes::Sign sign, double horizon,
                                     const Eigen::ArrayXd& decays, const modes::Grid& grid) {
  const auto weights = modes::weights(pole, order, sign, horizon, decays, grid);
  const bool turned = sign == modes::Sign::minus && grid.exact_taps % 2 != 0;
  Eigen::ArrayXd result(decays.size());
  for (Eigen::Index i = 0; i < result.size(); ++i) {
    const long double kept = std::log1p(-static_cast<long double>(decays(i)));
    result(i) = static_cast<double>(weights[static_cast<std::size_t>(i)] *
                                    std::exp(grid.exact_taps * kept));
  }
  if (turned) result = -result;
  return result;
}

}  // namespace nfopidn::detail

namespace nfopidn {

NFOPIDN_HOST LongKernel series_kernel(double pole, double order, int memory, int horizon,
                                      const modes::Grid& grid, int longest_exact) {
  LongKernel kernel;
  kernel.memory = memory;
  const bool is_short = memory <= longest_exact;
  kernel.taps.resize(static_cast<std::size_t>(is_short ? memory + 1 : grid.exact_taps));
  series_weights(pole, order, static_cast<int>(kernel.taps.size()) - 1, kernel.taps.data());
  if (is_short) return kernel;
  const double reach = std::min(memory, horizon);
  kernel.decays = modes::decays(reach, grid);
  kernel.plus = detail::residues(pole, order, modes::Sign::plus, reach, kernel.decays, grid);
  kernel.minus = detail::residues(pole, order, modes::Sign::minus, reach, kernel.decays, grid);
  return kernel;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
