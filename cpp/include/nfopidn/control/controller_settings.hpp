// L2. The controller's settings. A variant of the law is a setting here, never a copy of it.
#pragma once

#include "nfopidn/control/operator_weights.hpp"
#include "nfopidn/control/tap_filter.hpp"

namespace nfopidn {

enum class Form : unsigned char {
  positional,   // the neuron's output is the torque
  incremental,  // it is added to the last torque, as eqs. 35-36 print it: integral action
};
enum class Activation : unsigned char {
  sigmoid,  // eq. 33
  linear,   // O = net: a plain fractional PID
};
enum class Frame : unsigned char { robot, world };
enum class Lateral : unsigned char {
  plain,      // e_y
  direction,  // -e_y where the reference drives in reverse
  speed,      // e_y V_r / speed_scale
  scheduled,  // e_y V_r (V_r^2 + lateral_speed^2)^(-lateral_power / 2)
};
enum class AntiWindup : unsigned char { none, hold, clamp };
enum class Net : unsigned char {
  increment,     // eq. 34: its sums run over differences of the error
  whole,         // they run over the error itself
  speed_errors,  // whole, and in x and theta the derivative is taken of the speed error
};

template <>
struct ChoiceNames<Form> {
  static constexpr const char* names[] = {"positional", "incremental"};
};
template <>
struct ChoiceNames<Activation> {
  static constexpr const char* names[] = {"sigmoid", "linear"};
};
template <>
struct ChoiceNames<Frame> {
  static constexpr const char* names[] = {"robot", "world"};
};
template <>
struct ChoiceNames<Lateral> {
  static constexpr const char* names[] = {"plain", "direction", "speed", "scheduled"};
};
template <>
struct ChoiceNames<Net> {
  static constexpr const char* names[] = {"increment", "whole", "speed-errors"};
};
template <>
struct ChoiceNames<AntiWindup> {
  static constexpr const char* names[] = {"none", "hold", "clamp"};
};

// The named allocations need no multiplications; the result is the same to the last bit.
enum class AllocationKind : unsigned char { paper, decoupled, any };

// Which neuron drives which wheel: rows left, right; columns x, y, theta.
template <class Base>
struct Allocation {
  Base matrix[2][channel_count];

  static constexpr Allocation paper() {  // eqs. 31-32
    return {{{Base(0), Base(1), Base(1)}, {Base(1), Base(1), Base(0)}}};
  }
  static constexpr Allocation decoupled() {  // x drives, y and theta steer
    return {{{Base(1), Base(1), Base(1)}, {Base(1), Base(-1), Base(-1)}}};
  }

  constexpr AllocationKind kind() const {
    if (equals(paper())) return AllocationKind::paper;
    return equals(decoupled()) ? AllocationKind::decoupled : AllocationKind::any;
  }
  constexpr bool equals(const Allocation& other) const {
    for (int row = 0; row < 2; ++row) {
      for (int column = 0; column < channel_count; ++column) {
        if (matrix[row][column] != other.matrix[row][column]) return false;
      }
    }
    return true;
  }
};

constexpr int maximum_memory = 1024;            // of a plain filter
constexpr int maximum_long_memory = 1'000'000;  // on the host, where the tail runs as modes
constexpr int infinite_memory = 2'000'000'000;  // in the place of a number of samples

// A number of samples M, or infinite.
struct Memory {
  int samples;

  constexpr Memory(int count) : samples(count) {}
  constexpr operator int() const { return samples; }
  constexpr bool is_infinite() const { return samples == infinite_memory; }
  constexpr bool is_long() const { return samples > maximum_memory; }
};

// The sample time that gains or taps are made for [s]. 0 stands for unknown: such a controller fits
// any. It is read where a run, a search or an export is set up, and never by the control step.
template <class Base>
struct SampleTime {
  Base seconds = Base(0);

