// L4. Kinematic back-stepping: Y. Kanayama, Y. Kimura, F. Miyazaki, T. Noguchi, "A stable tracking
// control method for an autonomous mobile robot", IEEE ICRA 1990, eq. 7:
//   v_c     = v_r cos e_theta + k_x e_x
//   omega_c = omega_r + v_r (k_y e_y + k_theta sin e_theta)
// Its proof needs v_r > 0: where the reference reverses, the heading's term has the wrong sign.
#pragma once

#include "nfopidn/rivals/velocity_loop.hpp"

namespace nfopidn::rivals {

struct KanayamaGains {
  static constexpr double tuned_k_v = 0.6436;  // of its VelocityLoop
  static constexpr double tuned_k_omega = 0.909202;
  double k_x = 1.00934;
  double k_y = 73.4767;
  double k_theta = 306.579;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using S = KanayamaGains;
    visit(field("k_x", &S::k_x, "1/s", between(0, 10), "on the error ahead"));
    visit(field("k_y", &S::k_y, "1/m^2", between(0, 300), "on the error to the left"));
    visit(field("k_theta", &S::k_theta, "1/m", between(0, 1000), "on the heading error"));
  }
};

template <class Number>
class Kanayama {
 public:
  using Scalar = Number;
  using Settings = KanayamaGains;
  static constexpr const char* name = "kanayama";

  Kanayama(const Settings& settings, const Model<Scalar>& /*model*/)
      : k_x_(Scalar(settings.k_x)),
        k_y_(Scalar(settings.k_y)),
        k_theta_(Scalar(settings.k_theta)) {}

  constexpr Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    const Heading<Scalar> misalignment = math<Scalar>::heading(view.error.theta);
    const ReferenceSample<Scalar>& r = view.reference;
    return {r.v * misalignment.cosine + k_x_ * view.error.x,
            r.omega + r.v * (k_y_ * view.error.y + k_theta_ * misalignment.sine)};
  }

  // How fast command() changes, by the kinematics of the errors.
  constexpr Accelerations<Scalar> slope(const View<Scalar>& view) const noexcept {
    const Heading<Scalar> misalignment = math<Scalar>::heading(view.error.theta);
    const ReferenceSample<Scalar>& r = view.reference;
    const Channels<Scalar> rate = error_rates(view);
    return {view.acceleration.linear * misalignment.cosine - r.v * misalignment.sine * rate.theta +
                k_x_ * rate.x,
            view.acceleration.angular +
                view.acceleration.linear * (k_y_ * view.error.y + k_theta_ * misalignment.sine) +
                r.v * (k_y_ * rate.y + k_theta_ * misalignment.cosine * rate.theta)};
  }

 private:
  Scalar k_x_;
  Scalar k_y_;
  Scalar k_theta_;
};

}  // namespace nfopidn::rivals
