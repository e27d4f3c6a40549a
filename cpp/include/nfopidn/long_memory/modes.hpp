// L3. The tail of a fractional operator's impulse response as decaying modes of both signs.
//
// For ((1 - w)/(1 + p w))^a with |a| < 1, Cauchy's integral pulled onto the cuts w > 1 and, for
// p = 1, w < -1 gives for k >= 1
//   c_k = sin(pi a)/pi [ (-1)^k int coth(s/2)^a e^{-ks} ds - int ((e^s - 1)/(1 + p e^s))^a e^{-ks}
//   ds ]
// over s > 0; for p < 1 the other cut's share falls as p^k and is nothing after the exact taps.
// In t = log s the integrands are analytic in a strip, so that the trapezoidal rule converges
// exponentially: a lattice of rates s_i, the same for every order. The rates below 1/horizon, of
// which there are infinitely many, act over the horizon as polynomials; Gauss points hold their
// place, with the weights that integrate those polynomials alike.
#pragma once

#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <vector>

#include "nfopidn/foundation/host.hpp"

namespace nfopidn::modes {

struct Grid {
  int exact_taps;  // before the modes begin
  double spacing;  // of log s
  double depth;    // e^-depth is nothing
  int slow_count;  // Gauss points below 1/horizon
};
// Leaves 2e-13 of the sum of the weights; the newest tap, and four blocks of eight.
constexpr Grid fine = {33, 0.33, 34.5, 12};
// Leaves 1e-6 with a quarter of the states.
constexpr Grid coarse = {9, 0.71, 16, 6};

// Points of Gauss and Legendre on [0, 1].
NFOPIDN_HOST Eigen::ArrayXd gauss_points(int count);

// The decays 1 - e^{-s} of the modes that hold up to `horizon` samples, slowest first.
NFOPIDN_HOST Eigen::ArrayXd decays(double horizon, const Grid& grid);

// Which cut: the modes e^{-ks}, or (-1)^k e^{-ks}.
enum class Sign { plus, minus };

namespace detail {

using Long = long double;
using Longs = std::vector<Long>;

// The integrand's factor of e^{-ks} ds.
inline Long density(double pole, Long order, Sign sign, Long rate) {
  const Long grown = std::exp(rate);
  const Long base = sign == Sign::plus ? std::expm1(rate) / (1 + Long(pole) * grown)
                                       : (1 + grown) / std::expm1(rate);
  const Long share = std::sin(Long(EIGEN_PI) * order) / Long(EIGEN_PI);
  return (sign == Sign::plus ? -share : share) * std::pow(base, order);
}

// Lagrange's polynomial j through the first `count` points, at x.
inline Long lagrange(const Longs& points, int count, int j, Long x) {
  Long product = 1;
  for (int m = 0; m < count; ++m) {
    const auto i = static_cast<std::size_t>(m);
    if (m != j) product *= (x - points[i]) / (points[static_cast<std::size_t>(j)] - points[i]);
  }
  return product;
}

}  // namespace detail

// The modes' weights: c_k = sum_i weights_i (1 - decays_i)^k, with (-1)^k for the minus sign, for
// grid.exact_taps <= k <= horizon. Null for the minus sign of a pole below 1 and for whole orders.
NFOPIDN_HOST std::vector<long double> weights(double pole, double order, Sign sign, double horizon,
                                              const Eigen::ArrayXd& decays, const Grid& grid);

}  // namespace nfopidn::modes

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn::modes {

NFOPIDN_HOST std::vector<long double> weights(double pole, double order, Sign sign, double horizon,
                                              const Eigen::ArrayXd& decays, const Grid& grid) {
  using detail::Long;
  detail::Longs result(static_cast<std::size_t>(decays.size()), 0);
  if (order == 0 || (sign == Sign::minus && pole < 1)) return result;
  detail::Longs rates;
  for (const double decay : decays) rates.push_back(-std::log1p(-Long(decay)));
  const auto node = [&](Long rate) {
    return detail::density(pole, order, sign, rate) * rate * Long(grid.spacing);
  };
  for (auto i = static_cast<std::size_t>(grid.slow_count); i < rates.size(); ++i)
    result[i] = node(rates[i]);
  // The lattice below the slowest: one by one while the polynomials vary, the rest by its ratio.
  const Long slow = 1 / Long(horizon);
  const Long power = 1 + (sign == Sign::plus ? Long(order) : -Long(order));
  const Long beyond = -std::expm1(-Long(grid.spacing) * power);  // 1 - ratio
  for (Long place = -0.5L;; place -= 1) {
    const Long rate = slow * std::exp(Long(grid.spacing) * place);
    const bool last = rate < slow * 1e-19L;
    const Long weight = last ? node(rate) / beyond : node(rate);
    for (int j = 0; j < grid.slow_count; ++j) {
      result[static_cast<std::size_t>(j)] +=
          weight * detail::lagrange(rates, grid.slow_count, j, rate);
    }
    if (last) return result;
  }
}

NFOPIDN_HOST Eigen::ArrayXd decays(double horizon, const Grid& grid) {
  const double slow = 1 / horizon;
  const double fastest = grid.depth / grid.exact_taps;
  const int lattice =
      std::max(0, static_cast<int>(std::lround(std::log(fastest / slow) / grid.spacing)));
  Eigen::ArrayXd rates(grid.slow_count + lattice);
  rates.head(grid.slow_count) = gauss_points(grid.slow_count) * slow;
  for (int i = 0; i < lattice; ++i)
    rates(grid.slow_count + i) = slow * std::exp(grid.spacing * (i + 0.5));
  return -(-rates).unaryExpr([](double rate) { return std::expm1(rate); });
}

NFOPIDN_HOST Eigen::ArrayXd gauss_points(int count) {
  Eigen::VectorXd next(count - 1);
  for (int k = 1; k < count; ++k) next(k - 1) = k / std::sqrt(4.0 * k * k - 1);
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(Eigen::VectorXd::Zero(count), next, Eigen::EigenvaluesOnly);
  return (solver.eigenvalues().array() + 1) / 2;
}

}  // namespace nfopidn::modes

#endif  // NFOPIDN_DEFINES_SIMULATION
