// L4. The parameters that a search for the tracking law has: their names, bounds and scales.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/control/law_parameters.hpp"

namespace nfopidn {

struct ParameterBounds {
  std::string name;
  double low;
  double high;
  double power = -1;  // of Box; -1: tuning_powers() chooses
};

// What gains of the tracking law are in proportion to: docs/theory.md has the rules.
struct TrackingScale {
  Robot<double> robot;          // the paper's
  double sample_time = 0.2;     // [s]
  double torque_limit = 3.078;  // [N m]
  double peak_speed = 0.335;    // of the reference [m/s]
};

// All that a law with the tracking law is made of, in any number type.
template <class Number>
struct LawNumbers {
  Number gains[3 * channel_count];
  Number alpha[channel_count];
  Number sigma[channel_count];
  TrackingGains<Number> tracking;
};

template <class Number>
LawNumbers<Number> law_numbers(const ControllerSettings<double>& settings) {
  LawNumbers<Number> law = {};
  for (int channel = 0; channel < channel_count; ++channel) {
    for (int term = 0; term < 3; ++term) {
      law.gains[3 * channel + term] = Number(settings.gains[channel][term]);
    }
    law.alpha[channel] = Number(settings.alpha[channel]);
    law.sigma[channel] = Number(settings.sigma[channel]);
  }
  law.tracking = tracking_gains<Number>(settings);
  return law;
}

// What a parameter scales with when robot, sample time, limit or path are others.
enum class TrackingUnit : unsigned char {
  drive_gain,           // m r
  steer_gain,           // I r / L
  drive_speed_gain,     // m r / T
  steer_speed_gain,     // I r / (L T)
  drive_integral_gain,  // m r T
  steer_integral_gain,  // I r T / L
  torque,               // the torque limit
  speed,                // the reference's peak speed
  retention,            // keeps its time constant
  plain,
};

struct TrackingBound {
  double low, high, power;
  TrackingUnit unit;
};

// The searched parameters in their order: visit(name, number, bound for the paper's robot).
template <class Number>
struct TrackingNames {
  template <class Law, class Visitor>
  static void each(Law& law, Visitor&& visit) {
    using U = TrackingUnit;
    constexpr double cube = 3, logarithmic = 0, linear = 1;
    auto& t = law.tracking;
    visit("speed_gain_x", t.speed_gain_x, TrackingBound{0, 25, cube, U::drive_speed_gain});
    visit("kp_x", law.gains[0], TrackingBound{0, 6, cube, U::drive_gain});
    visit("speed_order_x", t.speed_order_x, TrackingBound{0.2, 1.6, linear, U::plain});
    visit("amplitude_x", t.amplitude_x, TrackingBound{0.05, 10, logarithmic, U::torque});
    visit("kp_y", law.gains[3], TrackingBound{0, 20, cube, U::steer_gain});
    visit("lateral_speed", t.lateral_speed, TrackingBound{0.02, 3, logarithmic, U::speed});
    visit("lateral_power", t.lateral_power, TrackingBound{-0.5, 2.5, linear, U::plain});
    visit("amplitude_y", t.amplitude_y, TrackingBound{0.05, 10, logarithmic, U::torque});
    visit("speed_gain_theta", t.speed_gain_theta, TrackingBound{0, 6, cube, U::steer_speed_gain});
    visit("kp_theta", law.gains[6], TrackingBound{0, 4, cube, U::steer_gain});
    visit("speed_order_theta", t.speed_order_theta, TrackingBound{0.2, 1.6, linear, U::plain});
    visit("amplitude_theta", t.amplitude_theta, TrackingBound{0.05, 10, logarithmic, U::torque});
    visit("pole_x", t.pole_x, TrackingBound{-0.6, 0.9, linear, U::plain});
    visit("pole_theta", t.pole_theta, TrackingBound{-0.6, 0.9, linear, U::plain});
    visit("integral_x", t.integral_x, TrackingBound{0, 1, cube, U::drive_integral_gain});
    visit("integral_y", t.integral_y, TrackingBound{0, 1, cube, U::steer_integral_gain});
    visit("integral_theta", t.integral_theta, TrackingBound{0, 1, cube, U::steer_integral_gain});
    visit("integral_retention", t.integral_retention, TrackingBound{0.8, 1, linear, U::retention});
    visit("integral_limit", t.integral_limit, TrackingBound{0.05, 3, logarithmic, U::torque});
  }
};

// How much larger a parameter of this unit is than on the paper's robot in the paper's scenario.
inline double tracking_factor(TrackingUnit unit, const TrackingScale& scale) {
  const TrackingScale paper;
  const auto drive = [](const Robot<double>& robot) { return robot.mass * robot.wheel_radius; };
  const auto steer = [](const Robot<double>& robot) {
    return robot.inertia * robot.wheel_radius / robot.track_width;
  };
  const double pace = scale.sample_time / paper.sample_time;
  switch (unit) {
    case TrackingUnit::drive_gain:
      return drive(scale.robot) / drive(paper.robot);
    case TrackingUnit::steer_gain:
      return steer(scale.robot) / steer(paper.robot);
    case TrackingUnit::drive_speed_gain:
      return drive(scale.robot) / drive(paper.robot) / pace;
    case TrackingUnit::steer_speed_gain:
      return steer(scale.robot) / steer(paper.robot) / pace;
    case TrackingUnit::drive_integral_gain:
      return drive(scale.robot) / drive(paper.robot) * pace;
    case TrackingUnit::steer_integral_gain:
      return steer(scale.robot) / steer(paper.robot) * pace;
    case TrackingUnit::torque:
      return scale.torque_limit / paper.torque_limit;
    case TrackingUnit::speed:
      return scale.peak_speed / paper.peak_speed;
    default:
      return 1;
  }
}

inline std::vector<ParameterBounds> tracking_bounds(const TrackingScale& scale) {
  std::vector<ParameterBounds> bounds;
  LawNumbers<double> law = {};
  TrackingNames<double>::each(law, [&](const char* name, double&, const TrackingBound& bound) {
    const double factor = tracking_factor(bound.unit, scale);
    double low = bound.low * factor;
    if (bound.unit == TrackingUnit::retention) {
      low = std::pow(low, scale.sample_time / TrackingScale().sample_time);
    }
    bounds.push_back({name, low, bound.high * factor, bound.power});
  });
  return bounds;
}

// Writes a vector of parameters into settings, and reads it from them.
inline void set_tracking_parameters(ControllerSettings<double>& s, const std::vector<double>& x) {
  LawNumbers<double> law = law_numbers<double>(s);
  const double* next = x.data();
  TrackingNames<double>::each(
      law, [&](const char*, double& number, const TrackingBound&) { number = *next++; });
  s.gains[0][0] = law.gains[0];
  s.gains[1][0] = law.gains[3];
  s.gains[2][0] = law.gains[6];
  const TrackingGains<double>& t = law.tracking;
  s.speed_gain_x = t.speed_gain_x;
  s.speed_gain_theta = t.speed_gain_theta;
  s.speed_order_x = t.speed_order_x;
  s.speed_order_theta = t.speed_order_theta;
  s.amplitude_x = t.amplitude_x;
  s.amplitude_y = t.amplitude_y;
  s.amplitude_theta = t.amplitude_theta;
  s.pole_x = t.pole_x;
  s.pole_theta = t.pole_theta;
  s.integral_x = t.integral_x;
  s.integral_y = t.integral_y;
  s.integral_theta = t.integral_theta;
  s.integral_retention = t.integral_retention;
  s.integral_limit = t.integral_limit;
  s.lateral_speed = t.lateral_speed;
  s.lateral_power = t.lateral_power;
}
inline std::vector<double> tracking_parameters(const ControllerSettings<double>& settings) {
  LawNumbers<double> law = law_numbers<double>(settings);
  std::vector<double> x;
  TrackingNames<double>::each(
      law, [&](const char*, double& number, const TrackingBound&) { x.push_back(number); });
  return x;
}

}  // namespace nfopidn
