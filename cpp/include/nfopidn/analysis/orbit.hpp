// L4. The periodic orbit of a loop on its reference, stable or not, by Newton's method.
#pragma once

#include "nfopidn/analysis/step_map.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/math/dual.hpp"

namespace nfopidn {

enum class OrbitStart : unsigned char { reference, simulation };
template <>
struct ChoiceNames<OrbitStart> {
  static constexpr const char* names[] = {"reference", "simulation"};
};

struct Orbit {
  Eigen::MatrixXd states;  // a column a sample of the period
  bool found = false;
  double residual = 0;                       // largest miss of a step, in the states' units
  int iterations = 0;                        // of Newton's method, from the last start
  OrbitStart start = OrbitStart::reference;  // from where it was found, or looked for last
};

// d(state at k + 1)/d(state at k), by dual numbers, one direction at a time.
NFOPIDN_HOST void step_jacobian(StepMap<Dual<double>>& map, int k, const double* state,
                                Eigen::MatrixXd& jacobian);

// Looked for from the reference and, where that fails, from a long simulation.
NFOPIDN_HOST Orbit find_orbit(StepMap<double>& map, StepMap<Dual<double>>& dual,
                              const PeriodicReference& reference, double divergence_distance);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

#include <Eigen/SparseLU>

namespace nfopidn {

namespace detail {

constexpr int newton_iterations = 60;
constexpr double least_damping = 1e-4;
constexpr double orbit_tolerance = 1e-10;
constexpr int settling_periods = 40;
constexpr int settling_samples = 20000;

// Whether to leave a loop over samples: asked at one of many.
inline bool stops_at(int k) { return k % 64 == 63 && Interruption::stops_here(); }

// What each step of the period misses the next state by, and the largest: infinity when
// interrupted.
inline double misses(StepMap<double>& map, const Eigen::MatrixXd& states, Eigen::MatrixXd& miss) {
  miss.resize(states.rows(), states.cols());
  for (int k = 0; k < map.period(); ++k) {
    if (stops_at(k)) return std::numeric_limits<double>::infinity();
    map.advance(k, states.col(k).data(), miss.col(k).data());
    miss.col(k) -= states.col((k + 1) % map.period());
    // Headings that are a turn apart are the same.
    miss(2, k) = math<double>::wrap(miss(2, k));
  }
  return miss.allFinite() ? miss.cwiseAbs().maxCoeff() : std::numeric_limits<double>::infinity();
}

}  // namespace detail

NFOPIDN_HOST void step_jacobian(StepMap<Dual<double>>& map, int k, const double* state,
                                Eigen::MatrixXd& jacobian) {
  const auto size = static_cast<std::size_t>(map.size());
  std::vector<Dual<double>> from(size);
  std::vector<Dual<double>> to(size);
  jacobian.resize(map.size(), map.size());
  for (std::size_t i = 0; i < size; ++i) from[i] = {state[i], 0};
  for (std::size_t direction = 0; direction < size; ++direction) {
    from[direction].slope = 1;
    map.advance(k, from.data(), to.data());
    from[direction].slope = 0;
    for (std::size_t i = 0; i < size; ++i) {
      jacobian(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(direction)) = to[i].slope;
    }
  }
}

namespace detail {

// The linearised period, x(k+1) - A(k) x(k) = miss(k). Every sample is an unknown, since the
// product of an unstable loop's Jacobians would lose all digits.
class PeriodSystem {
 public:
  bool factorise(StepMap<Dual<double>>& map, const Eigen::MatrixXd& states) {
    const Eigen::Index size = states.rows();
    const Eigen::Index period = states.cols();
    std::vector<Eigen::Triplet<double>> entries;
    Eigen::MatrixXd jacobian;
    for (Eigen::Index k = 0; k < period; ++k) {
      step_jacobian(map, static_cast<int>(k), states.col(k).data(), jacobian);
      if (!jacobian.allFinite() || Interruption::stops_here()) return false;
      const Eigen::Index next = (k + 1) % period;
      for (Eigen::Index i = 0; i < size; ++i) {
        entries.emplace_back(k * size + i, next * size + i, 1.0);
        for (Eigen::Index j = 0; j < size; ++j) {
          if (jacobian(i, j) == 0) continue;
          entries.emplace_back(k * size + i, k * size + j, -jacobian(i, j));
        }
      }
    }
    Eigen::SparseMatrix<double> matrix(size * period, size * period);
    matrix.setFromTriplets(entries.begin(), entries.end());
    solver_.compute(matrix);
    return solver_.info() == Eigen::Success;
  }

  Eigen::MatrixXd solve(const Eigen::MatrixXd& miss) const {
    const Eigen::VectorXd x =
        solver_.solve(Eigen::Map<const Eigen::VectorXd>(miss.data(), miss.size()));
    return Eigen::Map<const Eigen::MatrixXd>(x.data(), miss.rows(), miss.cols());
  }