  constexpr SampleTime() = default;
  constexpr SampleTime(Base time) : seconds(time) {}
  constexpr bool has_value() const { return seconds != Base(0); }
  constexpr const Base& operator*() const { return seconds; }
};

// A lesser divisor of V_r counts as this one: 1/1e-40 is no float.
constexpr double least_speed_scale = 1e-9;  // [m/s]

// What a controller is told about the scenario it runs in.
template <class Base = double>
struct ControlLimits {
  Base torque = Base(3.078);   // of each wheel, feedforward included [N m]
  Base speed_scale = Base(1);  // the trajectory's peak |V_r| [m/s], for Lateral::speed
  Base sample_time = Base(0);  // [s], for Net::speed_errors; 0: not known
};

template <class Base>
struct ControllerSettings;

template <class Base>
constexpr Finding check_tracking_law(const ControllerSettings<Base>& settings) noexcept;

template <class Base = double>
struct ControllerSettings {
  // Discrete gains of eq. 34; rows x, y, theta; columns kp, ki, kd. Default: the paper's Table 3.
  Base gains[channel_count][3] = {{Base(0.2797), Base(0.7614), Base(0.8477)},
                                  {Base(0.7177), Base(0.2782), Base(0.3294)},
                                  {Base(1.0707), Base(1.3720), Base(0.1827)}};
  Base alpha[channel_count] = {Base(0.1078), Base(0.1078), Base(0.1078)};
  Base sigma[channel_count] = {Base(0.8161), Base(0.8161), Base(0.8161)};
  Memory memory = 5;
  Form form = Form::positional;
  Allocation<Base> allocation = Allocation<Base>::paper();
  Activation activation = Activation::sigmoid;
  Frame frame = Frame::robot;
  Generator generator = Generator::tustin;
  Lateral lateral = Lateral::direction;
  Base speed_scale = Base(0);
  AntiWindup anti_windup = AntiWindup::none;
  SampleTime<Base> sample_time;

  // The tracking law (docs/theory.md): what it has besides eqs. 30-36. By default none of it acts.
  Net net = Net::increment;
  Base speed_gain_x = Base(0);
  Base speed_gain_theta = Base(0);
  Base speed_order_x = Base(1);
  Base speed_order_theta = Base(1);
  Base amplitude_x = Base(1);
  Base amplitude_y = Base(1);
  Base amplitude_theta = Base(1);
  Base pole_x = Base(0);
  Base pole_theta = Base(0);
  Base integral_x = Base(0);
  Base integral_y = Base(0);
  Base integral_theta = Base(0);
  Base integral_retention = Base(1);
  Base integral_limit = Base(1);
  Base lateral_speed = Base(0.25);
  Base lateral_power = Base(1.5);

  constexpr Status validate() const noexcept {
    const Status status = check_ranges(*this).status;
    return status != Status::ok ? status : check_tracking_law(*this).status;
  }
  constexpr bool has_pole() const { return pole_x != Base(0) || pole_theta != Base(0); }
  constexpr bool has_integral() const {
    return integral_x != Base(0) || integral_y != Base(0) || integral_theta != Base(0);
  }
  constexpr bool has_amplitude() const {
    return amplitude_x != Base(1) || amplitude_y != Base(1) || amplitude_theta != Base(1);
  }
  // Whether the controller needs what only a variant with the tracking law has.
  constexpr bool needs_tracking_law() const {
    return net != Net::increment || lateral == Lateral::scheduled || has_pole() || has_integral() ||
           has_amplitude();
  }

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using S = ControllerSettings;
    visit(field("gains", &S::gains, "N m", between(-1e6, 1e6),
                "discrete gains of eq. 34: rows x, y, theta; columns kp, ki, kd"));
    visit(field("alpha", &S::alpha, "", between(-2, 2),
                "order of the derivative, one for all channels or one each"));
    visit(field("sigma", &S::sigma, "", between(-2, 2),
                "order of the integral, one for all channels or one each"));
    visit(field("memory", &S::memory, "samples", between(0, maximum_long_memory),
                "terms M of the power series, or \"inf\""));
    visit(field("form", &S::form, "", any_number(),
                "the output is the torque, or is added to the last torque"));
    visit(field("allocation", &S::allocation, "", between(-1e3, 1e3),
                "which neuron drives which wheel: a name, or rows left, right of x, y, theta"));
    visit(field("activation", &S::activation, "", any_number(), "the neuron's function"));
    visit(field("frame", &S::frame, "", any_number(), "frame of the position errors"));
    visit(field("generator", &S::generator, "", any_number(),
                "power series that stands for s^alpha"));
    visit(field("lateral", &S::lateral, "", any_number(), "what the y channel is fed"));
    visit(field("anti_windup", &S::anti_windup, "", any_number(),
                "what the incremental form does at the torque limit"));
    visit(field("speed_scale", &S::speed_scale, "m/s", between(0, 1e6),
                "divisor of V_r with lateral \"speed\"; 0: the trajectory's peak |V_r|"));
    visit(field("sample_time", &S::sample_time, "s", greater_than(0),
                "that gains or taps are made for; null (in words: unknown): not checked"));
    visit(field("net", &S::net, "", any_number(),
                "what the sums of eq. 34 run over: differences of the error, or the error itself; "
                "speed-errors: and the derivative in x and theta is that of the speed error"));
    visit(field("speed_gain_x", &S::speed_gain_x, "N m/m", between(-1e6, 1e6),
                "gain of the derivative of the forward speed error, with net speed-errors"));
    visit(field("speed_gain_theta", &S::speed_gain_theta, "N m/rad", between(-1e6, 1e6),
                "gain of the derivative of the turn-rate error, with net speed-errors"));
    visit(field("speed_order_x", &S::speed_order_x, "", between(-1, 3),
                "order of that derivative in x, counted from the position"));
    visit(field("speed_order_theta", &S::speed_order_theta, "", between(-1, 3),
                "order of that derivative in theta, counted from the angle"));
    visit(field("amplitude_x", &S::amplitude_x, "N m", between(1e-6, 1e6),
                "amplitude of the neuron of x: O = S tanh(net / (2 S))"));
    visit(field("amplitude_y", &S::amplitude_y, "N m", between(1e-6, 1e6),
                "amplitude of the neuron of y"));
    visit(field("amplitude_theta", &S::amplitude_theta, "N m", between(1e-6, 1e6),
                "amplitude of the neuron of theta"));
    visit(field("pole_x", &S::pole_x, "", between(-0.999, 0.999),
                "pole of the drive: D(k) = O_x - pole_x D(k-1)"));
    visit(field("pole_theta", &S::pole_theta, "", between(-0.999, 0.999),
                "pole of the steering: R(k) = O_y + O_theta - pole_theta R(k-1)"));
    visit(field("integral_x", &S::integral_x, "N m/m", between(-1e6, 1e6),
                "gain of the integral state of the drive, beside the neuron"));
    visit(field("integral_y", &S::integral_y, "N m/m", between(-1e6, 1e6),
                "gain of the lateral error in the integral state of the steering"));
    visit(field("integral_theta", &S::integral_theta, "N m/rad", between(-1e6, 1e6),
                "gain of the heading error in the integral state of the steering"));
    visit(field("integral_retention", &S::integral_retention, "", between(0, 1),
                "share of an integral state that is left after a sample"));
    visit(field("integral_limit", &S::integral_limit, "N m", between(1e-9, 1e6),
                "limit of each integral state"));
    visit(field("lateral_speed", &S::lateral_speed, "m/s", between(1e-6, 1e6),
                "speed v0 of lateral \"scheduled\""));
    visit(field("lateral_power", &S::lateral_power, "", between(-10, 10),
                "power p of lateral \"scheduled\""));
  }
};

