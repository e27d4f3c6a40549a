// L2. The controller's settings. A variant of the law is a setting here, never a copy of it.
#pragma once

#include "nfopidn/fir.hpp"
#include "nfopidn/weights.hpp"

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
};
enum class AntiWindup : unsigned char { none, hold, clamp };

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
  static constexpr const char* names[] = {"plain", "direction", "speed"};
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
};

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

  constexpr Status validate() const noexcept { return check_ranges(*this).status; }

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
  }
};

}  // namespace nfopidn
