// L3. A sampled reference trajectory.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/parallel/standard_arithmetic.hpp"
#include "nfopidn/simulation/curves.hpp"

namespace nfopidn {

enum class HeadingChoice : unsigned char {
  forward,     // along the motion (eq. 44); jumps by pi at a cusp
  continuous,  // the robot reverses at a cusp, and nothing jumps
};
enum class Derivatives : unsigned char {
  sampled,   // second-order central differences, one-sided at the ends, as eq. 44's Delta
  analytic,  // closed forms
};
template <>
struct ChoiceNames<HeadingChoice> {
  static constexpr const char* names[] = {"forward", "continuous"};
};
template <>
struct ChoiceNames<Derivatives> {
  static constexpr const char* names[] = {"sampled", "analytic"};
};

constexpr int minimum_samples = 3;
constexpr int maximum_samples = 10'000'000;

struct TrajectorySettings {
  Curve name = Curve::ranunculoid;
  double period = 150;
  double dt = 0.2;
  int cusps = 3;
  HeadingChoice heading = HeadingChoice::forward;
  double scale = 1;
  int laps = 1;
  Derivatives derivatives = Derivatives::sampled;
  std::optional<double> standstill_speed;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using T = TrajectorySettings;
    visit(field("name", &T::name, "", any_number(), "the path", "traj"));
    visit(field("period", &T::period, "s", between(1e-3, 1e9), "time of one lap"));
    visit(field("dt", &T::dt, "s", between(1e-6, 1e3), "sample time T"));
    visit(field("cusps", &T::cusps, "", between(1, 50), "cusps of the ranunculoid"));
    visit(field("heading", &T::heading, "", any_number(),
                "along the motion, or continuous through the cusps"));
    visit(field("scale", &T::scale, "", between(1e-3, 1e6), "size of the path"));
    visit(field("laps", &T::laps, "", between(1, 1e6), "number of laps"));
    visit(field("derivatives", &T::derivatives, "", any_number(),
                "by differences of the samples, or closed forms"));
    visit(field("standstill_speed", &T::standstill_speed, "m/s", between(0, 1e3),
                "slower, the heading of the motion holds; null (in words: resolution): what the "
                "positions of a path of samples resolve"));
  }
};

// Samples at k dt. The heading is unwrapped and v signed along it.
struct Trajectory {
  TrajectorySettings settings;
  Eigen::ArrayXd x, y;                             // [m]
  Eigen::ArrayXd theta;                            // [rad]
  Eigen::ArrayXd v, omega;                         // [m/s], [rad/s]
  Eigen::ArrayXd acceleration, turn_acceleration;  // [m/s^2], [rad/s^2]
  std::vector<unsigned char> reverse;              // 1 where the reference drives backwards
  // Of a path of samples: one lap's headings [rad] and directions of travel as they were given;
  // empty where they are those of the motion.
  Eigen::ArrayXd given_theta;
  std::vector<unsigned char> given_reverse;
  // What was taken off the positions of a path of samples [m]: writers add it again.
  std::array<double, 2> origin = {0, 0};
  // How it was read and what was made of it, in lines for people. No part of its value.
  std::vector<std::string> notes;

  Eigen::Index size() const { return x.size(); }
  double dt() const { return settings.dt; }
  double peak_speed() const { return v.abs().maxCoeff(); }
};

// Second-order central differences, first-order at the ends: numpy.gradient.
inline Eigen::ArrayXd gradient(const Eigen::ArrayXd& samples, double dt) {
  const Eigen::Index n = samples.size();
  Eigen::ArrayXd slope(n);
  slope(0) = (samples(1) - samples(0)) / dt;
  slope(n - 1) = (samples(n - 1) - samples(n - 2)) / dt;
  slope.segment(1, n - 2) = (samples.tail(n - 2) - samples.head(n - 2)) / (2 * dt);
  return slope;
}

// Removes jumps of more than half a `turn` [rad] between neighbours.
inline void unwrap(Eigen::ArrayXd& angle, double turn = 2 * math<double>::pi) {
  double offset = 0;
  double last = angle(0);
  for (Eigen::Index k = 1; k < angle.size(); ++k) {
    const double step = angle(k) - last;
    last = angle(k);
    if (step >= turn / 2 || step < -turn / 2) offset -= turn * std::floor(step / turn + 0.5);
    angle(k) += offset;
  }
}

