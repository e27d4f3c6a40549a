// L4. Nonlinear feedback: A. De Luca, G. Oriolo, M. Vendittelli, "Control of wheeled mobile robots:
// an experimental overview", Ramsete, Springer LNCIS 270, 2001, eq. 5.12:
//   v_c     = v_r cos e_theta + k e_x,   k = 2 zeta sqrt(omega_r^2 + b v_r^2)
//   omega_c = omega_r + k e_theta + b v_r (sin e_theta / e_theta) e_y
#pragma once

#include <cmath>

#include "nfopidn/rivals/velocity_loop.hpp"

namespace nfopidn::rivals {

template <class Number>
class Ramsete {
 public:
  using Scalar = Number;
  static constexpr const char* name = "ramsete";

  struct Settings {
    static constexpr double tuned_k_v = 0.224119;  // of its VelocityLoop
    static constexpr double tuned_k_omega = 0.214752;
    double b = 14.9511;
    double zeta = 3.21583;

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      visit(field("b", &Settings::b, "1/m^2", between(0, 300), "how hard the position is chased"));
      visit(field("zeta", &Settings::zeta, "", between(0, 10), "damping"));
    }
  };

  Ramsete(const Settings& settings, const Model<Scalar>& /*model*/)
      : b_(Scalar(settings.b)), zeta_(Scalar(settings.zeta)) {}

  Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    const ReferenceSample<Scalar>& r = view.reference;
    const Heading<Scalar> misalignment = math<Scalar>::heading(view.error.theta);
    const Scalar k = Scalar(2) * zeta_ * std::sqrt(r.omega * r.omega + b_ * r.v * r.v);
    const bool small = math<Scalar>::absolute(view.error.theta) < Scalar(1e-9);
    const Scalar sinc = small ? Scalar(1) : misalignment.sine / view.error.theta;
    return {r.v * misalignment.cosine + k * view.error.x,
            r.omega + k * view.error.theta + b_ * r.v * sinc * view.error.y};
  }

 private:
  Scalar b_;
  Scalar zeta_;
};

}  // namespace nfopidn::rivals