// A setting that must have one value beside the other settings.
template <class Base>
struct Demand {
  bool holds;  // whether the other settings ask for it
  const char* field;
  Base value;
  Base allowed;
};

template <class Base, int count>
constexpr Finding first_unmet(const Demand<Base> (&demands)[count]) noexcept {
  for (const Demand<Base>& demand : demands) {
    if (!demand.holds || demand.value == demand.allowed) continue;
    const double only = static_cast<double>(demand.allowed);
    return {Status::inconsistent, demand.field, static_cast<double>(demand.value),
            between(only, only)};
  }
  return {};
}

// What is wrong with the parts of the tracking law together, each being in range. The pole and the
// integral states act on drive and steering, which only the decoupled allocation has, and beside
// the neuron, whose output only the positional form gives to the wheels as it is.
template <class Base>
constexpr Finding check_tracking_law(const ControllerSettings<Base>& s) noexcept {
  const Base zero = Base(0), one = Base(1);
  const bool no_states =
      s.form != Form::positional || s.allocation.kind() != AllocationKind::decoupled;
  const bool linear = s.activation == Activation::linear;
  const bool speeds = s.net == Net::speed_errors;
  const Demand<Base> demands[] = {
      {no_states, "pole_x", s.pole_x, zero},
      {no_states, "pole_theta", s.pole_theta, zero},
      {no_states, "integral_x", s.integral_x, zero},
      {no_states, "integral_y", s.integral_y, zero},
      {no_states, "integral_theta", s.integral_theta, zero},
      {linear, "amplitude_x", s.amplitude_x, one},
      {linear, "amplitude_y", s.amplitude_y, one},
      {linear, "amplitude_theta", s.amplitude_theta, one},
      {!speeds, "speed_gain_x", s.speed_gain_x, zero},
      {!speeds, "speed_gain_theta", s.speed_gain_theta, zero},
      {speeds, "frame", s.frame == Frame::robot ? zero : one, zero},
      {speeds, "gains", s.gains[0][1], zero},  // ki and kd of x and theta
      {speeds, "gains", s.gains[0][2], zero},
      {speeds, "gains", s.gains[2][1], zero},
      {speeds, "gains", s.gains[2][2], zero},
  };
  return first_unmet(demands);
}

}  // namespace nfopidn
