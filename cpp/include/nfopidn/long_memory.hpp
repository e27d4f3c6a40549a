// L3. A convolution with a fractional operator's weights, any number of them at constant cost: the
// newest taps exactly, the rest as modes.
#pragma once

#include <algorithm>

#include "nfopidn/controller_settings.hpp"
#include "nfopidn/modes.hpp"

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

inline Eigen::ArrayXd residues(double pole, double order, modes::Sign sign, double horizon,
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

}  // namespace detail

// ((1 - w)/(1 + pole w))^order, |order| < 1 or whole, up to w^memory; infinite memory holds up to
// `horizon`. Up to `longest_exact` every tap is exact and any order will do.
inline LongKernel series_kernel(double pole, double order, int memory,
                                int horizon = certified_horizon,
                                const modes::Grid& grid = modes::fine,
                                int longest_exact = short_memory) {
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

// Numbers in blocks of eight, the last one filled up with zeros. Sums run over eight columns side
// by side, in the same order on every machine.
class Blocks {
 public:
  using Eight = Eigen::Array<double, 8, 1>;

  Blocks() = default;
  explicit Blocks(Eigen::Index count) : numbers_(Eigen::ArrayXd::Zero((count + 7) / 8 * 8)) {}
  explicit Blocks(const Eigen::ArrayXd& numbers) : Blocks(numbers.size()) {
    numbers_.head(numbers.size()) = numbers;
  }
  Eigen::Index size() const { return numbers_.size(); }
  void clear() { numbers_.setZero(); }
  using Block = Eigen::Map<Eight, Eigen::Aligned16>;
  using ConstBlock = Eigen::Map<const Eight, Eigen::Aligned16>;
  const Eigen::ArrayXd& numbers() const { return numbers_; }
  double* data() { return numbers_.data(); }
  const double* data() const { return numbers_.data(); }
  double dot(const double* others) const {
    Eight sum = Eight::Zero();
    const double* own = numbers_.data();
    for (Eigen::Index i = 0; i < numbers_.size(); i += 8) {
      sum += ConstBlock(own + i) * Eigen::Map<const Eight>(others + i);
    }
    return sum.sum();
  }

 private:
  Eigen::ArrayXd numbers_;
};

// Modes of one sign: x_i <- (1 - decay_i) x_i + residue_i u, their sum out. As x - decay x: the
// slowest 1 - decay could not be told from 1.
class ModeBank {
 public:
  ModeBank() = default;
  ModeBank(const Eigen::ArrayXd& decays, const Eigen::ArrayXd& residues)
      : decays_(decays), residues_(residues), states_(decays.size()) {}

  // From now on a sample ends `age` samples after it came. Modes that have died out by then need no
  // end.
  void end_after(double age) {
    const Eigen::ArrayXd left = decays_.numbers().unaryExpr(
        [=](double decay) { return std::exp(age * std::log1p(-decay)); });
    ends_ = Blocks((residues_.numbers() * left).head((left > 1e-18).count()).eval());
  }

  void reset() { states_.clear(); }

  double step(double coming, double ending) {
    Blocks::Eight sum = Blocks::Eight::Zero();
    const double* decays = decays_.data();
    const double* residues = residues_.data();
    const double* ends = ends_.data();
    double* states = states_.data();
    const Eigen::Index count = states_.size();
    const Eigen::Index ending_count = std::min(ends_.size(), count);
    const auto advance = [&](Eigen::Index i, const Blocks::Eight& input) {
      const Blocks::Eight before = Blocks::ConstBlock(states + i);
      const Blocks::Eight now = (input - Blocks::ConstBlock(decays + i) * before) + before;
      Blocks::Block(states + i) = now;
      sum += now;
    };
    Eigen::Index i = 0;
    for (; i < ending_count; i += 8) {
      advance(i, Blocks::ConstBlock(residues + i) * coming - Blocks::ConstBlock(ends + i) * ending);
    }
    for (; i < count; i += 8) advance(i, Blocks::ConstBlock(residues + i) * coming);
    return sum.sum();
  }

 private:
  Blocks decays_, residues_, ends_, states_;
};

// Runs a kernel over samples.
class LongMemory {
 public:
  LongMemory() : LongMemory(LongKernel{{1.0}, 0, 0, {}, {}, {}}) {}
  explicit LongMemory(LongKernel kernel)
      : kernel_(std::move(kernel)),
        older_taps_(Eigen::Map<const Eigen::ArrayXd>(
            kernel_.taps.data() + 1, static_cast<Eigen::Index>(kernel_.taps.size()) - 1)),
        plus_(kernel_.decays, kernel_.plus) {
    if ((kernel_.minus != 0.0).any()) minus_ = ModeBank(kernel_.decays, kernel_.minus);
    if (kernel_.has_modes() && kernel_.memory != infinite_memory) {
      const int age = kernel_.memory + 1 - static_cast<int>(kernel_.taps.size());
      plus_.end_after(age);
      minus_.end_after(age);
      past_.resize(static_cast<std::size_t>(age));
    }
    // Twice, so that the newest samples lie in a row wherever the newest is.
    const std::size_t padded = static_cast<std::size_t>(older_taps_.size()) + 1;
    recent_.resize(2 * std::max(kernel_.taps.size(), padded));
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
    const std::size_t count = recent_.size() / 2;
    head_ = head_ == 0 ? count - 1 : head_ - 1;
    const double leaving = recent_[head_];
    recent_[head_] = recent_[head_ + count] = sample;
    // The newest by itself: read back within a block it would have to wait for its own store.
    const double exact = kernel_.taps[0] * sample + older_taps_.dot(&recent_[head_ + 1]);
    return kernel_.has_modes() ? exact + tail(leaving) : exact;
  }

 private:
  // The modes' share: `leaving` has left the exact taps.
  double tail(double leaving) {
    double ending = 0;
    if (!past_.empty()) {
      ending = past_[past_head_];
      past_[past_head_] = leaving;
      past_head_ = past_head_ + 1 == past_.size() ? 0 : past_head_ + 1;
    }
    // The minus modes run as plus modes of the samples times (-1)^n.
    turn_ = -turn_;
    const double ending_turn = past_.size() % 2 == 0 ? turn_ : -turn_;
    return plus_.step(leaving, ending) +
           turn_ * minus_.step(turn_ * leaving, ending_turn * ending) + kernel_.final_tap * ending;
  }

  LongKernel kernel_;
  Blocks older_taps_;  // from c_1 on
  ModeBank plus_, minus_;
  std::vector<double> recent_, past_;  // as long as the exact taps, and from there to the end
  std::size_t head_ = 0, past_head_ = 0;
  double turn_ = 1;  // (-1)^n
};

}  // namespace nfopidn
