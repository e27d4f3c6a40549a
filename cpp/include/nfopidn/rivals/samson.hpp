// L4. Linear feedback on the errors of the pose: C. Samson, K. Ait-Abderrahim, "Feedback control of
// a nonholonomic wheeled cart in Cartesian space", IEEE ICRA 1991, in the linear form of G.
// Klancar, D. Matko, S. Blazic, "Mobile robot control on a reference path", IEEE MED 2005:
//   v_c     = v_r cos e_theta + k_x e_x
//   omega_c = omega_r + k_y v_r e_y + k_theta e_theta
// The lateral gain goes with the signed reference speed; the other two are constant here, where
// Klancar's are 2 zeta sqrt(omega_r^2 + b v_r^2) (RAMSETE has those).
#pragma once

#include "nfopidn/rivals/velocity_loop.hpp"

namespace nfopidn::rivals {

template <class Number>
class Samson {
 public:
  using Scalar = Number;
  static constexpr const char* name = "samson";

  struct Settings {
    static constexpr double tuned_k_v = 1.33814;  // of its VelocityLoop
    static constexpr double tuned_k_omega = 1.04237;
    Number k_x = Number(1.09621);
    Number k_y = Number(40.7948);
    Number k_theta = Number(4.27048);

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      visit(field("k_x", &Settings::k_x, "1/s", between(0, 10), "on the error ahead"));
      visit(field("k_y", &Settings::k_y, "1/m^2", between(0, 300), "on the error to the left"));
      visit(field("k_theta", &Settings::k_theta, "1/s", between(0, 10), "on the heading error"));
    }
  };

  Samson(const Settings& settings, const Model<base_t<Scalar>>& /*model*/) : s_(settings) {}

  NFOPIDN_INLINE constexpr Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    const auto& r = view.reference;
    const Scalar along = r.v * math<Scalar>::heading(view.error.theta).cosine;
    return {along + s_.k_x * view.error.x,
            r.omega + s_.k_y * r.v * view.error.y + s_.k_theta * view.error.theta};
  }

 private:
  Settings s_;
};

}  // namespace nfopidn::rivals