namespace detail {

constexpr double least_standstill_speed = 1e-9;  // [m/s]

// The reverse flag; where the reference stands still it keeps the previous one.
inline void mark_reverse(Trajectory& trajectory, double still = least_standstill_speed) {
  trajectory.reverse.assign(static_cast<std::size_t>(trajectory.size()), 0);
  unsigned char flag = 0;
  for (Eigen::Index k = 0; k < trajectory.size(); ++k) {
    if (std::fabs(trajectory.v(k)) >= still) flag = trajectory.v(k) < 0 ? 1 : 0;
    trajectory.reverse[static_cast<std::size_t>(k)] = flag;
  }
}

// Where the samples stand still, the differences say nothing of the heading: it stays as it was, or
// at the start as it will be.
inline void hold_heading(const Eigen::ArrayXd& speed, double still, Eigen::ArrayXd& heading) {
  Eigen::Index known = 0;
  while (known < speed.size() && speed(known) < still) ++known;
  if (known == speed.size()) return;
  heading.head(known).setConstant(heading(known));
  for (Eigen::Index k = known + 1; k < speed.size(); ++k) {
    if (speed(k) < still) heading(k) = heading(k - 1);
  }
}

// The angle between two lines without direction, in [-pi/2, pi/2).
inline double line_angle(double from, double to) {
  const double turns = (to - from) / math<double>::pi;
  return math<double>::pi * (turns - std::floor(turns + 0.5));
}

// At a sample on a cusp the difference runs square to the path: there the line of its neighbours,
// where those agree, is the path's.
inline void mend_cusps(Eigen::ArrayXd& heading) {
  constexpr double apart = math<double>::pi / 4;
  for (Eigen::Index k = 1; k + 1 < heading.size(); ++k) {
    const double across = line_angle(heading(k - 1), heading(k + 1));
    if (std::fabs(across) < apart && std::fabs(line_angle(heading(k - 1), heading(k))) > apart &&
        std::fabs(line_angle(heading(k), heading(k + 1))) > apart) {
      heading(k) = heading(k - 1) + across / 2;
    }
  }
}

// Everything from the sampled positions alone. Slower than `still` [m/s] the heading holds.
inline void differentiate_positions(Trajectory& t, double still = least_standstill_speed) {
  const double dt = t.settings.dt;
  const Eigen::ArrayXd dx = gradient(t.x, dt);
  const Eigen::ArrayXd dy = gradient(t.y, dt);
  t.theta.resize(t.size());
  for (Eigen::Index k = 0; k < t.size(); ++k) t.theta(k) = math<double>::angle_of(dy(k), dx(k));
  t.v = (dx.square() + dy.square()).sqrt();
  hold_heading(t.v, still, t.theta);
  if (t.settings.heading == HeadingChoice::forward) {
    unwrap(t.theta);
    // What noise moves at a standstill is no motion along the heading.
    for (Eigen::Index k = 0; still > least_standstill_speed && k < t.size(); ++k) {
      if (t.v(k) >= still) continue;
      const Heading<double> h = math<double>::heading(t.theta(k));
      t.v(k) = dx(k) * h.cosine + dy(k) * h.sine;
    }
  } else {
    // The heading as a line without a direction is continuous; v is the motion along it.
    mend_cusps(t.theta);
    unwrap(t.theta, math<double>::pi);
    for (Eigen::Index k = 0; k < t.size(); ++k) {
      const Heading<double> h = math<double>::heading(t.theta(k));
      const double along = dx(k) * h.cosine + dy(k) * h.sine;
      const bool mended = std::fabs(along) < 0.7 * t.v(k);
      t.v(k) = mended ? along : (along < 0 ? -t.v(k) : t.v(k));
    }
  }
  t.omega = gradient(t.theta, dt);
  t.acceleration = gradient(t.v, dt);
  t.turn_acceleration = gradient(t.omega, dt);
}

// Turns the closed forms' continuous heading and signed speed into the direction of motion. Each
// arc between cusps, half of them driven in reverse, has its heading half a turn further back.
inline void face_forward(Trajectory& t) {
  int cusps_passed = 0;
  bool last = false;
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const bool backwards = t.v(k) < 0 || (t.v(k) == 0 && t.acceleration(k) < 0);
    cusps_passed += backwards != last ? 1 : 0;
    last = backwards;
    t.theta(k) -= math<double>::pi * cusps_passed;
    if (backwards) {
      t.v(k) = -t.v(k);
      t.acceleration(k) = -t.acceleration(k);
    }
  }
}

inline void fill_closed_forms(Trajectory& t) {
  const TrajectorySettings& s = t.settings;
  const double rate = 2 * math<double>::pi / s.period;
  for (Eigen::ArrayXd* array : {&t.theta, &t.v, &t.omega, &t.acceleration, &t.turn_acceleration}) {
    array->resize(t.size());
  }
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const double phase = rate * (static_cast<double>(k) * s.dt);
    const PathPoint point = path_point(s.name, s.cusps, phase, rate);
    t.x(k) = point.x * s.scale;
    t.y(k) = point.y * s.scale;
    t.theta(k) = point.theta;
    t.v(k) = point.v * s.scale;
    t.omega(k) = point.omega;
    t.acceleration(k) = point.acceleration * s.scale;
    t.turn_acceleration(k) = point.turn_acceleration;
  }
  unwrap(t.theta);
}

}  // namespace detail

// The number of samples of a named path, both ends included.
inline double sample_count(const TrajectorySettings& settings) {
  return std::floor(settings.laps * settings.period / settings.dt + 1e-9) + 1;
}

// A named path. On a fault returns why and leaves the result as it was.
NFOPIDN_HOST Status make_trajectory(const TrajectorySettings& settings, Trajectory& result);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST Status make_trajectory(const TrajectorySettings& settings, Trajectory& result) {
  const StandardArithmetic arithmetic;
  const Finding finding = check_ranges(settings);
  if (finding.status != Status::ok) return finding.status;
  if (settings.name == Curve::samples) return Status::not_a_choice;
  const double still = settings.standstill_speed.value_or(detail::least_standstill_speed);
  const double count = sample_count(settings);
  if (count < minimum_samples || count > maximum_samples) return Status::wrong_size;
  Trajectory t;
  t.settings = settings;
  t.x.resize(static_cast<Eigen::Index>(count));
  t.y.resize(t.x.size());
  detail::fill_closed_forms(t);
  if (settings.heading == HeadingChoice::continuous) {
    if (settings.derivatives == Derivatives::sampled) {
      t.acceleration = gradient(t.v, settings.dt);
      t.turn_acceleration = gradient(t.omega, settings.dt);
    }
  } else if (settings.derivatives == Derivatives::sampled) {
    detail::differentiate_positions(t, still);
  } else {
    detail::face_forward(t);
  }
  detail::mark_reverse(t);
  result = std::move(t);
  return Status::ok;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
