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
    double k_x_slow_aligned = 1.07005, k_y_slow_aligned = 64.936, k_theta_slow_aligned = 1.95555;
    double k_x_slow_askew = 1.1901, k_y_slow_askew = 300, k_theta_slow_askew = 10;
    double k_x_fast_aligned = 0.397412, k_y_fast_aligned = 50.1667, k_theta_fast_aligned = 8.52598;
    double k_x_fast_askew = 10, k_y_fast_askew = 0.240162, k_theta_fast_askew = 0.000173890;

    template <class Visitor>
    static constexpr void fields(Visitor&& visit) {
      using S = Settings;
      const auto rule = [&](const char* x, double S::*k_x, const char* y, double S::*k_y,
                            const char* theta, double S::*k_theta) {
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

  TakagiSugeno(const Settings& settings, const Model<Scalar>& model)
      : s_(settings), inverse_peak_(Scalar(1) / model.peak_speed) {}

  constexpr Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    using M = math<Scalar>;
    const ReferenceSample<Scalar>& r = view.reference;
    const Heading<Scalar> to_reference = M::heading(view.error.theta);
    const Scalar fast = M::minimum(M::absolute(r.v) * inverse_peak_, Scalar(1));
    // 0 straight ahead, 1 from a right angle on.
    const Scalar misalignment = Scalar(1) - M::maximum(to_reference.cosine, Scalar(0));
    const auto blend = [&](double slow_aligned, double slow_askew, double fast_aligned,
                           double fast_askew) {
      const Scalar slow = Scalar(slow_aligned) + misalignment * Scalar(slow_askew - slow_aligned);
      return slow + fast * (Scalar(fast_aligned) +
                            misalignment * Scalar(fast_askew - fast_aligned) - slow);
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
  Scalar inverse_peak_;
};

}  // namespace nfopidn::rivals
