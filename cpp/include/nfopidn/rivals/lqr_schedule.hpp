// L4. The gains of the linear-quadratic regulator as a function of the reference speed, from a
// table: v_c = v_r + k_x e_x, omega_c = omega_r + k_y e_y + k_theta e_theta. lqr.hpp makes the
// table.
#pragma once

#include "nfopidn/rivals/velocity_loop.hpp"

namespace nfopidn::rivals {

// The gains at one reference speed; by the symmetry of left and right those left out are zero.
template <class Number>
struct LqrGains {
  Number k_x;      // on v [1/s]
  Number k_y;      // on omega [rad/(m s)]
  Number k_theta;  // on omega [1/s]
};

// Borrows its table: gains at the speeds 0, spacing, 2 spacing and so on, two entries at least.
template <class Number>
struct LqrSchedule {
  using Scalar = Number;
  using Base = base_t<Scalar>;

  const LqrGains<Number>* table;
  int size;
  Base spacing;  // [m/s]

  // Between two speeds of the table in proportion; for one in reverse the lateral gain turns round.
  NFOPIDN_INLINE constexpr LqrGains<Number> gains(Base v) const noexcept {
    const Base place = (v < 0 ? -v : v) / spacing;
    const int last = size - 2;
    const int below = place < static_cast<Base>(last) ? static_cast<int>(place) : last;
    const Base rest = place - static_cast<Base>(below);
    const Base share = rest < 1 ? rest : Base(1);
    const LqrGains<Number>& low = table[below];
    const LqrGains<Number>& high = table[below + 1];
    const Number k_y = low.k_y + share * (high.k_y - low.k_y);
    return {low.k_x, v < 0 ? k_y * Base(-1) : k_y,
            low.k_theta + share * (high.k_theta - low.k_theta)};
  }

  NFOPIDN_INLINE constexpr Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    const auto& r = view.reference;
    const LqrGains<Number> k = gains(r.v);
    return {r.v + k.k_x * view.error.x,
            r.omega + k.k_y * view.error.y + k.k_theta * view.error.theta};
  }
};

}  // namespace nfopidn::rivals
