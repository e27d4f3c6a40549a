// The controller's settings, for the board in float and for the host in double.
#pragma once

#include "nfopidn/firmware.hpp"

#ifndef CONTROL_MEMORY
#define CONTROL_MEMORY 5
#endif

template <class Base>
constexpr nfopidn::ControllerSettings<Base> control_settings() {
  nfopidn::ControllerSettings<Base> chosen;  // the paper's gains and orders
  chosen.memory = CONTROL_MEMORY;
#ifdef CONTROL_LINEAR
  chosen.activation = nfopidn::Activation::linear;
#endif
#ifdef CONTROL_TRACKING
  // Controller.recommended(), rounded.
  for (auto& row : chosen.gains) row[0] = row[1] = row[2] = Base(0);
  chosen.gains[0][0] = Base(1.966);
  chosen.gains[1][0] = Base(0.3174);
  chosen.gains[2][0] = Base(0.8814);
  chosen.allocation = nfopidn::Allocation<Base>::decoupled();
  chosen.lateral = nfopidn::Lateral::scheduled;
  chosen.net = nfopidn::Net::speed_errors;
  chosen.speed_gain_x = Base(12.40);
  chosen.speed_gain_theta = Base(2.802);
  chosen.speed_order_x = Base(1.137);
  chosen.speed_order_theta = Base(1.256);
  chosen.amplitude_x = Base(0.6484);
  chosen.amplitude_y = Base(7.890);
  chosen.amplitude_theta = Base(0.2327);
  chosen.pole_x = Base(0.0829);
  chosen.pole_theta = Base(0.2395);
  chosen.integral_x = Base(0.02229);
  chosen.integral_y = Base(0.001684);
  chosen.integral_theta = Base(0.001009);
  chosen.integral_retention = Base(0.9925);
  chosen.integral_limit = Base(0.1546);
  chosen.lateral_speed = Base(0.2231);
  chosen.lateral_power = Base(1.553);
  chosen.sample_time = Base(0.2);
#endif
  return chosen;
}
