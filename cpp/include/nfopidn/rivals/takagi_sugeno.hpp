// L4. Takagi-Sugeno fuzzy tracking by parallel distributed compensation: T. Takagi, M. Sugeno,
// IEEE Trans. SMC 15(1), 1985; on the tracking errors of a unicycle E.-H. Guechi, J. Lauber,
// M. Dambrine, G. Klancar, S. Blazic, "PDC control design for non-holonomic wheeled mobile robots
// with delayed outputs", J. Intelligent and Robotic Systems 60, 2010. Four rules: the reference is
// slow or fast, the robot is aligned or not. Each has a linear law of its own,
//   v_c = v_r cos e_theta + k_x e_x,   omega_c = omega_r + k_y v_r e_y + k_theta e_theta
// and the membership functions, which sum to one, blend their gains.
#pragma once

#include "nfopidn/rivals/velocity_loop.hpp"

namespace nfopidn::rivals {

template <class Number>
class TakagiSugeno {
 public:
  using Scalar = Number;
  static constexpr const char* name = "takagi-sugeno";

  struct Settings {
    static constexpr double tuned_k_v = 1.32248;  // of its VelocityLoop
    static constexpr double tuned_k_omega = 1.01722;
    Number k_x_slow_aligned = Number(1.07005);
    Number k_y_slow_aligned = Number(64.936);
    Number k_theta_slow_aligned = Number(1.95555);
    Number k_x_slow_askew = Number(1.1901);
    Number k_y_slow_askew = Number(300.0);
    Number k_theta_slow_askew = Number(10.0);
    Number k_x_fast_aligned = Number(0.397412);
    Number k_y_fast_aligned = Number(50.1667);
    Number k_theta_fast_aligned = Number(8.52598);
    Number k_x_fast_askew = Number(10.0);
    Number k_y_fast_askew = Number(0.240162);
    Number k_theta_fast_askew = Number(0.000173890);

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      using S = Settings;
      const auto rule = [&](const char* x, Number S::*k_x, const char* y, Number S::*k_y,
                            const char* theta, Number S::*k_theta) {
        visit(field(x, k_x, "1/s", between(0, 10), "on the error ahead"));
        visit(field(y, k_y, "1/m^2", between(0, 300), "on the error to the left"));
        visit(field(theta, k_theta, "1/s", between(0, 10), "on the heading error"));
      };
      rule("k_x_slow_aligned", &S::k_x_slow_aligned, "k_y_slow_aligned", &S::k_y_slow_aligned,
           "k_theta_slow_aligned", &S::k_theta_slow_aligned);
      rule("k_x_slow_askew", &S::k_x_slow_askew, "k_y_slow_askew", &S::k_y_slow_askew,
           "k_theta_slow_askew", &S::k_theta_slow_askew);
      rule("k_x_fast_aligned", &S::k_x_fast_aligned, "k_y_fast_aligned", &S::k_y_fast_aligned,
           "k_theta_fast_aligned", &S::k_theta_fast_aligned);
      rule("k_x_fast_askew", &S::k_x_fast_askew, "k_y_fast_askew", &S::k_y_fast_askew,
           "k_theta_fast_askew", &S::k_theta_fast_askew);
    }
  };

  using Base = base_t<Scalar>;

  TakagiSugeno(const Settings& settings, const Model<Base>& model)
      : s_(settings), inverse_peak_(Base(1) / model.peak_speed) {}

  NFOPIDN_INLINE constexpr Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    using M = math<Scalar>;
    const auto& r = view.reference;
    const Heading<Scalar> to_reference = M::heading(view.error.theta);
    const Base speed = (r.v < 0 ? -r.v : r.v) * inverse_peak_;
    const Base fast = speed < 1 ? speed : Base(1);
    // 0 straight ahead, 1 from a right angle on.
    const Scalar misalignment = Base(1) - M::maximum(to_reference.cosine, Scalar(Base(0)));
    const auto blend = [&](const Scalar& slow_aligned, const Scalar& slow_askew,
                           const Scalar& fast_aligned, const Scalar& fast_askew) {
      const Scalar slow = slow_aligned + misalignment * (slow_askew - slow_aligned);
      return slow + fast * (fast_aligned + misalignment * (fast_askew - fast_aligned) - slow);
    };
    const Scalar k_x =
        blend(s_.k_x_slow_aligned, s_.k_x_slow_askew, s_.k_x_fast_aligned, s_.k_x_fast_askew);
    const Scalar k_y =
        blend(s_.k_y_slow_aligned, s_.k_y_slow_askew, s_.k_y_fast_aligned, s_.k_y_fast_askew);
    const Scalar k_theta = blend(s_.k_theta_slow_aligned, s_.k_theta_slow_askew,
                                 s_.k_theta_fast_aligned, s_.k_theta_fast_askew);
    return {r.v * to_reference.cosine + k_x * view.error.x,
            r.omega + k_y * r.v * view.error.y + k_theta * view.error.theta};
  }

 private:
  Settings s_;
  Base inverse_peak_;
};

}  // namespace nfopidn::rivals
