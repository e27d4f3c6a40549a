// L4. One period of a reference without ends: what the stability of a loop is asked of.
#pragma once

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/io/outcome.hpp"
#include "nfopidn/simulation/prepared_run.hpp"

namespace nfopidn {

constexpr int most_period_samples = 10000;

struct PeriodicReference {
  // One more than a period has: the last is the first, a period later.
  std::vector<ReferenceSample<double>> samples;
  int period = 0;  // [samples]; 1 where each sample is, seen from the path, like the one before
  int laps = 0;    // in a period; 0 where the period is one sample
};

namespace detail {

// Laps in the longer trajectory: a period of up to two is taken behind a period, so that phases are
// the trajectory's own, with a period behind it to compare with, and no difference is one-sided.
constexpr int extended_laps = 7;
constexpr int periodic_laps = 2;
constexpr double periodic_tolerance = 1e-6;  // of positions [m], angles [rad] and rates

// The same path with more laps. Not of samples that do not close.
inline Status extend(const Trajectory& given, Trajectory& longer) {
  TrajectorySettings settings = given.settings;
  settings.laps = extended_laps;
  if (settings.name != Curve::samples) return make_trajectory(settings, longer);
  const Eigen::Index lap = (given.size() - 1) / given.settings.laps + 1;
  return make_trajectory(given.x.head(lap), given.y.head(lap), settings, longer);
}

// Whether two samples are alike to a robot that is on the path, and so are the ways to the next.
inline bool alike(const ReferenceSample<double>* a, const ReferenceSample<double>* b) {
  const auto near = [](double p, double q) { return std::fabs(p - q) <= periodic_tolerance; };
  const auto way = [](const ReferenceSample<double>* s) {
    const Measurement<double> here = {s->x, s->y, s->theta, 0, 0};
    return rotate_into_robot(world_errors(here, s[1]), math<double>::heading(s->theta));
  };
  const Channels<double> p = way(a);
  const Channels<double> q = way(b);
  return near(p.x, q.x) && near(p.y, q.y) && near(math<double>::wrap(p.theta - q.theta), 0) &&
         near(a->v, b->v) && near(a->omega, b->omega) && near(a->tau_left, b->tau_left) &&
         near(a->tau_right, b->tau_right) && a->reverse == b->reverse;
}

// Alike, and with the same heading: for what happens in the world's frame.
inline bool repeats(const std::vector<ReferenceSample<double>>& samples, std::size_t first,
                    std::size_t period) {
  for (std::size_t k = first; k < first + period; ++k) {
    const ReferenceSample<double>* const now = samples.data() + k;
    const ReferenceSample<double>* const later = now + period;
    const double turned = math<double>::wrap(later->theta - now->theta);
    if (std::fabs(turned) > periodic_tolerance || !alike(now, later)) return false;
  }
  return true;
}

// From `first` on, but for the three samples at an end, whose rates are one-sided differences.
inline bool is_steady(const std::vector<ReferenceSample<double>>& samples, bool in_world_frame) {
  constexpr std::size_t margin = 3;
  if (samples.size() < 2 * margin + 2) return false;
  const ReferenceSample<double>* const first = samples.data() + margin;
  for (std::size_t k = margin; k + margin + 1 < samples.size(); ++k) {
    const double turned = math<double>::wrap(samples[k].theta - first->theta);
    if (in_world_frame && std::fabs(turned) > periodic_tolerance) return false;
    if (!alike(samples.data() + k, first)) return false;
  }
  return true;
}

inline void take(const std::vector<ReferenceSample<double>>& from, std::size_t first, int period,
                 int laps, PeriodicReference& result) {
  const auto begin = from.begin() + static_cast<std::ptrdiff_t>(first);
  result = {{begin, begin + period + 1}, period, laps};
}

inline Outcome check_lap(const Trajectory& trajectory, double& lap) {
  const TrajectorySettings& s = trajectory.settings;
  const double exact = s.period / s.dt;
  lap = std::round(exact);
  if (lap < 1 || std::fabs(exact - lap) > 1e-9 * lap) {
    return refuse(Status::inconsistent, "trajectory.period",
                  number_text(s.period) + " s, " + number_text(exact) + " samples of " +
                      number_text(s.dt) + " s",
                  "a whole number of samples");
  }
  const Range range = between(1, most_period_samples);
  if (!range.contains(lap)) {
    return refuse_number("trajectory.period / dt", lap, range, "samples");
  }
  return {};
}

}  // namespace detail

// The reference's period. One sample on a line or circle, unless the controller's errors are in the
// world's frame and the heading turns; else one lap, or two where the heading repeats after two.
NFOPIDN_HOST Outcome find_period(const Scenario& scenario, bool in_world_frame,
                                 PeriodicReference& result);

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_ANALYSIS

namespace nfopidn {

NFOPIDN_HOST Outcome find_period(const Scenario& scenario, bool in_world_frame,
                                 PeriodicReference& result) {
  const auto reference_of = [&](const Trajectory& trajectory) {
    Scenario other = scenario;
    other.trajectory = trajectory;
    other.disturbance = {{0, 0}};
    return prepare(other).reference;
  };
  const std::vector<ReferenceSample<double>> given = reference_of(scenario.trajectory);
  if (detail::is_steady(given, in_world_frame)) {
    detail::take(given, given.size() / 2, 1, 0, result);
    return {};
  }
  double lap = 0;
  if (Outcome outcome = detail::check_lap(scenario.trajectory, lap); !outcome) return outcome;
  const Trajectory& t = scenario.trajectory;
  const Eigen::Index last = t.size() - 1;
  if (t.settings.name == Curve::samples && t.settings.laps == 1) {
    const double gap = std::hypot(t.x(last) - t.x(0), t.y(last) - t.y(0));
    if (gap > closing_distance) {
      return refuse(Status::inconsistent, "distance of the trajectory's ends",
                    number_text(gap) + " m",
                    range_text(between(0, closing_distance)) + " m: a periodic path is needed");
    }
  }
  Trajectory longer;
  const Status status = detail::extend(t, longer);
  if (status != Status::ok) return {status, "the trajectory cannot be repeated"};
  const std::vector<ReferenceSample<double>> samples = reference_of(longer);
  const auto steps = static_cast<std::size_t>(lap);
  for (int laps = 1; laps <= detail::periodic_laps; ++laps) {
    const std::size_t period = steps * static_cast<std::size_t>(laps);
    if (!detail::repeats(samples, period, period)) continue;
    detail::take(samples, period, static_cast<int>(period), laps, result);
    return {};
  }
  return refuse(Status::inconsistent, "trajectory", "not periodic",
                "a path whose motion repeats after 1 or 2 laps");
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_ANALYSIS
