// What the tests share: draws, bit equality, tables, scenarios, and literal transcriptions of the
// design's equations in long double, made without the library's recursions and kernels.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "nfopidn/simulation/simulate.hpp"

namespace nfopidn::test {

using Real = long double;
using Scalars = ::testing::Types<double, float>;

constexpr Real pi = 3.14159265358979323846264338327950288L;

// One unit in the last place of 1.
template <class Scalar>
constexpr Real unit = std::numeric_limits<Scalar>::epsilon();
template <class Scalar>
constexpr Scalar infinite = std::numeric_limits<Scalar>::infinity();
template <class Scalar>
constexpr Scalar not_a_number = std::numeric_limits<Scalar>::quiet_NaN();

// Draws of the tests' own, so that no test rests on the library's Random.
class Draws {
 public:
  explicit Draws(std::uint64_t seed) : engine_(seed) {}
  double between(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  template <class Scalar>
  Scalar scalar(double low, double high) {
    return static_cast<Scalar>(between(low, high));
  }

 private:
  std::mt19937_64 engine_;
};

// |value - expected| <= bound; false for what is not a number.
inline ::testing::AssertionResult near(Real value, Real expected, Real bound) {
  if (std::fabs(value - expected) <= bound) return ::testing::AssertionSuccess();
  std::ostringstream text;
  text.precision(20);
  text << value << " against " << expected << ", apart by " << std::fabs(value - expected)
       << ", allowed " << bound;
  return ::testing::AssertionFailure() << text.str();
}

// Bit for bit, of anything without padding.
template <class Value>
bool same_bits(const Value& a, const Value& b) {
  return std::memcmp(&a, &b, sizeof(Value)) == 0;
}
inline bool same_bits(const RunTable& a, const RunTable& b) {
  return a.rows() == b.rows() &&
         std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

struct CsvTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> rows;
};

inline CsvTable read_golden_csv(const std::string& file) {
  std::ifstream in(std::string(NFOPIDN_GOLDEN "/") + file);
  EXPECT_TRUE(in.good()) << file;
  CsvTable table;
  std::string line;
  std::string cell;
  std::getline(in, line);
  for (std::istringstream header(line); std::getline(header, cell, ',');) {
    table.names.push_back(cell);
  }
  while (std::getline(in, line)) {
    table.rows.emplace_back();
    for (std::istringstream row(line); std::getline(row, cell, ',');) {
      table.rows.back().push_back(std::stod(cell));
    }
  }
  return table;
}

inline Trajectory make(const TrajectorySettings& settings) {
  Trajectory trajectory;
  EXPECT_EQ(make_trajectory(settings, trajectory), Status::ok);
  return trajectory;
}

// A lap of 30 s at half size, with reversing at the cusps, from a start beside the path.
inline Scenario short_scenario() {
  TrajectorySettings settings;
  settings.period = 30;
  settings.scale = 0.5;
  settings.heading = HeadingChoice::continuous;
  Scenario scenario;
  scenario.trajectory = make(settings);
  scenario.initial_pose = {1.6, 0.1, 0.3};
  return scenario;
}

// Gains that hold the short scenario without diverging, in either output form.
inline ControllerSettings<double> steady_settings(Form form) {
  ControllerSettings<double> settings;
  settings.form = form;
  settings.allocation = Allocation<double>::decoupled();
  const double incremental[3][3] = {{0.03, 0.002, 2.3}, {0.001, 0.06, 0.02}, {0.03, 0.02, 1.6}};
  for (int channel = 0; channel < channel_count; ++channel) {
    const bool adds = form == Form::incremental;
    settings.gains[channel][0] = adds ? incremental[channel][0] : 1.0;
    settings.gains[channel][1] = adds ? incremental[channel][1] : 0.1;
    settings.gains[channel][2] = adds ? incremental[channel][2] : 0.3;
    settings.alpha[channel] = adds ? 0.3 : 0.6;
    settings.sigma[channel] = adds ? 0.95 : 0.8;
  }
  return settings;
}

// What a field of a settings struct can be turned to, and what must hold for it to matter.
template <class Settings>
struct Knob {
  std::vector<std::function<void(Settings&)>> turns;
  std::function<void(Settings&)> given = [](Settings&) {};
};
template <class Settings>
using Knobs = std::map<std::string, Knob<Settings>>;

// Calls check(name, base, turned) for every turn of every field of the schema; a field without a
// test value fails.
template <class Settings, class Check>
void turn_every_knob(const Settings& start, const Knobs<Settings>& knobs, const Check& check) {
  std::size_t visited = 0;
  Settings::fields([&](const auto& field) {
    const auto knob = knobs.find(field.name);
    if (knob == knobs.end() || knob->second.turns.empty()) {
      ADD_FAILURE() << "no test value for the field " << field.name;
      return;
    }
    ++visited;
    Settings base = start;
    knob->second.given(base);
    for (const auto& turn : knob->second.turns) {
      Settings turned = base;
      turn(turned);
      check(field.name, base, turned);
    }
  });
  EXPECT_EQ(visited, knobs.size()) << "a test value belongs to no field";
}

// A turn to each value of a choice but its first, which the base must have.
template <class Settings, class Choice>
std::vector<std::function<void(Settings&)>> all_choices(Choice Settings::*member) {
  std::vector<std::function<void(Settings&)>> turns;
  const auto count = std::size(ChoiceNames<Choice>::names);
  for (std::size_t i = 1; i < count; ++i) {
    turns.push_back([member, i](Settings& settings) { settings.*member = static_cast<Choice>(i); });
  }
  return turns;
}

// C(order, j), and from it the generating functions' weights.
inline Real binomial(Real order, int j) {
  Real value = 1;
  for (int i = 1; i <= j; ++i) value *= (order - (i - 1)) / i;
  return value;
}
inline Real literal_weight(Generator generator, Real order, int j) {
  const auto gl = [](Real power, int i) { return (i % 2 == 0 ? 1 : -1) * binomial(power, i); };
  if (generator == Generator::gl) return gl(order, j);
  Real sum = 0;
  for (int i = 0; i <= j; ++i) sum += gl(order, i) * binomial(-order, j - i);
  return sum;
}

// The three sums of eq. 34 over all errors so far, oldest first.
template <class Scalar>
Real literal_net(Generator generator, const Scalar (&gains)[3], Scalar alpha, Scalar sigma,
                 int memory, const std::vector<Real>& errors) {
  const auto e = [&](int back) {
    const auto size = static_cast<int>(errors.size());
    return back < size ? errors[static_cast<std::size_t>(size - 1 - back)] : Real(0);
  };
  Real net = gains[0] * (e(0) - e(1));
  for (int j = 0; j <= memory; ++j) {
    net += gains[2] * literal_weight(generator, alpha, j) * (e(j) - e(j + 1));
    const Real pair = generator == Generator::tustin ? e(j) + e(j + 1) : e(j);
    net += gains[1] * literal_weight(generator, Real(1) - sigma, j) * pair;
  }
  return net;
}

template <class Scalar>
Measurement<Scalar> random_measurement(Draws& draw) {
  return {draw.scalar<Scalar>(-1, 1), draw.scalar<Scalar>(-1, 1), draw.scalar<Scalar>(-3, 3),
          draw.scalar<Scalar>(-1, 1), draw.scalar<Scalar>(-1, 1)};
}
template <class Scalar>
ReferenceSample<Scalar> random_reference(Draws& draw) {
  return {draw.scalar<Scalar>(-1, 1),     draw.scalar<Scalar>(-1, 1),
          draw.scalar<Scalar>(-3, 3),     draw.scalar<Scalar>(-1, 1),
          draw.scalar<Scalar>(-1, 1),     draw.scalar<Scalar>(-0.3, 0.3),
          draw.scalar<Scalar>(-0.3, 0.3), draw.between(-1, 1) < 0};
}
template <class Scalar>
ControllerSettings<Scalar> random_settings(Draws& draw) {
  ControllerSettings<Scalar> settings;
  for (int channel = 0; channel < channel_count; ++channel) {
    for (Scalar& gain : settings.gains[channel]) gain = draw.scalar<Scalar>(-1.5, 1.5);
    settings.alpha[channel] = draw.scalar<Scalar>(0, 2);
    settings.sigma[channel] = draw.scalar<Scalar>(0, 2);
    for (auto& row : settings.allocation.matrix) row[channel] = draw.scalar<Scalar>(-1, 1);
  }
  return settings;
}

// Sections 2.3 and 2.4 of the design, word for word.
template <class Scalar>
struct LiteralLaw {
  ControllerSettings<Scalar> settings;
  ControlLimits<Scalar> limits;
  std::vector<Real> errors[channel_count] = {};
  std::array<Real, 2> feedback = {0, 0};

