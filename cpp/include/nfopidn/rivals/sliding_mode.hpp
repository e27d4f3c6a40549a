// L4. Sliding mode with computed torque, after J.-M. Yang, J.-H. Kim, "Sliding mode control for
// trajectory tracking of nonholonomic wheeled mobile robots", IEEE Trans. Robotics and Automation
// 15(3), 1999: a surface for each control, reached by ds/dt = -q s - p sat(s / boundary). Theirs
// are in polar coordinates, which are singular at the origin; here, in the errors of the robot's
// frame,
//   s_1 = d(e_x)/dt + lambda_x e_x
//   s_2 = d(e_theta)/dt + lambda_theta e_theta + lambda_y v_r e_y
// The boundary layer stands in for their sign function, which would chatter at any sample time.
#pragma once

#include "nfopidn/rivals/rival.hpp"

namespace nfopidn::rivals {

template <class Number>
class SlidingMode {
 public:
  using Scalar = Number;
  static constexpr const char* name = "sliding-mode";

  struct Settings {
    Number lambda_x = Number(1.55929);
    Number lambda_y = Number(4.56514);
    Number lambda_theta = Number(0.997586);
    Number q_x = Number(0.0);
    Number q_theta = Number(0.0);
    Number p_x = Number(0.238126);
    Number p_theta = Number(1.03896);
    Number boundary = Number(0.137733);

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      using S = Settings;
      visit(field("lambda_x", &S::lambda_x, "1/s", between(0, 5), "of the surface ahead"));
      visit(field("lambda_y", &S::lambda_y, "1/m^2", between(0, 300), "of the error to the left"));
      visit(field("lambda_theta", &S::lambda_theta, "1/s", between(0, 5), "of the heading error"));
      visit(field("q_x", &S::q_x, "1/s", between(0, 5), "rate of approach ahead"));
      visit(field("q_theta", &S::q_theta, "1/s", between(0, 5), "rate of approach in heading"));
      visit(field("p_x", &S::p_x, "m/s^2", between(0, 2), "switched acceleration"));
      visit(field("p_theta", &S::p_theta, "rad/s^2", between(0, 5), "switched acceleration"));
      visit(field("boundary", &S::boundary, "m/s, rad/s", between(0.01, 2),
                  "half width of the layer in which switching is gradual"));
    }
  };

  SlidingMode(const Settings& settings, const Model<base_t<Scalar>>& /*model*/) : s_(settings) {}

  constexpr void reset() noexcept {}

  NFOPIDN_INLINE constexpr Accelerations<Scalar> feedback(const View<Scalar>& view) const noexcept {
    const Heading<Scalar> misalignment = math<Scalar>::heading(view.error.theta);
    const auto& r = view.reference;
    const Channels<Scalar> rate = error_rates(view);
    const Scalar surface_x = rate.x + s_.lambda_x * view.error.x;
    const Scalar surface_theta =
        rate.theta + s_.lambda_theta * view.error.theta + s_.lambda_y * r.v * view.error.y;
    // Both surfaces' rates of change, solved for the accelerations.
    const Scalar turning = s_.lambda_theta * rate.theta +
                           s_.lambda_y * (view.acceleration.linear * view.error.y + r.v * rate.y) +
                           approach(surface_theta, s_.q_theta, s_.p_theta);
    const Scalar angular = view.acceleration.angular + turning;
    const Scalar linear = view.acceleration.linear * misalignment.cosine -
                          r.v * misalignment.sine * rate.theta + angular * view.error.y +
                          view.speed.omega * rate.y + s_.lambda_x * rate.x +
                          approach(surface_x, s_.q_x, s_.p_x);
    return {linear - view.acceleration.linear, turning};
  }

 private:
  NFOPIDN_INLINE constexpr Scalar approach(const Scalar& surface, const Scalar& q,
                                           const Scalar& p) const {
    using M = math<Scalar>;
    using Base = base_t<Scalar>;
    const Scalar inside = surface / s_.boundary;
    const Scalar share = M::maximum(M::minimum(inside, Scalar(Base(1))), Scalar(Base(-1)));
    return q * surface + p * share;
  }

  Settings s_;
};

}  // namespace nfopidn::rivals
