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
  static constexpr int parts = nodes / width;
  using All = Lanes<width, parts>;
  using Real = typename Vectors<width>::Real;
  using Bits = typename Vectors<width>::Bits;

  // The operations of math<double>::heading(), so that its bits are the same.
  NFOPIDN_INLINE static void find(const double (&angle)[nodes], double (&cosine)[nodes],
                                  double (&sine)[nodes]) {
    using Constants = kernel::Coefficients<double>;
    All rest;
    Bits quadrant[parts];
    for (int i = 0; i < parts; ++i) {
      Real angles;
      __builtin_memcpy(&angles, angle + i * width, sizeof angles);
      const Real shifted =
          kernel::opaque<Real>(angles * (2 / math<double>::pi) + Constants::round_magic);
      const Real quarters = kernel::opaque<Real>(shifted - Constants::round_magic);
      rest.part[i] = (angles - quarters * Constants::half_pi[0]) - quarters * Constants::half_pi[1];
      quadrant[i] = reinterpret_cast<Bits>(shifted);
    }
    const All square = rest * rest;
    const All s = kernel::odd_polynomial(rest, square, Constants::sine);
    const All c = kernel::polynomial(square, Constants::cosine);
    for (int i = 0; i < parts; ++i) {
      const auto odd = (quadrant[i] & 1) != 0;
      const auto turned = (quadrant[i] & 2) != 0;
      const Real x = odd ? -s.part[i] : c.part[i];
      const Real y = odd ? c.part[i] : s.part[i];
      const Real cosines = turned ? -x : x;
      const Real sines = turned ? -y : y;
      __builtin_memcpy(cosine + i * width, &cosines, sizeof cosines);
      __builtin_memcpy(sine + i * width, &sines, sizeof sines);
    }
  }
};

}  // namespace nfopidn::exact
