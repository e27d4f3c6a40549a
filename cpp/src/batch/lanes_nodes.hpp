// Cosines and sines at the nodes of a quadrature, for the slopes of lanes: the value is one number,
// so that its eight nodes fill the vectors.
#pragma once

#include "lanes.hpp"
#include "nfopidn/math/dual.hpp"
#include "nfopidn/plant/motion_slopes.hpp"

namespace nfopidn::exact {

template <int width, int count>
struct NodeHeadings<Dual<double, Lanes<width, count>>> {
  static constexpr int nodes = 8;
  using All = Lanes<nodes, 1>;
  using Real = typename Vectors<nodes>::Real;
  using Bits = typename Vectors<nodes>::Bits;

  // The operations of math<double>::heading(), so that its bits are the same.
  NFOPIDN_INLINE static void find(const double (&angle)[nodes], double (&cosine)[nodes],
                                  double (&sine)[nodes]) {
    using Constants = kernel::Coefficients<double>;
    Real angles;
    __builtin_memcpy(&angles, angle, sizeof angles);
    const Real shifted =
        kernel::opaque<Real>(angles * (2 / math<double>::pi) + Constants::round_magic);
    const Real quarters = kernel::opaque<Real>(shifted - Constants::round_magic);
    All rest, square;
    rest.part[0] = (angles - quarters * Constants::half_pi[0]) - quarters * Constants::half_pi[1];
    square = rest * rest;
    const Real s = kernel::odd_polynomial(rest, square, Constants::sine).part[0];
    const Real c = kernel::polynomial(square, Constants::cosine).part[0];
    const Bits quadrant = reinterpret_cast<Bits>(shifted);
    const auto odd = (quadrant & 1) != 0;
    const auto turned = (quadrant & 2) != 0;
    const Real x = odd ? -s : c;
    const Real y = odd ? c : s;
    const Real cosines = turned ? -x : x;
    const Real sines = turned ? -y : y;
    __builtin_memcpy(cosine, &cosines, sizeof cosines);
    __builtin_memcpy(sine, &sines, sizeof sines);
  }
};

}  // namespace nfopidn::exact
