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
    double k_x = 1.09621;
    double k_y = 40.7948;
    double k_theta = 4.27048;

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      visit(field("k_x", &Settings::k_x, "1/s", between(0, 10), "on the error ahead"));
      visit(field("k_y", &Settings::k_y, "1/m^2", between(0, 300), "on the error to the left"));
      visit(field("k_theta", &Settings::k_theta, "1/s", between(0, 10), "on the heading error"));
    }
  };

  Samson(const Settings& settings, const Model<Scalar>& /*model*/)
      : k_x_(Scalar(settings.k_x)),
        k_y_(Scalar(settings.k_y)),
        k_theta_(Scalar(settings.k_theta)) {}

  constexpr Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    const ReferenceSample<Scalar>& r = view.reference;
    const Scalar along = r.v * math<Scalar>::heading(view.error.theta).cosine;
    return {along + k_x_ * view.error.x,
            r.omega + k_y_ * r.v * view.error.y + k_theta_ * view.error.theta};
  }

 private:
  Scalar k_x_;
  Scalar k_y_;
  Scalar k_theta_;
};

}  // namespace nfopidn::rivals
