// L3. A reference trajectory through given positions.
#pragma once

#include <array>
#include <limits>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/simulation/trajectory.hpp"

namespace nfopidn {

// One lap of a path, settings.dt apart. Heading and direction of travel are those of the motion
// unless they are given.
struct Samples {
  Eigen::ArrayXd x, y;                    // [m]
  Eigen::ArrayXd theta;                   // [rad], or empty
  std::vector<unsigned char> reverse;     // 1 where the robot drives backwards, or empty
  std::array<double, 2> origin = {0, 0};  // what was taken off the positions [m]
};

// How far apart [m] the ends of a path may be for it to count as closed.
constexpr double closing_distance = 1e-6;

// Adds the point that closes a path, its first, if it is not there already.
NFOPIDN_HOST void close_path(Samples& samples);

namespace detail {

// Runs a closed path `laps` times; the last point of a lap is the first of the next.
inline Eigen::ArrayXd repeat_laps(const Eigen::ArrayXd& lap, int laps) {
  if (lap.size() == 0) return lap;
  const Eigen::Index steps = lap.size() - 1;
  Eigen::ArrayXd all(steps * laps + 1);
  for (int i = 0; i < laps; ++i) all.segment(i * steps, steps) = lap.head(steps);
  all(all.size() - 1) = lap(steps);
  return all;
}

inline bool ends_within(const Eigen::ArrayXd& numbers, double scale) {
  const Eigen::ArrayXd scaled = numbers * scale;
  const Eigen::ArrayXd slack = scaled.abs() * (4 * std::numeric_limits<double>::epsilon());
  return ((scaled - scaled.round()).abs() <= slack).all();
}

// The last decimal digit [m] that positions are given to, down to a nanometre; 0 if they have more.
inline double last_digit(const Samples& lap) {
  constexpr int most = 9;
  double scale = 1;
  for (int digits = 0; digits <= most; ++digits, scale *= 10) {
    if (ends_within(lap.x, scale) && ends_within(lap.y, scale)) return 1 / scale;
  }
  return 0;
}

// The longest step [m] of noise at a standstill, 0 without any: of short steps back and forth.
// Where a path turns round it does so once, noise at every other step.
inline double noise_step(const Samples& lap) {
  constexpr Eigen::Index window = 6;
  const Eigen::Index steps = lap.x.size() - 1;
  const Eigen::ArrayXd dx = lap.x.tail(steps) - lap.x.head(steps);
  const Eigen::ArrayXd dy = lap.y.tail(steps) - lap.y.head(steps);
  const Eigen::ArrayXd length = (dx.square() + dy.square()).sqrt();
  const double short_step = 0.1 * length.maxCoeff();
  double longest = 0;
  for (Eigen::Index first = 0; first + window <= steps; ++first) {
    if (length.segment(first, window).maxCoeff() > short_step) continue;
    int turns = 0;
    double here = 0;
    for (Eigen::Index k = first; k + 1 < first + window; ++k) {
      if (dx(k) * dx(k + 1) + dy(k) * dy(k + 1) >= 0) continue;
      ++turns;
      // The shorter one: where the robot begins to move, the longer one is motion already.
      here = std::max(here, std::min(length(k), length(k + 1)));
    }
    if (turns >= 2) longest = std::max(longest, here);
  }
  return longest;
}

// The speed [m/s] below which the direction of motion tells nothing of the heading: a step of the
// central difference is then less than six times what the positions resolve. At most a tenth of the
// peak speed.
inline double standstill_speed(const Samples& lap, double dt) {
  const double size = std::max(lap.x.abs().maxCoeff(), lap.y.abs().maxCoeff());
  const double rounding = 4 * std::numeric_limits<double>::epsilon() * size;
  const double resolution = std::max({last_digit(lap), noise_step(lap), rounding});
  const double peak =
      (gradient(lap.x, dt).square() + gradient(lap.y, dt).square()).sqrt().maxCoeff();
  return std::max(least_standstill_speed, std::min(3 * resolution / dt, 0.1 * peak));
}

// Heading or direction of travel as they are given; v is the motion along the heading. False where
// both are given and contradict each other.
inline bool follow_given(const Samples& samples, double still, Trajectory& t) {
  const double dt = t.settings.dt;
  const Eigen::ArrayXd dx = gradient(t.x, dt);
  const Eigen::ArrayXd dy = gradient(t.y, dt);
  const Eigen::ArrayXd speed = (dx.square() + dy.square()).sqrt();
  const auto lap = static_cast<Eigen::Index>(samples.x.size()) - 1;
  const auto backwards = [&](Eigen::Index k) {
    return samples.reverse[static_cast<std::size_t>(k == t.size() - 1 ? lap : k % lap)] != 0;
  };
  t.theta = repeat_laps(samples.theta, t.settings.laps);
  if (samples.theta.size() == 0) {
    t.theta.resize(t.size());
    for (Eigen::Index k = 0; k < t.size(); ++k) {
      const double turned = backwards(k) ? math<double>::pi : 0;
      t.theta(k) = math<double>::angle_of(dy(k), dx(k)) + turned;
    }
    hold_heading(speed, still, t.theta);
  }
  unwrap(t.theta);
  t.v.resize(t.size());
  bool agree = true;
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const Heading<double> h = math<double>::heading(t.theta(k));
    const double along = dx(k) * h.cosine + dy(k) * h.sine;
    const bool clear = speed(k) >= still && std::fabs(along) >= 0.7 * speed(k);
    t.v(k) = clear ? std::copysign(speed(k), along) : along;
    if (!samples.reverse.empty() && clear && (along < 0) != backwards(k)) agree = false;
  }
  t.omega = gradient(t.theta, dt);
  t.acceleration = gradient(t.v, dt);
  t.turn_acceleration = gradient(t.omega, dt);
  return agree;
}

// Says how many samples hold a heading that is not the direction of their motion.
inline void note_standstill(double still, Trajectory& t) {
  constexpr double apart = 0.01;  // [rad]
  const Eigen::ArrayXd dx = gradient(t.x, t.settings.dt);
  const Eigen::ArrayXd dy = gradient(t.y, t.settings.dt);
  long long held = 0;
  for (Eigen::Index k = 0; k < t.size(); ++k) {
    const double speed = std::hypot(dx(k), dy(k));
    if (speed < least_standstill_speed || speed >= still) continue;
    const double turned = math<double>::wrap(math<double>::angle_of(dy(k), dx(k)) - t.theta(k));
    held += std::fabs(turned) > apart && math<double>::pi - std::fabs(turned) > apart ? 1 : 0;
  }
  if (held == 0) return;
  char text[200];
  std::snprintf(text, sizeof text,
                "the heading holds at %lld of %lld samples, slower than %.3g "
                "m/s, where the "
                "positions do not tell the direction of motion "
                "(standstill_speed sets it)",
                held, static_cast<long long>(t.size()), still);
  t.notes.emplace_back(text);
}

// The sizes and numbers of one lap.
inline Status check_samples(const Samples& lap, int laps) {
  const Eigen::Index count = lap.x.size();
  const auto flags = static_cast<Eigen::Index>(lap.reverse.size());
  if (lap.y.size() != count || count < minimum_samples) return Status::wrong_size;
  if ((lap.theta.size() != 0 && lap.theta.size() != count) || (flags != 0 && flags != count)) {
    return Status::wrong_size;
  }
  if (static_cast<double>(count) * laps > maximum_samples) return Status::wrong_size;
  if (!lap.x.allFinite() || !lap.y.allFinite() || !lap.theta.allFinite()) return Status::not_finite;
  return Status::ok;
}

}  // namespace detail