 private:
  Eigen::SparseLU<Eigen::SparseMatrix<double>> solver_;
};

// When a damped step is taken. `shorter`: the next step, were the Jacobian still the same, is
// shorter; the misses may grow on the way, as they must where the error is weakly observed.
// `either`: that, or the misses are smaller. Each finds orbits that the other does not.
enum class Acceptance : unsigned char { shorter, either };

// Until every step of the period hits. Changes orbit.states in any case.
inline bool newton(StepMap<double>& map, StepMap<Dual<double>>& dual, Acceptance acceptance,
                   Orbit& orbit) {
  Eigen::MatrixXd miss;
  Eigen::MatrixXd trial_miss;
  double damping = 1;
  orbit.residual = misses(map, orbit.states, miss);
  for (orbit.iterations = 0; orbit.iterations < newton_iterations; ++orbit.iterations) {
    if (orbit.residual <= orbit_tolerance) return true;
    PeriodSystem system;
    if (!system.factorise(dual, orbit.states)) return false;
    const Eigen::MatrixXd step = system.solve(miss);
    if (!step.allFinite()) return false;
    for (damping = std::min(1.0, 4 * damping);; damping /= 2) {
      if (damping < least_damping) return false;
      const Eigen::MatrixXd trial = orbit.states + damping * step;
      const double residual = misses(map, trial, trial_miss);
      if (!std::isfinite(residual)) continue;
      const double less = 1 - damping / 4;
      const bool smaller = trial_miss.norm() < less * miss.norm();
      if (residual > orbit_tolerance && !(acceptance == Acceptance::either && smaller) &&
          !(system.solve(trial_miss).norm() < less * step.norm())) {
        continue;
      }
      orbit.states = trial;
      orbit.residual = residual;
      miss = trial_miss;
      break;
    }
  }
  return orbit.residual <= orbit_tolerance;
}

// On the reference, at its speed, with its torques on their way.
inline Eigen::MatrixXd reference_states(const LoopStates& states,
                                        const PeriodicReference& reference) {
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(states.size(), reference.period);
  for (int k = 0; k < reference.period; ++k) {
    const auto sample = [&](int back) {
      const int at = ((k - back) % reference.period + reference.period) % reference.period;
      return reference.samples[static_cast<std::size_t>(at)];
    };
    result(LoopStates::velocity, k) = sample(0).v;
    result(LoopStates::velocity + 1, k) = sample(0).omega;
    if (states.tracks) {  // the last pose is as far behind as the next sample is ahead
      const ReferenceSample<double>& now = reference.samples[static_cast<std::size_t>(k)];
      const ReferenceSample<double>& next = (&now)[1];
      const Channels<double> ahead =
          rotate_into_robot(Channels<double>{next.x - now.x, next.y - now.y,
                                             math<double>::wrap(next.theta - now.theta)},
                            math<double>::heading(now.theta));
      result(states.tracking(), k) = ahead.x;
      result(states.tracking() + 1, k) = ahead.y;
      result(states.tracking() + 2, k) = ahead.theta;
    }
    for (int i = 0; i < states.delay; ++i) {
      result(states.line() + 2 * i, k) = sample(states.delay - i).tau_left;
      result(states.line() + 2 * i + 1, k) = sample(states.delay - i).tau_right;
    }
  }
  return result;
}

// The last of many periods that start on the reference; false when they diverge, or are
// interrupted.
inline bool settle(StepMap<double>& map, double divergence_distance, Eigen::MatrixXd& states) {
  const int period = map.period();
  const int periods = std::max(settling_periods, settling_samples / period);
  Eigen::VectorXd next(states.rows());
  for (int i = 0; i < periods; ++i) {
    for (int k = 0; k < period; ++k) {
      if (stops_at(i * period + k)) return false;
      map.advance(k, states.col(k).data(), next.data());
      if (!(std::hypot(next(0), next(1)) <= divergence_distance) || !next.allFinite()) return false;
      states.col((k + 1) % period) = next;
    }
  }
  return true;
}

}  // namespace detail

NFOPIDN_HOST Orbit find_orbit(StepMap<double>& map, StepMap<Dual<double>>& dual,
                              const PeriodicReference& reference, double divergence_distance) {
  const Eigen::MatrixXd start = detail::reference_states(map.states(), reference);
  Orbit orbit;
  for (const auto acceptance : {detail::Acceptance::shorter, detail::Acceptance::either}) {
    orbit.states = start;
    orbit.found = detail::newton(map, dual, acceptance, orbit);
    if (orbit.found) return orbit;
  }
  Orbit settled;
  settled.states = start;
  settled.start = OrbitStart::simulation;
  if (!detail::settle(map, divergence_distance, settled.states)) return orbit;
  settled.found = detail::newton(map, dual, detail::Acceptance::either, settled);
  return settled;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
