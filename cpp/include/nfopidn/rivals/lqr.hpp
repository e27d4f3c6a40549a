// L4. Time-varying linear-quadratic regulator on the linearised errors, its gain a function of the
// reference speed: v_c = v_r + k_1 e, omega_c = omega_r + k_2 e. B. D. O. Anderson, J. B. Moore,
// "Optimal Control: Linear Quadratic Methods", 1990; for the unicycle as in WPILib's
// LTVUnicycleController, whose weights by tolerances are used too: 1/tolerance^2 of each error and
// of each velocity.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "nfopidn/rivals/velocity_loop.hpp"

namespace nfopidn::rivals {

// The gains at one reference speed; by the symmetry of left and right those left out are zero.
struct LqrGains {
  double k_x = 0;      // on v [1/s]
  double k_y = 0;      // on omega [rad/(m s)]
  double k_theta = 0;  // on omega [1/s]
};

struct LqrTolerances {
  static constexpr double tuned_k_v = 1.1203;  // of its VelocityLoop
  static constexpr double tuned_k_omega = 0.978953;
  double tolerance_x = 0.74315;
  double tolerance_y = 0.0327935;
  double tolerance_theta = 0.00835938;
  double tolerance_omega = 100;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using S = LqrTolerances;
    visit(field("tolerance_x", &S::tolerance_x, "m", between(0.001, 100), "of the error ahead"));
    visit(field("tolerance_y", &S::tolerance_y, "m", between(0.001, 100), "of that to the left"));
    visit(field("tolerance_theta", &S::tolerance_theta, "rad", between(0.001, 100),
                "of the heading error"));
    visit(field("tolerance_omega", &S::tolerance_omega, "rad/s", between(0.001, 100),
                "of the turning rate; that of the speed is 1 m/s"));
  }
};

// Solves the discrete algebraic Riccati equation of two states and one input by doubling: E. K.-W.
// Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77(8), 2004.
inline Eigen::Matrix2d riccati(Eigen::Matrix2d a, const Eigen::Vector2d& b,
                               const Eigen::Matrix2d& q, double r) {
  Eigen::Matrix2d g = b * b.transpose() / r;
  Eigen::Matrix2d h = q;
  constexpr int most = 60;  // a doubling each: convergence is quadratic
  for (int i = 0; i < most; ++i) {
    const Eigen::Matrix2d w = (Eigen::Matrix2d::Identity() + g * h).inverse();
    const Eigen::Matrix2d wa = w * a;
    const Eigen::Matrix2d change = a.transpose() * h * wa;
    g += a * w * g * a.transpose();
    a = a * wa;
    h += change;
    if (change.norm() <= 1e-15 * h.norm()) break;
  }
  return h;
}

// Errors that stand still but for omega_c and v_r's part in e_y: A = [0 0 0; 0 0 v; 0 0 0],
// B = [1 0; 0 0; 0 1], sampled exactly. Near v = 0 the lateral error is out of reach: a creeping
// speed stands in.
inline LqrGains lqr_gains(const LqrTolerances& tolerance, double v, double dt) {
  constexpr double creeping = 1e-4;
  const double speed = std::fabs(v) < creeping ? creeping : v;
  const auto weight = [](double value) { return 1 / (value * value); };
  const double q_x = weight(tolerance.tolerance_x);
  const double p = q_x / 2 + std::sqrt(q_x * q_x / 4 + q_x / (dt * dt));
  Eigen::Matrix2d a = Eigen::Matrix2d::Identity();
  a(0, 1) = speed * dt;
  const Eigen::Vector2d b(speed * dt * dt / 2, dt);
  const Eigen::Matrix2d q =
      Eigen::Vector2d(weight(tolerance.tolerance_y), weight(tolerance.tolerance_theta))
          .asDiagonal();
  const double r = weight(tolerance.tolerance_omega);
  const Eigen::Matrix2d cost = riccati(a, b, q, r);
  const Eigen::RowVector2d k = b.transpose() * cost * a / (r + b.dot(cost * b));
  return {dt * p / (1 + dt * dt * p), k(0), k(1)};
}

template <class Number>
class Lqr {
 public:
  using Scalar = Number;
  using Settings = LqrTolerances;
  static constexpr const char* name = "lqr";
  static constexpr double finest = 0.01;  // spacing of the table [m/s]
  static constexpr int longest = 1000;    // table

  Lqr(const Settings& settings, const Model<Scalar>& model) {
    const double peak = static_cast<double>(model.peak_speed);
    spacing_ = std::max(finest, peak / (longest - 1));
    const int count = static_cast<int>(std::ceil(peak / spacing_)) + 1;
    for (int i = 0; i <= count; ++i) {
      table_.push_back(lqr_gains(settings, i * spacing_, static_cast<double>(model.dt)));
    }
  }

  // Between two speeds of the table in proportion; for one in reverse the lateral gain turns round.
  LqrGains gains(double v) const noexcept {
    const double place = std::fabs(v) / spacing_;
    const auto last = table_.size() - 2;
    const std::size_t below =
        place < static_cast<double>(last) ? static_cast<std::size_t>(place) : last;
    const double share = std::min(place - static_cast<double>(below), 1.0);
    const LqrGains& low = table_[below];
    const LqrGains& high = table_[below + 1];
    const double k_y = low.k_y + share * (high.k_y - low.k_y);
    return {low.k_x, v < 0 ? -k_y : k_y, low.k_theta + share * (high.k_theta - low.k_theta)};
  }

  Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    const ReferenceSample<Scalar>& r = view.reference;
    const LqrGains k = gains(static_cast<double>(r.v));
    return {r.v + Scalar(k.k_x) * view.error.x,
            r.omega + Scalar(k.k_y) * view.error.y + Scalar(k.k_theta) * view.error.theta};
  }

 private:
  double spacing_ = finest;
  std::vector<LqrGains> table_;
};

}  // namespace nfopidn::rivals
