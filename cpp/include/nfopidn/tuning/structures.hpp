// L4. What of a controller is searched for: named structures, their parameters and default bounds.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "nfopidn/foundation/host.hpp"
#include "nfopidn/tuning/tracking_parameters.hpp"

namespace nfopidn {

// The vector of the paper: the nine gains row by row, then alpha and sigma for all channels, or for
// x, for y and for theta; or the fused taps themselves, channel by channel, newest first; or those
// of the tracking law, by names of their own.
enum class ParameterSet : unsigned char { shared_orders, orders_by_channel, taps, tracking };

template <>
struct ChoiceNames<ParameterSet> {
  static constexpr const char* names[] = {"shared-orders", "orders-by-channel", "taps", "tracking"};
};

struct Structure {
  ControllerSettings<double> settings;  // gains and orders in it do not matter
  ParameterSet parameters = ParameterSet::shared_orders;
  // A search for free taps also tries what the lateral channel is fed: see free_tap_laterals.
  bool either_lateral = false;
  TrackingScale scale = {};  // of the bounds of the tracking law
};

// Free taps can make of the lateral error as it is what gains and orders cannot. Which is the
// better one depends on the path.
inline constexpr Lateral free_tap_laterals[] = {Lateral::speed, Lateral::direction};

enum class StructureName : unsigned char {
  paper,
  decoupled,
  incremental,
  extended,
  taps,
  tracking
};

template <>
struct ChoiceNames<StructureName> {
  static constexpr const char* names[] = {"paper",    "decoupled", "incremental",
                                          "extended", "taps",      "tracking"};
};

// The tracking law, with the speed errors and the schedule that its search is for.
NFOPIDN_HOST Structure tracking_structure();

NFOPIDN_HOST Structure named_structure(StructureName name);

// The best incremental, decoupled controller of the published scenario, E = 0.01722.
// ./build/nfopidn_sim --tune --structure incremental --tune-seed 1 --maxfev 40000
// finds it to five digits.
NFOPIDN_HOST ControllerDesign tuned_nominal();

// The tracking law with gains that a covariance matrix adaptation found, outside this repository,
// over 132 scenarios of the paper's robot: other plants, paths and speeds, and with a delay of one
// sample. This repository's own search, python bench/families.py --families J++ --save gains, ends
// beside them, at the same cost to four digits. They are in the order of TrackingNames. For another
// robot, sample time, torque limit and peak speed they are scaled (docs/theory.md).
NFOPIDN_HOST ControllerDesign recommended_tracking(const TrackingScale& scale = {});

inline constexpr const char* channel_names[] = {"x", "y", "theta"};

// Of free taps.
NFOPIDN_HOST std::vector<ParameterBounds> tap_bounds(int count);

// Gains [0, 3] and orders [0.01, 1]; with an order pair a channel [0, 6] and [0.01, 2]. In the
// incremental form the integral gains end at 0.3: beyond, nearly all runs diverge. Taps [-60, 60].
NFOPIDN_HOST std::vector<ParameterBounds> default_bounds(const Structure& structure);

// Whether the channels have one order pair.
inline bool shares_orders(const ControllerSettings<double>& s) {
  return s.alpha[0] == s.alpha[1] && s.alpha[1] == s.alpha[2] && s.sigma[0] == s.sigma[1] &&
         s.sigma[1] == s.sigma[2];
}

// A channel's part of a vector of gains and orders.
template <class Number>
struct ChannelParameters {
  const Number* gains;   // kp, ki, kd
  const Number* orders;  // alpha, sigma
};

template <class Number>
ChannelParameters<Number> channel_parameters(ParameterSet parameters, const std::vector<Number>& x,
                                             std::size_t channel) {
  constexpr std::size_t gain_count = 9;
  const std::size_t pair = parameters == ParameterSet::orders_by_channel ? channel : 0;
  return {x.data() + 3 * channel, x.data() + gain_count + 2 * pair};
}

// Those of a variant with the tracking law. Where the parameters are gains and orders of eq. 34,
// its own numbers are those of the settings.
template <class Number>
void tracking_numbers(const Structure& structure, const std::vector<Number>& x, Number* numbers,
                      Number* work) {
  const ControllerSettings<double>& settings = structure.settings;
  LawNumbers<Number> law = law_numbers<Number>(settings);
  if (structure.parameters == ParameterSet::tracking) {
    TrackingNames<Number>::each(
        law, [&, next = x.data()](auto, Number& value, auto) mutable { value = *next++; });
    use_net(settings.net, law);
  } else {
    for (std::size_t channel = 0; channel < channel_count; ++channel) {
      const auto [gains, orders] = channel_parameters(structure.parameters, x, channel);
      std::copy_n(gains, 3, law.gains + 3 * channel);
      law.alpha[channel] = orders[0];
      law.sigma[channel] = orders[1];
    }
  }
  const LawParameters<Number> parameters =
      fuse_law(settings, law.gains, law.alpha, law.sigma, law.tracking, numbers, work);
  Number* next = numbers + channel_count * (settings.memory + 2);
  LawParameters<Number>::each(parameters, [&](const Number& number) { *next++ = number; });
}

// The numbers of the law of a structure's parameters: its taps, [3][memory + 2], and, of a variant
// with the tracking law, its parameters.
template <class Number>
void parameters_to_law(const Structure& structure, const std::vector<Number>& x, Number* taps) {
  if (structure.parameters == ParameterSet::taps) {  // of a variant without the tracking law
    std::copy(x.begin(), x.end(), taps);
    return;
  }
  const int memory = structure.settings.memory;
  const auto count = static_cast<std::size_t>(memory) + 2;
  std::vector<Number> work(count);
  if (structure.settings.needs_tracking_law()) {
    tracking_numbers(structure, x, taps, work.data());
    return;
  }
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    const auto [gains, orders] = channel_parameters(structure.parameters, x, channel);
    fuse_taps(structure.settings.generator, gains[0], gains[1], gains[2], orders[0], orders[1],
              memory, taps + count * channel, work.data());
  }
}

