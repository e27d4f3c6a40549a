// L4. s^order of a sampled signal, sample by sample.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/long_memory/long_memory.hpp"

namespace nfopidn {

// s -> scale (1 - w)/(1 + pole w), w = z^-1: pole 1 is Tustin's rule, 0 backward differences
// (Gruenwald and Letnikov), 1/7 Al-Alaoui's.
struct DifferenceRule {
  double pole = 1;
  double dt = 1;       // [s]
  double prewarp = 0;  // [rad/s]; 0: exact at standstill, else the magnitude is exact here

  double scale() const {
    if (prewarp == 0) return (1 + pole) / dt;
    const double half = prewarp * dt / 2;
    // |1 - w| = 2 sin(half), |1 + pole w|^2 = (1 - pole)^2 + 4 pole cos^2(half) at the frequency.
    const double below = std::hypot(1 - pole, 2 * std::sqrt(pole) * std::cos(half));
    return prewarp * below / (2 * std::sin(half));
  }
};

// An order as a whole number -1, 0 or 1 and a rest under 1 in size.
struct SplitOrder {
  int whole;
  double rest;
  explicit SplitOrder(double order)
      : whole(order >= 1    ? 1
              : order <= -1 ? -1
                            : 0),
        rest(order - whole) {}
};

// scale^order ((1 - w)/(1 + pole w))^order: the whole factor as a recursion, whose pole is at z =
// -pole or at z = 1; the rest as a series up to w^memory.
//
// A finite memory is good to its end, whatever the horizon; an infinite one to the horizon.
class FractionalFilter {
 public:
  FractionalFilter(double order, const DifferenceRule& rule, int memory,
                   int horizon = certified_horizon);

  // A sample in, a sample out; both must be finite numbers, or the filter remembers it.
  double step(double sample) { return gain_ * whole(series_.step(sample)); }

  // The same for `count` samples in a row.
  void process(const double* samples, double* outputs, std::ptrdiff_t count);

  void reset() {
    series_.reset();
    last_in_ = last_out_ = 0;
  }

  double gain() const { return gain_; }
  const LongKernel& kernel() const { return series_.kernel(); }
  const SplitOrder& order() const { return order_; }

  // sum |c_k - kernel_k| / sum |c_k| of the series, k up to memory or horizon, summed in long
  // double with the decays and residues as they are stored.
  double certificate() const;

 private:
  double whole(double sample) {
    if (order_.whole == 0) return sample;
    const double out = order_.whole > 0 ? sample - last_in_ - rule_.pole * last_out_
                                        : sample + rule_.pole * last_in_ + last_out_;
    last_in_ = sample;
    return last_out_ = out;
  }

  SplitOrder order_;
  DifferenceRule rule_;
  int horizon_;
  double gain_;
  LongMemory series_;
  double last_in_ = 0, last_out_ = 0;
};

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST FractionalFilter::FractionalFilter(double order, const DifferenceRule& rule,
                                                int memory, int horizon)
    : order_(order),
      rule_(rule),
      horizon_(memory == infinite_memory ? horizon : memory),
      gain_(std::pow(rule.scale(), order)),
      series_(series_kernel(rule.pole, order_.rest, order_.rest == 0 ? 0 : memory, horizon_)) {}

NFOPIDN_HOST void FractionalFilter::process(const double* samples, double* outputs,
                                            std::ptrdiff_t count) {
  for (std::ptrdiff_t i = 0; i < count; ++i) outputs[i] = step(samples[i]);
}

NFOPIDN_HOST double FractionalFilter::certificate() const {
  using Long = long double;
  const LongKernel& kernel = series_.kernel();
  if (!kernel.has_modes()) return 0;
  auto count = static_cast<std::size_t>(kernel.decays.size());
  std::vector<Long> kept(count), plus(count), minus(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<Eigen::Index>(i);
    kept[i] = 1 - Long(kernel.decays(at));
    plus[i] = kernel.plus(at);
    minus[i] = kernel.minus(at);
  }
  const int exact = static_cast<int>(kernel.taps.size());
  Long before = 0, last = 1, error = 0, total = 1;
  for (int k = 1; k <= horizon_; ++k) {
    const Long c = next_series_weight(Long(rule_.pole), Long(order_.rest), k, last, before);
    before = last;
    last = c;
    total += std::abs(c);
    if (k < exact) continue;
    Long sum = 0, alternating = 0;
    for (std::size_t i = 0; i < count; ++i) {
      sum += plus[i];
      alternating += minus[i];
      plus[i] *= kept[i];
      minus[i] *= kept[i];
    }
    // The fastest modes are the last; once nothing is left of one it only costs time.
    while (count > 0 && std::abs(plus[count - 1]) + std::abs(minus[count - 1]) < 1e-40L) --count;
    error += std::abs(c - ((k - exact) % 2 == 0 ? sum + alternating : sum - alternating));
  }
  return static_cast<double>(error / total);
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
