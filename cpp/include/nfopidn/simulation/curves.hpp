// L3. The named paths as closed forms in time.
#pragma once

#include <cmath>

#include "nfopidn/foundation/schema.hpp"
#include "nfopidn/math/math.hpp"

namespace nfopidn {

enum class Curve : unsigned char {
  ranunculoid,     // epicycloid; the paper's has 3 cusps, the true ranunculoid 5
  circle,          // radius 2 m
  lemniscate,      // Bernoulli's, half width 2 m
  eight,           // Gerono's, half width 2 m
  line,            // 6 m along x
  sine,            // 6 m along x, one wave of amplitude 1 m
  rounded_square,  // side 4 m, corner radius 1 m
  samples,         // given by the user
};

template <>
struct ChoiceNames<Curve> {
  static constexpr const char* names[] = {"ranunculoid", "circle", "lemniscate",     "eight",
                                          "line",        "sine",   "rounded_square", "samples"};
};

// A point of the path with its motion. The heading is continuous and the speed signed: at a cusp
// the robot reverses. Headings may differ by whole turns from one point to the next.
struct PathPoint {
  double x, y;               // [m]
  double theta;              // [rad]
  double v;                  // [m/s]
  double omega;              // [rad/s]
  double acceleration;       // dv/dt [m/s^2]
  double turn_acceleration;  // d(omega)/dt [rad/s^2]
};

namespace detail {

using Real = math<double>;

// Position and its first three derivatives with respect to the phase.
struct Jet {
  double x[4];
  double y[4];
};

// For paths without cusps: v, omega and their rates from the derivatives (eqs. 7 and 8, the latter
// as (x' y'' - y' x'')/(x'^2 + y'^2)).
inline PathPoint from_jet(const Jet& jet, double rate) {
  const double dx = jet.x[1] * rate;
  const double dy = jet.y[1] * rate;
  const double ddx = jet.x[2] * rate * rate;
  const double ddy = jet.y[2] * rate * rate;
  const double dddx = jet.x[3] * rate * rate * rate;
  const double dddy = jet.y[3] * rate * rate * rate;
  const double square = dx * dx + dy * dy;
  const double v = std::sqrt(square);
  const double omega = (dx * ddy - dy * ddx) / square;
  const double acceleration = (dx * ddx + dy * ddy) / v;
  return {jet.x[0],
          jet.y[0],
          Real::angle_of(dy, dx),
          v,
          omega,
          acceleration,
          (dx * dddy - dy * dddx) / square - 2 * omega * acceleration / v};
}

// (n+1) cos p - cos (n+1)p with n cusps: speed 2 (n+1) |sin(n p/2)|, tangent angle (n+2) p/2.
inline PathPoint epicycloid(double phase, double rate, int cusps) {
  const double n = cusps;
  const Heading<double> slow = Real::heading(phase);
  const Heading<double> fast = Real::heading((n + 1) * phase);
  const Heading<double> half = Real::heading(0.5 * n * phase);
  return {(n + 1) * slow.cosine - fast.cosine,
          (n + 1) * slow.sine - fast.sine,
          0.5 * (n + 2) * phase,
          2 * (n + 1) * rate * half.sine,
          0.5 * (n + 2) * rate,
          n * (n + 1) * rate * rate * half.cosine,
          0};
}

// a cos p/(1 + sin^2 p), a sin p cos p/(1 + sin^2 p), as a quotient of jets.
inline Jet lemniscate(double phase) {
  const Heading<double> h = Real::heading(phase);
  const double c = h.cosine;
  const double s = h.sine;
  const double up_x[4] = {2 * c, -2 * s, -2 * c, 2 * s};
  const double up_y[4] = {2 * s * c, 2 * (c * c - s * s), -8 * s * c, -8 * (c * c - s * s)};
  const double down[4] = {1 + s * s, 2 * s * c, 2 * (c * c - s * s), -8 * s * c};
  Jet jet{};
  const auto divide = [&](const double(&up)[4], double(&out)[4]) {
    out[0] = up[0] / down[0];
    out[1] = (up[1] - out[0] * down[1]) / down[0];
    out[2] = (up[2] - out[0] * down[2] - 2 * out[1] * down[1]) / down[0];
    out[3] = (up[3] - out[0] * down[3] - 3 * out[1] * down[2] - 3 * out[2] * down[1]) / down[0];
  };
  divide(up_x, jet.x);
  divide(up_y, jet.y);
  return jet;
}

// Constant speed along straights of 2 m and quarter circles of radius 1 m, from (0, -2) along x.
inline PathPoint rounded_square(double phase, double rate) {
  constexpr double pi = Real::pi;
  constexpr double length = 8 + 2 * pi;
  const double laps = phase / (2 * pi);
  const double lap = std::floor(laps);
  const double along = (laps - lap) * length + 1;  // from the start of the first straight
  const double side_length = length / 4;
  const double side = std::floor(along / side_length);
  const double rest = along - side * side_length;
  const double speed = rate * length / (2 * pi);
  const bool straight = rest < 2;
  const double turned = straight ? 0 : rest - 2;
  const Heading<double> corner = Real::heading(turned);
  // In the frame of the side, which runs along x from (-1, -2).
  const double u = straight ? -1 + rest : 1 + corner.sine;
  const double w = straight ? -2 : -1 - corner.cosine;
  const Heading<double> h = Real::heading(side * (pi / 2));
  return {h.cosine * u - h.sine * w,
          h.sine * u + h.cosine * w,
          lap * 2 * pi + side * (pi / 2) + turned,
          speed,
          straight ? 0 : speed,
          0,
          0};
}

}  // namespace detail

// The path of scale 1 at a phase [rad] that grows at `rate` [rad/s] and by 2 pi a lap.
inline PathPoint path_point(Curve curve, int cusps, double phase, double rate) {
  const Heading<double> h = detail::Real::heading(phase);
  const double c = h.cosine;
  const double s = h.sine;
  constexpr double per_radian = 6 / (2 * detail::Real::pi);
  switch (curve) {
    case Curve::ranunculoid:
      return detail::epicycloid(phase, rate, cusps);
    case Curve::circle:
      return {2 * c, 2 * s, phase + detail::Real::pi / 2, 2 * rate, rate, 0, 0};
    case Curve::lemniscate:
      return detail::from_jet(detail::lemniscate(phase), rate);
    case Curve::eight:
      return detail::from_jet({{2 * s, 2 * c, -2 * s, -2 * c},
                               {2 * s * c, 2 * (c * c - s * s), -8 * s * c, -8 * (c * c - s * s)}},
                              rate);
    case Curve::sine:
      return detail::from_jet({{per_radian * phase, per_radian, 0, 0}, {s, c, -s, -c}}, rate);
    case Curve::rounded_square:
      return detail::rounded_square(phase, rate);
    case Curve::line:
    case Curve::samples:
      break;
  }
  return {per_radian * phase, 0, 0, per_radian * rate, 0, 0, 0};
}

}  // namespace nfopidn
