// L4. s^order as a rational function of z: zeros, poles and a gain.
#pragma once

#include "nfopidn/analysis/fractional_filter.hpp"
#include "nfopidn/foundation/host.hpp"

namespace nfopidn {

// gain prod (z - zeros_i) / prod (z - poles_i), all of them real.
struct ZerosPoles {
  std::vector<double> zeros, poles;
  double gain = 1;

  // The whole part of an order, exactly: (scale (z - 1)/(z + pole))^whole.
  void multiply_whole(int whole, const DifferenceRule& rule) {
    if (whole == 0) return;
    zeros.push_back(whole > 0 ? 1 : -rule.pole);
    poles.push_back(whole > 0 ? -rule.pole : 1);
    gain *= std::pow(rule.scale(), whole);
  }
};

// The continued fraction of ((1 - w)/(1 + pole w))^order cut after `sections` zeros and poles.
//
// It is the diagonal Pade approximant, which a Moebius map of w carries over from pole 1 to any
// other. There its zeros in z are those of the Jacobi polynomial with parameters (-order, order),
// the eigenvalues of a tridiagonal matrix, and its poles are their opposites.
NFOPIDN_HOST ZerosPoles continued_fraction(double order, const DifferenceRule& rule, int sections);

// Oustaloup's zeros and poles, evenly spaced in log s between low and high [rad/s], taken to z by
// Tustin's rule.
NFOPIDN_HOST ZerosPoles oustaloup(double order, const DifferenceRule& rule, int sections,
                                  double low, double high);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST ZerosPoles continued_fraction(double order, const DifferenceRule& rule, int sections) {
  const SplitOrder split(order);
  ZerosPoles result;
  result.gain = std::pow(rule.scale(), split.rest);
  if (split.rest != 0) {
    Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(sections);
    diagonal(0) = split.rest;
    Eigen::VectorXd next(sections - 1);
    for (int k = 1; k < sections; ++k) {
      next(k - 1) = std::sqrt((k * k - split.rest * split.rest) / (4.0 * k * k - 1));
    }
    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
    solver.computeFromTridiagonal(diagonal, next, Eigen::EigenvaluesOnly);
    for (const double place : solver.eigenvalues()) {
      result.zeros.push_back(((1 + rule.pole) * place + (1 - rule.pole)) / 2);
      result.poles.push_back((-(1 + rule.pole) * place + (1 - rule.pole)) / 2);
    }
  }
  result.multiply_whole(split.whole, rule);
  return result;
}

NFOPIDN_HOST ZerosPoles oustaloup(double order, const DifferenceRule& rule, int sections,
                                  double low, double high) {
  const SplitOrder split(order);
  ZerosPoles result;
  const double scale = rule.scale();
  result.gain = std::pow(high, split.rest);
  for (int k = 0; split.rest != 0 && k < sections; ++k) {
    const auto corner = [&](double sign) {
      return low * std::pow(high / low, (k + (1 + sign * split.rest) / 2) / sections);
    };
    const double zero = corner(-1);
    const double pole = corner(1);
    result.zeros.push_back((scale - zero) / (scale + zero));
    result.poles.push_back((scale - pole) / (scale + pole));
    result.gain *= (scale + zero) / (scale + pole);
  }
  result.multiply_whole(split.whole, rule);
  return result;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
