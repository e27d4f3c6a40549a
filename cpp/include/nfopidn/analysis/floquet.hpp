// L4. The stability of a loop's orbit: Floquet multipliers, and how near its switches it passes.
#pragma once

#include "nfopidn/analysis/orbit.hpp"
#include "nfopidn/foundation/host.hpp"

namespace nfopidn {

enum class Verdict : unsigned char { stable, unstable, marginal, no_orbit };
template <>
struct ChoiceNames<Verdict> {
  static constexpr const char* names[] = {"stable", "unstable", "marginal", "no_orbit"};
};

// How near the spectral radius of a period may be to 1 before nothing is said.
constexpr double marginal_width = 1e-6;

// The smallest distance of the orbit to where the map has a corner, and the sample there.
struct SwitchDistance {
  double distance = std::numeric_limits<double>::infinity();
  int sample = 0;

  void meet(double other, int at) {
    // The first of those that only rounding tells apart, as on a path of several like arcs.
    if (!(other < distance - 1e-9)) return;
    distance = other;
    sample = at;
  }
};

struct Switches {
  SwitchDistance heading_wrap;  // pi - |heading error| [rad]
  SwitchDistance torque_left;   // | limit - |total torque before the limit| | [N m]
  SwitchDistance torque_right;
  int limited_samples = 0;  // at which a wheel is at its limit
};

struct LoopStability {
  PeriodicReference reference;
  LoopStates states = {};
  Orbit orbit;
  Eigen::VectorXcd multipliers;  // of a period, largest first
  double log_radius = 0;         // natural logarithm of the largest one's modulus
  Switches switches;
  Verdict verdict = Verdict::no_orbit;
};

// Scenario and design must be valid. On a fault, which is the reference's or the loop's, returns
// what it is. Noise is left out. When an Interruption has happened, what is found means nothing.
NFOPIDN_HOST Outcome analyse_loop(const Scenario& scenario, const ControllerDesign& design,
                                  LoopStability& result);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

#include <Eigen/Eigenvalues>

namespace nfopidn {

namespace detail {

// The product of the Jacobians around the period, divided by exp(log_scale).
inline Eigen::MatrixXd monodromy(StepMap<Dual<double>>& map, const Eigen::MatrixXd& states,
                                 double& log_scale) {
  Eigen::MatrixXd product = Eigen::MatrixXd::Identity(states.rows(), states.rows());
  Eigen::MatrixXd jacobian;
  log_scale = 0;
  for (int k = 0; k < map.period(); ++k) {
    step_jacobian(map, k, states.col(k).data(), jacobian);
    product = jacobian * product;
    const double size = product.cwiseAbs().maxCoeff();
    if (!(size > 0) || Interruption::stops_here()) break;
    // A power of two, so that scaling rounds nothing.
    int exponent = 0;
    std::frexp(size, &exponent);
    product *= std::ldexp(1.0, -exponent);
    log_scale += exponent * std::log(2.0);
  }
  return product;
}

inline void find_multipliers(StepMap<Dual<double>>& map, LoopStability& result) {
  double log_scale = 0;
  const Eigen::MatrixXd product = monodromy(map, result.orbit.states, log_scale);
  Eigen::VectorXcd values = product.eigenvalues();
  std::sort(values.data(), values.data() + values.size(),
            [](const auto& a, const auto& b) { return std::abs(a) > std::abs(b); });
  result.log_radius = std::log(std::abs(values(0))) + log_scale;
  // Of logarithms, since the scale alone may lie beyond every double.
  for (auto& value : values) {
    const double size = std::abs(value);
    if (size > 0) value = std::exp(std::log(size) + log_scale) * (value / size);
  }
  result.multipliers = values;
}

inline Switches find_switches(StepMap<double>& map, const Eigen::MatrixXd& states, double limit) {
  Switches result;
  Eigen::VectorXd next(states.rows());
  for (int k = 0; k < map.period(); ++k) {
    const TorquePair<double> torque = map.advance(k, states.col(k).data(), next.data());
    const double left = std::fabs(torque.left);
    const double right = std::fabs(torque.right);
    result.heading_wrap.meet(math<double>::pi - std::fabs(states(2, k)), k);
    result.torque_left.meet(std::fabs(limit - left), k);
    result.torque_right.meet(std::fabs(limit - right), k);
    result.limited_samples += left > limit || right > limit ? 1 : 0;
  }
  return result;
}

}  // namespace detail

NFOPIDN_HOST Outcome analyse_loop(const Scenario& scenario, const ControllerDesign& design,
                                  LoopStability& result) {
  const StandardArithmetic arithmetic;
  if (Outcome outcome = check_loop(scenario, design); !outcome) return outcome;
  result = {};
  const Outcome outcome = find_period(scenario, design.frame == Frame::world, result.reference);
  if (!outcome) return outcome;
  const PreparedRun run = prepare(scenario);
  StepMap<double> map(run, design, result.reference);
  StepMap<Dual<double>> dual(run, design, result.reference);
  result.states = map.states();
  result.orbit = find_orbit(map, dual, result.reference, scenario.divergence_distance);
  if (!result.orbit.found) return {};
  detail::find_multipliers(dual, result);
  result.switches = detail::find_switches(map, result.orbit.states, scenario.torque_limit);
  const double distance = std::expm1(result.log_radius);
  const bool marginal = std::fabs(distance) <= marginal_width;
  result.verdict =
      marginal ? Verdict::marginal : (distance < 0 ? Verdict::stable : Verdict::unstable);
  return {};
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