// The parameters of the law that a design stands for, besides its taps.
template <class Scalar>
LawParameters<Scalar> law_parameters(const ControllerDesign& design) {
  LawNumbers<Scalar> law = law_numbers<Scalar>(design);
  const auto count = static_cast<std::size_t>(design.memory) + 2;
  std::vector<Scalar> taps(channel_count * count), work(count);
  return fuse_law<Scalar>(static_cast<const ControllerSettings<double>&>(design), law.gains,
                          law.alpha, law.sigma, law.tracking, taps.data(), work.data());
}

// The controller that a structure's parameters stand for.
NFOPIDN_HOST ControllerDesign design_of(const Structure& structure, const std::vector<double>& x);

// The inverse: a design's parameters. Gains and orders have taps; free taps have no gains.
NFOPIDN_HOST std::vector<double> parameters_of(ParameterSet parameters,
                                               const ControllerDesign& design);

// How a design is written as a vector: the shortest way that loses nothing.
NFOPIDN_HOST ParameterSet parameter_set_of(const ControllerDesign& design);

#ifdef NFOPIDN_COMPILED
extern template LawParameters<double> law_parameters(const ControllerDesign&);
extern template void parameters_to_law(const Structure&, const std::vector<double>&, double*);
#endif

}  // namespace nfopidn

#ifdef NFOPIDN_DEFINES_STRUCTURES

