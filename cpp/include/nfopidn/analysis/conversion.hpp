// L4. Continuous gains and discrete ones (eq. 25).
#pragma once

#include <array>

#include "nfopidn/analysis/fractional_filter.hpp"
#include "nfopidn/foundation/host.hpp"

namespace nfopidn {

constexpr double paper_prewarp = 15;  // w_c [rad/s]

// A channel's discrete kp, ki, kd over its continuous Kp, Ki, Kd:
//   kp = Kp, ki = Ki scale^-sigma, kd = Kd scale^alpha
// `prewarp` [rad/s] is not used with Generator::gl.
NFOPIDN_HOST std::array<double, 3> gain_factors(Generator generator, double alpha, double sigma,
                                                double dt, double prewarp = paper_prewarp);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST std::array<double, 3> gain_factors(Generator generator, double alpha, double sigma,
                                                double dt, double prewarp) {
  const bool tustin = generator == Generator::tustin;
  const double scale = DifferenceRule{pole_of<double>(generator), dt, tustin ? prewarp : 0}.scale();
  return {1, std::pow(scale, -sigma), std::pow(scale, alpha)};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
