// L2. The numbers of the tracking law besides its taps, in the order in which searches and lanes
// hand them over. docs/theory.md has the equations.
#pragma once

#include "nfopidn/control/controller_settings.hpp"

namespace nfopidn {

// Taps and proportional gains are those of the net divided by the channel's amplitude S, so that
// the neuron is O = S tanh(net / 2).
template <class Scalar>
struct LawParameters {
  using Base = base_t<Scalar>;

  Scalar proportional_x = Scalar(Base(0));      // of the error, beside taps that act on the
  Scalar proportional_theta = Scalar(Base(0));  // speed error
  Scalar amplitude_x = Scalar(Base(1));         // S [N m]
  Scalar amplitude_y = Scalar(Base(1));
  Scalar amplitude_theta = Scalar(Base(1));
  Scalar pole_x = Scalar(Base(0));
  Scalar pole_theta = Scalar(Base(0));
  Scalar integral_x = Scalar(Base(0));
  Scalar integral_y = Scalar(Base(0));
  Scalar integral_theta = Scalar(Base(0));
  Scalar integral_retention = Scalar(Base(1));
  Scalar integral_limit = Scalar(Base(1));        // [N m]
  Scalar lateral_speed_square = Scalar(Base(1));  // v0^2 [m^2/s^2]
  Scalar minus_half_lateral_power = Scalar(Base(0));

  static constexpr int count = 14;
  static constexpr const char* names[count] = {"proportional_x",       "proportional_theta",
                                               "amplitude_x",          "amplitude_y",
                                               "amplitude_theta",      "pole_x",
                                               "pole_theta",           "integral_x",
                                               "integral_y",           "integral_theta",
                                               "integral_retention",   "integral_limit",
                                               "lateral_speed_square", "minus_half_lateral_power"};

  // Calls visit(parameter) for each in its order.
  template <class Self, class Visitor>
  static constexpr void each(Self& self, Visitor&& visit) {
    visit(self.proportional_x);
    visit(self.proportional_theta);
    visit(self.amplitude_x);
    visit(self.amplitude_y);
    visit(self.amplitude_theta);
    visit(self.pole_x);
    visit(self.pole_theta);
    visit(self.integral_x);
    visit(self.integral_y);
    visit(self.integral_theta);
    visit(self.integral_retention);
    visit(self.integral_limit);
    visit(self.lateral_speed_square);
    visit(self.minus_half_lateral_power);
  }
};

// Parameters in another number type, from as many numbers in their order.
template <class Scalar, class Number, class Convert>
constexpr LawParameters<Scalar> law_parameters_from(const Number* numbers, const Convert& convert) {
  LawParameters<Scalar> law;
  LawParameters<Scalar>::each(law, [&](Scalar& parameter) { parameter = convert(*numbers++); });
  return law;
}

// How many numbers a law is made of: its taps, [3][taps], and then the parameters if it has any.
template <class Base>
constexpr int law_size(const ControllerSettings<Base>& settings, int taps) {
  return channel_count * taps + (settings.needs_tracking_law() ? LawParameters<Base>::count : 0);
}

// What the tracking law is made of, in any number type: values of the settings of these names.
template <class Number>
struct TrackingGains {
  Number speed_gain_x, speed_gain_theta, speed_order_x, speed_order_theta;
  Number amplitude_x, amplitude_y, amplitude_theta;
  Number pole_x, pole_theta;
  Number integral_x, integral_y, integral_theta, integral_retention, integral_limit;
  Number lateral_speed, lateral_power;
};

template <class Number, class Base>
constexpr TrackingGains<Number> tracking_gains(const ControllerSettings<Base>& s) {
  const auto number = [](Base value) { return Number(base_t<Number>(value)); };
  return {number(s.speed_gain_x),       number(s.speed_gain_theta), number(s.speed_order_x),
          number(s.speed_order_theta),  number(s.amplitude_x),      number(s.amplitude_y),
          number(s.amplitude_theta),    number(s.pole_x),           number(s.pole_theta),
          number(s.integral_x),         number(s.integral_y),       number(s.integral_theta),
          number(s.integral_retention), number(s.integral_limit),   number(s.lateral_speed),
          number(s.lateral_power)};
}

// Taps, [3][memory + 2], and parameters of a law. gains: [3][3] as in eq. 34, alpha and sigma: [3];
// `work` is memory + 2 scalars of scratch. `settings` tells the variant, its numbers do not matter.
template <class Number, class Base>
constexpr LawParameters<Number> fuse_law(const ControllerSettings<Base>& settings,
                                         const Number* gains, const Number* alpha,
                                         const Number* sigma, const TrackingGains<Number>& tracking,
                                         Number* taps, Number* work) {
  using NumberBase = base_t<Number>;
  const int memory = settings.memory;
  const Number one = Number(NumberBase(1));
  const Number share[] = {one / tracking.amplitude_x, one / tracking.amplitude_y,
                          one / tracking.amplitude_theta};
  LawParameters<Number> law;
  for (int channel = 0; channel < channel_count; ++channel) {
    Number* own = taps + channel * (memory + 2);
    const Number* g = gains + 3 * channel;
    if (settings.net == Net::increment) {
      fuse_taps(settings.generator, g[0], g[1], g[2], alpha[channel], sigma[channel], memory, own,
                work);
    } else if (settings.net == Net::whole || channel == 1) {
      fuse_whole_taps(settings.generator, g[0], g[1], g[2], alpha[channel], sigma[channel], memory,
                      own, work);
    } else if (channel == 0) {
      fuse_speed_taps(tracking.speed_gain_x, tracking.speed_order_x, memory, own);
      law.proportional_x = g[0] * share[0];
    } else {
      fuse_speed_taps(tracking.speed_gain_theta, tracking.speed_order_theta, memory, own);
      law.proportional_theta = g[0] * share[2];
    }
    for (int j = 0; j < memory + 2; ++j) own[j] = own[j] * share[channel];
  }
  law.amplitude_x = tracking.amplitude_x;
  law.amplitude_y = tracking.amplitude_y;
  law.amplitude_theta = tracking.amplitude_theta;
  law.pole_x = tracking.pole_x;
  law.pole_theta = tracking.pole_theta;
  law.integral_x = tracking.integral_x;
  law.integral_y = tracking.integral_y;
  law.integral_theta = tracking.integral_theta;
  law.integral_retention = tracking.integral_retention;
  law.integral_limit = tracking.integral_limit;
  law.lateral_speed_square = tracking.lateral_speed * tracking.lateral_speed;
  law.minus_half_lateral_power = tracking.lateral_power * NumberBase(-0.5);
  return law;
}

}  // namespace nfopidn
