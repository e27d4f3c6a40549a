// L4. The parameters that a search for the tracking law has: their names, bounds and scales.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "nfopidn/control/controller_design.hpp"
#include "nfopidn/control/law_parameters.hpp"
#include "nfopidn/foundation/host.hpp"
#include "nfopidn/simulation/scenario.hpp"

namespace nfopidn {

struct ParameterBounds {
  std::string name;
  double low;
  double high;
  double power = -1;  // of Box; -1: tuning_powers() chooses
};

// What gains of the tracking law are in proportion to: docs/theory.md has the rules.
struct TrackingScale {
  Robot<double> robot;                     // the paper's
  double sample_time = 0.2;                // [s]
  double torque_limit = 3.078;             // [N m]
  double peak_speed = 0.3350698998007755;  // of the reference [m/s]; the published scenario's
};

NFOPIDN_HOST TrackingScale tracking_scale(const Scenario& scenario);

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

// The searched speed gains and orders are those of the error's own derivative where the net is made
// of errors alone, so that a search can tell what the speed errors are worth.
template <class Number>
void use_net(Net net, LawNumbers<Number>& law) {
  if (net != Net::whole) return;
  law.gains[2] = law.tracking.speed_gain_x;
  law.gains[8] = law.tracking.speed_gain_theta;
  law.alpha[0] = law.tracking.speed_order_x;
  law.alpha[2] = law.tracking.speed_order_theta;
  const Number zero = Number(base_t<Number>(0));
  law.tracking.speed_gain_x = law.tracking.speed_gain_theta = zero;
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

// A ratio, or 1 where the two differ by roundings alone: the paper's scenario has the paper's box.
inline double scale_ratio(double value, double paper) {
  const double ratio = value / paper;
  return std::abs(ratio - 1) < 1e-9 ? 1 : ratio;
}

// How much larger a parameter of this unit is than on the paper's robot in the paper's scenario.
inline double tracking_factor(TrackingUnit unit, const TrackingScale& scale) {
  const TrackingScale paper;
  const auto drive = [](const Robot<double>& robot) { return robot.mass * robot.wheel_radius; };
  const auto steer = [](const Robot<double>& robot) {
    return robot.inertia * robot.wheel_radius / robot.track_width;
  };
  const double pace = scale_ratio(scale.sample_time, paper.sample_time);
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
      return scale_ratio(scale.torque_limit, paper.torque_limit);
    case TrackingUnit::speed:
      return scale_ratio(scale.peak_speed, paper.peak_speed);
    default:
      return 1;
  }
}

// A parameter of the paper's robot in the paper's scenario, for another.
inline double scaled_parameter(TrackingUnit unit, double value, const TrackingScale& scale) {
  if (unit != TrackingUnit::retention) return value * tracking_factor(unit, scale);
  const double pace = scale_ratio(scale.sample_time, TrackingScale().sample_time);
  return pace == 1 ? value : std::pow(value, pace);
}

NFOPIDN_HOST std::vector<ParameterBounds> tracking_bounds(const TrackingScale& scale);

// Writes a vector of parameters into settings, and reads it from them.
NFOPIDN_HOST void set_tracking_parameters(ControllerSettings<double>& s,
                                          const std::vector<double>& x);
NFOPIDN_HOST std::vector<double> tracking_parameters(const ControllerSettings<double>& settings);

// Parameters found for the paper's robot in the paper's scenario, for another.
NFOPIDN_HOST std::vector<double> scaled_tracking_parameters(std::vector<double> x,
                                                            const TrackingScale& scale);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_STRUCTURES

namespace nfopidn {

NFOPIDN_HOST TrackingScale tracking_scale(const Scenario& scenario) {
  const Trajectory& path = scenario.trajectory;
  return {scenario.robot, path.dt(), scenario.torque_limit,
          std::max(path.peak_speed(), least_speed_scale)};
}

NFOPIDN_HOST std::vector<ParameterBounds> tracking_bounds(const TrackingScale& scale) {
  std::vector<ParameterBounds> bounds;
  LawNumbers<double> law = {};
  TrackingNames<double>::each(law, [&](const char* name, double&, const TrackingBound& bound) {
    bounds.push_back({name, scaled_parameter(bound.unit, bound.low, scale),
                      scaled_parameter(bound.unit, bound.high, scale), bound.power});
  });
  return bounds;
}

NFOPIDN_HOST void set_tracking_parameters(ControllerSettings<double>& s,
                                          const std::vector<double>& x) {
  LawNumbers<double> law = law_numbers<double>(s);
  const double* next = x.data();
  TrackingNames<double>::each(
      law, [&](const char*, double& number, const TrackingBound&) { number = *next++; });
  use_net(s.net, law);
  for (int channel = 0; channel < channel_count; ++channel) {
    std::copy_n(law.gains + std::ptrdiff_t{3} * channel, 3, s.gains[channel]);
  }
  std::copy_n(law.alpha, channel_count, s.alpha);
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

NFOPIDN_HOST std::vector<double> tracking_parameters(const ControllerSettings<double>& settings) {
  LawNumbers<double> law = law_numbers<double>(settings);
  if (settings.net == Net::whole) {
    law.tracking.speed_gain_x = law.gains[2];
    law.tracking.speed_gain_theta = law.gains[8];
    law.tracking.speed_order_x = law.alpha[0];
    law.tracking.speed_order_theta = law.alpha[2];
  }
  std::vector<double> x;
  TrackingNames<double>::each(
      law, [&](const char*, double& number, const TrackingBound&) { x.push_back(number); });
  return x;
}

NFOPIDN_HOST std::vector<double> scaled_tracking_parameters(std::vector<double> x,
                                                            const TrackingScale& scale) {
  LawNumbers<double> law = {};
  double* next = x.data();
  TrackingNames<double>::each(law, [&](const char*, double&, const TrackingBound& bound) {
    *next = scaled_parameter(bound.unit, *next, scale);
    ++next;
  });
  return x;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_STRUCTURES
