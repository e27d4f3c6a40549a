// L2. Which variant of the law a controller runs: chosen at run time, or in the type, where a
// variant that is not chosen costs neither instructions nor memory.
#pragma once

#include "nfopidn/control/controller_settings.hpp"

namespace nfopidn {

// Chosen at run time, by Controller::configure().
template <class Base>
struct RuntimeVariant {
  Allocation<Base> allocation = Allocation<Base>::paper();
  AllocationKind allocation_kind = AllocationKind::paper;
  Form form = Form::positional;
  Activation activation = Activation::sigmoid;
  Frame frame = Frame::robot;
  Lateral lateral = Lateral::direction;
  AntiWindup anti_windup = AntiWindup::none;
  static constexpr bool has_tracking_law = false;

  static constexpr bool offers(const ControllerSettings<Base>& settings) noexcept {
    return !settings.needs_tracking_law();
  }
  constexpr void choose(const ControllerSettings<Base>& settings) noexcept {
    allocation = settings.allocation;
    allocation_kind = allocation.kind();
    form = settings.form;
    activation = settings.activation;
    frame = settings.frame;
    lateral = settings.lateral;
    anti_windup = settings.anti_windup;
  }
};

// The same with the tracking law, chosen at run time too.
template <class Base>
struct TrackingVariant : RuntimeVariant<Base> {
  Net net = Net::increment;
  static constexpr bool has_tracking_law = true;

  static constexpr bool offers(const ControllerSettings<Base>& /*settings*/) noexcept {
    return true;
  }
  constexpr void choose(const ControllerSettings<Base>& settings) noexcept {
    RuntimeVariant<Base>::choose(settings);
    net = settings.net;
  }
};

// Chosen in the type. Settings that ask for another structure are refused by
// Controller::configure() with Status::inconsistent. Default: the paper's.
template <class Base, Form fixed_form = Form::positional,
          AllocationKind fixed_allocation = AllocationKind::paper,
          Lateral fixed_lateral = Lateral::direction,
          AntiWindup fixed_anti_windup = AntiWindup::none,
          Activation fixed_activation = Activation::sigmoid, Frame fixed_frame = Frame::robot>
struct FixedVariant {
  static_assert(fixed_allocation != AllocationKind::any,
                "a matrix of its own is a setting of RuntimeVariant");
  static constexpr Allocation<Base> allocation = fixed_allocation == AllocationKind::paper
                                                     ? Allocation<Base>::paper()
                                                     : Allocation<Base>::decoupled();
  static constexpr AllocationKind allocation_kind = fixed_allocation;
  static constexpr Form form = fixed_form;
  static constexpr Activation activation = fixed_activation;
  static constexpr Frame frame = fixed_frame;
  static constexpr Lateral lateral = fixed_lateral;
  static constexpr AntiWindup anti_windup = fixed_anti_windup;
  static constexpr bool has_tracking_law = false;

  // Whether the settings ask for what is chosen here, the tracking law aside.
  static constexpr bool matches(const ControllerSettings<Base>& settings) noexcept {
    return settings.allocation.kind() == allocation_kind && settings.form == form &&
           settings.activation == activation && settings.frame == frame &&
           settings.lateral == lateral && settings.anti_windup == anti_windup;
  }
  static constexpr bool offers(const ControllerSettings<Base>& settings) noexcept {
    return !settings.needs_tracking_law() && matches(settings);
  }
  static constexpr void choose(const ControllerSettings<Base>& /*settings*/) noexcept {}
};

// A FixedVariant with the tracking law, whose net is chosen in the type too.
template <class Base, class Fixed, Net fixed_net = Net::speed_errors>
struct FixedTrackingVariant : Fixed {
  static constexpr Net net = fixed_net;
  static constexpr bool has_tracking_law = true;

  static constexpr bool offers(const ControllerSettings<Base>& settings) noexcept {
    return settings.net == net && Fixed::matches(settings);
  }
};

}  // namespace nfopidn
