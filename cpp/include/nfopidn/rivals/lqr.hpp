// L4. Time-varying linear-quadratic regulator on the linearised errors, its gain a function of the
// reference speed: v_c = v_r + k_1 e, omega_c = omega_r + k_2 e. B. D. O. Anderson, J. B. Moore,
// "Optimal Control: Linear Quadratic Methods", 1990; for the unicycle as in WPILib's
// LTVUnicycleController, whose weights by tolerances are used too: 1/tolerance^2 of each error and
// of each velocity.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "nfopidn/math/dual.hpp"
#include "nfopidn/rivals/lqr_schedule.hpp"

namespace Eigen {

// Matrices of dual numbers: the regulator's gains and how they change with its weights.
template <>
struct NumTraits<nfopidn::Dual<double>> : GenericNumTraits<nfopidn::Dual<double>> {
  using Real = nfopidn::Dual<double>;
  using NonInteger = nfopidn::Dual<double>;
  using Nested = nfopidn::Dual<double>;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 2,
    MulCost = 4
  };
};

}  // namespace Eigen

namespace nfopidn::rivals {

template <class Number>
struct LqrTolerances {
  static constexpr double tuned_k_v = 1.1203;  // of its VelocityLoop
  static constexpr double tuned_k_omega = 0.978953;
  Number tolerance_x = Number(0.74315);
  Number tolerance_y = Number(0.0327935);
  Number tolerance_theta = Number(0.00835938);
  Number tolerance_omega = Number(100.0);

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

inline double square_root(double value) { return std::sqrt(value); }
inline Dual<double> square_root(const Dual<double>& value) {
  const double root = std::sqrt(value.value);
  return {root, value.slope / (2 * root)};
}

template <class Number>
using Square = Eigen::Matrix<Number, 2, 2>;

// The norm of a matrix's values.
template <class Number>
double norm(const Square<Number>& matrix) {
  Eigen::Matrix2d values;
  for (Eigen::Index i = 0; i < 4; ++i) values(i) = math<Number>::value(matrix(i));
  return values.norm();
}

// Solves the discrete algebraic Riccati equation of two states and one input by doubling: E. K.-W.
// Chu, H.-Y. Fan, W.-W. Lin, C.-S. Wang, Int. J. Control 77(8), 2004.
template <class Number>
Square<Number> riccati(Square<Number> a, const Eigen::Matrix<Number, 2, 1>& b,
                       const Square<Number>& q, const Number& r) {
  Square<Number> g = b * b.transpose() / r;
  Square<Number> h = q;
  constexpr int most = 60;  // a doubling each: convergence is quadratic
  for (int i = 0; i < most; ++i) {
    const Square<Number> w = (Square<Number>::Identity() + g * h).inverse();
    const Square<Number> wa = w * a;
    const Square<Number> change = a.transpose() * h * wa;
    g += a * w * g * a.transpose();
    a = a * wa;
    h += change;
    if (norm<Number>(change) <= 1e-15 * norm<Number>(h)) break;
  }
  return h;
}

// Errors that stand still but for omega_c and v_r's part in e_y: A = [0 0 0; 0 0 v; 0 0 0],
// B = [1 0; 0 0; 0 1], sampled exactly. Near v = 0 the lateral error is out of reach: a creeping
// speed stands in.
template <class Number>
LqrGains<Number> lqr_gains(const LqrTolerances<Number>& tolerance, double v, double dt) {
  using Column = Eigen::Matrix<Number, 2, 1>;
  constexpr double creeping = 1e-4;
  const double speed = std::fabs(v) < creeping ? creeping : v;
  const auto weight = [](const Number& value) { return Number(1.0) / (value * value); };
  const Number q_x = weight(tolerance.tolerance_x);
  const Number p = q_x / 2.0 + square_root(q_x * q_x / 4.0 + q_x / (dt * dt));
  Square<Number> a = Square<Number>::Identity();
  a(0, 1) = Number(speed * dt);
  const Column b(Number(speed * dt * dt / 2), Number(dt));
  const Square<Number> q =
      Column(weight(tolerance.tolerance_y), weight(tolerance.tolerance_theta)).asDiagonal();
  const Number r = weight(tolerance.tolerance_omega);
  const Square<Number> cost = riccati<Number>(a, b, q, r);
  const Eigen::Matrix<Number, 1, 2> k = b.transpose() * cost * a / (r + b.dot(cost * b));
  return {dt * p / (1.0 + dt * dt * p), k(0), k(1)};
}

// The table of a schedule up to the reference's peak speed.
inline double lqr_spacing(double peak_speed) {
  constexpr double finest = 0.01;  // [m/s]
  constexpr int longest = 1000;    // table
  return std::max(finest, peak_speed / (longest - 1));
}
inline int lqr_table_size(double peak_speed) {
  return static_cast<int>(std::ceil(peak_speed / lqr_spacing(peak_speed))) + 2;
}
template <class Number>
std::vector<LqrGains<Number>> lqr_table(const LqrTolerances<Number>& tolerance, double peak_speed,
                                        double dt) {
  std::vector<LqrGains<Number>> table;
  const int size = lqr_table_size(peak_speed);
  for (int i = 0; i < size; ++i) {
    table.push_back(lqr_gains(tolerance, i * lqr_spacing(peak_speed), dt));
  }
  return table;
}

template <class Number>
class Lqr {
 public:
  using Scalar = Number;
  using Settings = LqrTolerances<Number>;
  static constexpr const char* name = "lqr";

  Lqr(const Settings& settings, const Model<double>& model)
      : table_(lqr_table(settings, model.peak_speed, model.dt)),
        spacing_(lqr_spacing(model.peak_speed)) {}

  LqrGains<Number> gains(double v) const noexcept { return schedule().gains(v); }
  Velocity<Scalar> command(const View<Scalar>& view) const noexcept {
    return schedule().command(view);
  }

 private:
  LqrSchedule<Number> schedule() const {
    return {table_.data(), static_cast<int>(table_.size()), spacing_};
  }

  std::vector<LqrGains<Number>> table_;
  double spacing_;
};

}  // namespace nfopidn::rivals