// A path through one lap's positions. Uses dt, heading, laps and standstill_speed of the settings;
// more than one lap needs a closed path. Derivatives are differences of the samples.
NFOPIDN_HOST Status make_trajectory(const Samples& lap, const TrajectorySettings& settings,
                                    Trajectory& result);

// The same of positions alone.
NFOPIDN_HOST Status make_trajectory(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y,
                                    const TrajectorySettings& settings, Trajectory& result);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_SIMULATION

namespace nfopidn {

NFOPIDN_HOST void close_path(Samples& samples) {
  const Eigen::Index n = samples.x.size();
  if (n == 0 || samples.y.size() != n) return;
  const double gap = std::hypot(samples.x(n - 1) - samples.x(0), samples.y(n - 1) - samples.y(0));
  if (gap <= closing_distance) return;
  for (Eigen::ArrayXd* array : {&samples.x, &samples.y, &samples.theta}) {
    if (array->size() != n) continue;
    array->conservativeResize(n + 1);
    (*array)(n) = (*array)(0);
  }
  if (static_cast<Eigen::Index>(samples.reverse.size()) == n) {
    samples.reverse.push_back(samples.reverse.front());
  }
}

NFOPIDN_HOST Status make_trajectory(const Samples& lap, const TrajectorySettings& settings,
                                    Trajectory& result) {
  const Status status = detail::check_samples(lap, settings.laps);
  if (status != Status::ok) return status;
  const Eigen::Index count = lap.x.size();
  Trajectory t;
  t.settings.name = Curve::samples;
  t.settings.dt = settings.dt;
  t.settings.heading = settings.heading;
  t.settings.laps = settings.laps;
  t.settings.standstill_speed = settings.standstill_speed;
  const Finding finding = check_ranges(t.settings);
  if (finding.status != Status::ok) return finding.status;
  // Not among what is given, and so not checked: as short or long as the samples make it.
  t.settings.period = settings.dt * static_cast<double>(count - 1);
  const double gap = std::hypot(lap.x(count - 1) - lap.x(0), lap.y(count - 1) - lap.y(0));
  if (settings.laps > 1 && gap > closing_distance) return Status::inconsistent;
  t.x = detail::repeat_laps(lap.x, settings.laps);
  t.y = detail::repeat_laps(lap.y, settings.laps);
  t.given_theta = lap.theta;
  t.given_reverse = lap.reverse;
  t.origin = lap.origin;
  const bool heading_given = lap.theta.size() != 0;
  const bool reverse_given = !lap.reverse.empty();
  const double still = settings.standstill_speed ? *settings.standstill_speed
                                                 : detail::standstill_speed(lap, settings.dt);
  if (heading_given || reverse_given) {
    if (!detail::follow_given(lap, still, t)) return Status::not_a_choice;
  } else {
    detail::differentiate_positions(t, still);
  }
  detail::mark_reverse(t, still);
  if (reverse_given) {
    const auto steps = static_cast<std::size_t>(count - 1);
    for (std::size_t k = 0; k < t.reverse.size(); ++k) {
      t.reverse[k] = lap.reverse[k + 1 == t.reverse.size() ? steps : k % steps];
    }
  }
  if (!heading_given && !settings.standstill_speed) detail::note_standstill(still, t);
  result = std::move(t);
  return Status::ok;
}

NFOPIDN_HOST Status make_trajectory(const Eigen::ArrayXd& x, const Eigen::ArrayXd& y,
                                    const TrajectorySettings& settings, Trajectory& result) {
  return make_trajectory(Samples{x, y, {}, {}, {0, 0}}, settings, result);
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_SIMULATION
