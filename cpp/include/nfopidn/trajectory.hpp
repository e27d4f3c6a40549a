// L3. A sampled reference trajectory.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>
#include <vector>

#include "nfopidn/curves.hpp"
#include "nfopidn/standard_arithmetic.hpp"

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

// The reverse flag; where the reference stands still it keeps the previous one.
inline void mark_reverse(Trajectory& trajectory) {
  trajectory.reverse.assign(static_cast<std::size_t>(trajectory.size()), 0);
  unsigned char flag = 0;
  for (Eigen::Index k = 0; k < trajectory.size(); ++k) {
    if (std::fabs(trajectory.v(k)) >= 1e-9) flag = trajectory.v(k) < 0 ? 1 : 0;
    trajectory.reverse[static_cast<std::size_t>(k)] = flag;
  }
}

// Where the samples stand still, the differences say nothing of the heading: it stays as it was, or
// at the start as it will be.
inline void hold_heading(const Eigen::ArrayXd& speed, Eigen::ArrayXd& heading) {
  constexpr double still = 1e-9;  // [m/s]
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

// Everything from the sampled positions alone.
inline void differentiate_positions(Trajectory& t) {
  const double dt = t.settings.dt;
  const Eigen::ArrayXd dx = gradient(t.x, dt);
  const Eigen::ArrayXd dy = gradient(t.y, dt);
  t.theta.resize(t.size());
  for (Eigen::Index k = 0; k < t.size(); ++k) t.theta(k) = math<double>::angle_of(dy(k), dx(k));
  t.v = (dx.square() + dy.square()).sqrt();
  hold_heading(t.v, t.theta);
  if (t.settings.heading == HeadingChoice::forward) {
    unwrap(t.theta);
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
inline Status make_trajectory(const TrajectorySettings& settings, Trajectory& result) {
  const StandardArithmetic arithmetic;
  const Finding finding = check_ranges(settings);
  if (finding.status != Status::ok) return finding.status;
  if (settings.name == Curve::samples) return Status::not_a_choice;
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
    detail::differentiate_positions(t);
  } else {
    detail::face_forward(t);
  }
  detail::mark_reverse(t);
  result = std::move(t);
  return Status::ok;
}

namespace detail {

// Runs a closed path `laps` times; the last point of a lap is the first of the next.
inline Eigen::ArrayXd repeat_laps(const Eigen::ArrayXd& lap, int laps) {
  const Eigen::Index steps = lap.size() - 1;
  Eigen::ArrayXd all(steps * laps + 1);
  for (int i = 0; i < laps; ++i) all.segment(i * steps, steps) = lap.head(steps);
  all(all.size() - 1) = lap(steps);
  return all;
}

}  // namespace detail

// How far apart [m] the ends of a path may be for it to count as closed.
constexpr double closing_distance = 1e-6;

// A path through one lap's positions [m], settings.dt apart. Uses dt, heading and laps of the
// settings; more than one lap needs a closed path. Derivatives are differences of the samples.
inline Status make_trajectory(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y,
                              const TrajectorySettings& settings, Trajectory& result) {
  const StandardArithmetic arithmetic;
  if (x.size() != y.size() || x.size() < minimum_samples) return Status::wrong_size;
  if (static_cast<double>(x.size()) * settings.laps > maximum_samples) return Status::wrong_size;
  if (!x.allFinite() || !y.allFinite()) return Status::not_finite;
  Trajectory t;
  t.settings.name = Curve::samples;
  t.settings.dt = settings.dt;
  t.settings.heading = settings.heading;
  t.settings.laps = settings.laps;
  const Finding finding = check_ranges(t.settings);
  if (finding.status != Status::ok) return finding.status;
  // Not among what is given, and so not checked: as short or long as the samples make it.
  t.settings.period = settings.dt * static_cast<double>(x.size() - 1);
  const double gap = std::hypot(x(x.size() - 1) - x(0), y(y.size() - 1) - y(0));
  if (settings.laps > 1 && gap > closing_distance) return Status::inconsistent;
  t.x = detail::repeat_laps(x, settings.laps);
  t.y = detail::repeat_laps(y, settings.laps);
  detail::differentiate_positions(t);
  detail::mark_reverse(t);
  result = std::move(t);
  return Status::ok;
}

}  // namespace nfopidn