  std::array<Real, 2> step(const Measurement<Scalar>& measured,
                           const ReferenceSample<Scalar>& reference) {
    const Real x = Real(reference.x) - measured.x;
    const Real y = Real(reference.y) - measured.y;
    const Real turn = Real(reference.theta) - measured.theta;
    const bool robot = settings.frame == Frame::robot;
    const Real cosine = robot ? std::cos(Real(measured.theta)) : Real(1);
    const Real sine = robot ? std::sin(Real(measured.theta)) : Real(0);
    Real lateral = cosine * y - sine * x;
    if (settings.lateral == Lateral::direction && reference.reverse) lateral = -lateral;
    if (settings.lateral == Lateral::speed) {
      lateral *= reference.v /
                 (settings.speed_scale > 0 ? settings.speed_scale : Real(limits.speed_scale));
    }
    errors[0].push_back(cosine * x + sine * y);
    errors[1].push_back(lateral);
    errors[2].push_back(turn - 2 * pi * std::floor((turn + pi) / (2 * pi)));

    Real output[channel_count];
    for (int c = 0; c < channel_count; ++c) {
      const Real net = literal_net(settings.generator, settings.gains[c], settings.alpha[c],
                                   settings.sigma[c], settings.memory, errors[c]);
      output[c] = settings.activation == Activation::sigmoid ? 2 / (1 + std::exp(-net)) - 1 : net;
    }
    std::array<Real, 2> total = {};
    for (std::size_t wheel = 0; wheel < 2; ++wheel) {
      Real share = 0;
      for (int c = 0; c < channel_count; ++c) {
        share += settings.allocation.matrix[wheel][c] * output[c];
      }
      const Real feedforward = wheel == 0 ? reference.tau_left : reference.tau_right;
      feedback[wheel] = next_feedback(feedback[wheel], share, feedforward);
      total[wheel] = clip(feedforward + feedback[wheel], -Real(limits.torque), limits.torque);
    }
    return total;
  }

  static Real clip(Real value, Real low, Real high) { return std::min(std::max(value, low), high); }

  Real next_feedback(Real last, Real increment, Real feedforward) const {
    if (settings.form == Form::positional) return increment;
    const Real next = last + increment;
    const Real limit = limits.torque;
    const Real total = feedforward + next;
    switch (settings.anti_windup) {
      case AntiWindup::none:
        return next;
      case AntiWindup::hold:
        return (total > limit && increment > 0) || (total < -limit && increment < 0) ? last : next;
      case AntiWindup::clamp:
        return clip(next, std::min(last, -limit - feedforward),
                    std::max(last, limit - feedforward));
    }
    return next;
  }
};

}  // namespace nfopidn::test