namespace nfopidn {

NFOPIDN_HOST Structure tracking_structure() {
  Structure structure;
  ControllerSettings<double>& settings = structure.settings;
  for (auto& row : settings.gains) std::fill(std::begin(row), std::end(row), 0.0);
  settings.allocation = Allocation<double>::decoupled();
  settings.net = Net::speed_errors;
  settings.lateral = Lateral::scheduled;
  structure.parameters = ParameterSet::tracking;
  return structure;
}

NFOPIDN_HOST Structure named_structure(StructureName name) {
  Structure structure;
  if (name == StructureName::paper) return structure;
  structure.settings.allocation = Allocation<double>::decoupled();
  if (name == StructureName::incremental) structure.settings.form = Form::incremental;
  if (name == StructureName::tracking) return tracking_structure();
  if (name == StructureName::extended || name == StructureName::taps) {
    structure.settings.lateral = Lateral::speed;
    structure.either_lateral = name == StructureName::taps;
    structure.parameters =
        structure.either_lateral ? ParameterSet::taps : ParameterSet::orders_by_channel;
  }
  return structure;
}

NFOPIDN_HOST ControllerDesign tuned_nominal() {
  ControllerSettings<double> settings = named_structure(StructureName::incremental).settings;
  constexpr double gains[3][3] = {{0.0, 0.006401815674433561, 2.324731753613115},
                                  {0.021529405564192618, 0.005718156580749912, 0.0},
                                  {0.24146343552774766, 0.00804308622457552, 0.8463555897123993}};
  for (int channel = 0; channel < channel_count; ++channel) {
    std::copy_n(gains[channel], 3, settings.gains[channel]);
    settings.alpha[channel] = 0.46705030301507683;
    settings.sigma[channel] = 1.0;
  }
  settings.sample_time = 0.2;  // the published scenario's
  return settings;
}

NFOPIDN_HOST ControllerDesign recommended_tracking(const TrackingScale& scale) {
  static constexpr double found[] = {
      12.40179642034419,     1.9658935275626521,  1.1367936836850892, 0.6484296971523478,
      0.3174125644783265,    0.22310207698088796, 1.5529383242550163, 7.89030905859618,
      2.8021984252995824,    0.8813775149502812,  1.2562952996039327, 0.23265803599561666,
      0.08290153936448774,   0.23954968730040926, 0.0222947325901342, 0.0016840587810797775,
      0.0010091033347185492, 0.9925295518114412,  0.15459832580137808};
  ControllerDesign design(tracking_structure().settings);
  set_tracking_parameters(design,
                          scaled_tracking_parameters({std::begin(found), std::end(found)}, scale));
  design.sample_time = scale.sample_time;
  design.robot = scale.robot;
  return design;
}

NFOPIDN_HOST std::vector<ParameterBounds> tap_bounds(int count) {
  std::vector<ParameterBounds> bounds;
  for (const char* channel : channel_names) {
    for (int j = 0; j < count; ++j) {
      bounds.push_back({std::string("tap_") + channel + "_" + std::to_string(j), -60, 60});
    }
  }
  return bounds;
}

NFOPIDN_HOST std::vector<ParameterBounds> default_bounds(const Structure& structure) {
  if (structure.parameters == ParameterSet::taps) {
    return tap_bounds(structure.settings.memory + 2);
  }
  if (structure.parameters == ParameterSet::tracking) return tracking_bounds(structure.scale);
  static constexpr const char* terms[] = {"kp_", "ki_", "kd_"};
  std::vector<ParameterBounds> bounds;
  const bool by_channel = structure.parameters == ParameterSet::orders_by_channel;
  const bool incremental = structure.settings.form == Form::incremental;
  for (const char* channel : channel_names) {
    for (int term = 0; term < 3; ++term) {
      const double most = term == 1 && incremental ? 0.3 : (by_channel ? 6.0 : 3.0);
      bounds.push_back({std::string(terms[term]) + channel, 0, most});
    }
  }
  const double highest_order = by_channel ? 2 : 1;
  for (const char* channel : channel_names) {
    for (const char* order : {"alpha", "sigma"}) {
      bounds.push_back({by_channel ? std::string(order) + "_" + channel : std::string(order), 0.01,
                        highest_order});
    }
    if (!by_channel) break;
  }
  return bounds;
}

NFOPIDN_HOST ControllerDesign design_of(const Structure& structure, const std::vector<double>& x) {
  ControllerDesign design(structure.settings);
  if (structure.parameters == ParameterSet::taps) {
    design.taps = x;
    return design;
  }
  if (structure.parameters == ParameterSet::tracking) {
    set_tracking_parameters(design, x);
    return design;
  }
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    const auto [gains, orders] = channel_parameters(structure.parameters, x, channel);
    std::copy_n(gains, 3, design.gains[channel]);
    design.alpha[channel] = orders[0];
    design.sigma[channel] = orders[1];
  }
  return design;
}

NFOPIDN_HOST std::vector<double> parameters_of(ParameterSet parameters,
                                               const ControllerDesign& design) {
  if (parameters == ParameterSet::taps && !design.taps.empty()) return design.taps;
  if (parameters == ParameterSet::tracking) return tracking_parameters(design);
  if (parameters == ParameterSet::taps) {
    const Structure fused = {design, ParameterSet::orders_by_channel};
    std::vector<double> taps(static_cast<std::size_t>(law_size(fused.settings, design.memory + 2)));
    parameters_to_law(fused, parameters_of(fused.parameters, design), taps.data());
    taps.resize(channel_count * (static_cast<std::size_t>(design.memory) + 2));
    return taps;
  }
  std::vector<double> x;
  for (const auto& row : design.gains) x.insert(x.end(), row, row + 3);
  const int pairs = parameters == ParameterSet::orders_by_channel ? channel_count : 1;
  for (int channel = 0; channel < pairs; ++channel) {
    x.push_back(design.alpha[channel]);
    x.push_back(design.sigma[channel]);
  }
  return x;
}

NFOPIDN_HOST ParameterSet parameter_set_of(const ControllerDesign& design) {
  if (!design.taps.empty()) return ParameterSet::taps;
  if (design.net == Net::speed_errors) return ParameterSet::tracking;
  return shares_orders(design) ? ParameterSet::shared_orders : ParameterSet::orders_by_channel;
}

}  // namespace nfopidn

#endif  // NFOPIDN_DEFINES_STRUCTURES
