// L4. What of a controller is searched for: named structures, their parameters and default bounds.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "nfopidn/controller_design.hpp"

namespace nfopidn {

// The vector of the paper: the nine gains row by row, then alpha and sigma for all channels, or for
// x, for y and for theta; or the fused taps themselves, channel by channel, newest first.
enum class ParameterSet : unsigned char { shared_orders, orders_by_channel, taps };

template <>
struct ChoiceNames<ParameterSet> {
  static constexpr const char* names[] = {"shared-orders", "orders-by-channel", "taps"};
};

struct Structure {
  ControllerSettings<double> settings;  // gains and orders in it do not matter
  ParameterSet parameters = ParameterSet::shared_orders;
};

enum class StructureName : unsigned char { paper, decoupled, incremental, extended, taps };

template <>
struct ChoiceNames<StructureName> {
  static constexpr const char* names[] = {"paper", "decoupled", "incremental", "extended", "taps"};
};

inline Structure named_structure(StructureName name) {
  Structure structure;
  if (name == StructureName::paper) return structure;
  structure.settings.allocation = Allocation<double>::decoupled();
  if (name == StructureName::incremental) structure.settings.form = Form::incremental;
  if (name == StructureName::extended || name == StructureName::taps) {
    structure.settings.lateral = Lateral::speed;
    structure.parameters =
        name == StructureName::taps ? ParameterSet::taps : ParameterSet::orders_by_channel;
  }
  return structure;
}

// The best incremental, decoupled controller of the published scenario, E = 0.01722, found by
// ./build/nfopidn_sim --tune --structure incremental --tune-seed 1 --maxfev 40000
inline ControllerDesign tuned_nominal() {
  ControllerSettings<double> settings = named_structure(StructureName::incremental).settings;
  constexpr double gains[3][3] = {{0.0, 0.006401815674433561, 2.324731753613115},
                                  {0.021529405564192618, 0.005718156580749912, 0.0},
                                  {0.24146343552774766, 0.00804308622457552, 0.8463555897123993}};
  for (int channel = 0; channel < channel_count; ++channel) {
    std::copy_n(gains[channel], 3, settings.gains[channel]);
    settings.alpha[channel] = 0.46705030301507683;
    settings.sigma[channel] = 1.0;
  }
  return settings;
}

struct ParameterBounds {
  std::string name;
  double low;
  double high;
};

inline constexpr const char* channel_names[] = {"x", "y", "theta"};

// Of free taps.
inline std::vector<ParameterBounds> tap_bounds(int count) {
  std::vector<ParameterBounds> bounds;
  for (const char* channel : channel_names) {
    for (int j = 0; j < count; ++j) {
      bounds.push_back({std::string("tap_") + channel + "_" + std::to_string(j), -60, 60});
    }
  }
  return bounds;
}

// Gains [0, 3] and orders [0.01, 1]; with an order pair a channel [0, 6] and [0.01, 2]. In the
// incremental form the integral gains end at 0.3: beyond, nearly all runs diverge. Taps [-60, 60].
inline std::vector<ParameterBounds> default_bounds(const Structure& structure) {
  if (structure.parameters == ParameterSet::taps) {
    return tap_bounds(structure.settings.memory + 2);
  }
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

// Parameter i of a structure is x[source[i]], or fixed[i] where source[i] is negative. Parameters
// with one source are tied.
struct FreeParameters {
  std::vector<int> source;
  std::vector<double> fixed;

  static FreeParameters all(std::size_t count) {
    FreeParameters parameters;
    for (std::size_t i = 0; i < count; ++i) parameters.source.push_back(static_cast<int>(i));
    parameters.fixed.assign(count, 0.0);
    return parameters;
  }
  template <class Number>
  std::vector<Number> full(const Number* x) const {
    std::vector<Number> result(source.size());
    for (std::size_t i = 0; i < source.size(); ++i) {
      result[i] = source[i] >= 0 ? x[source[i]] : Number(fixed[i]);
    }
    return result;
  }
};

// The fused taps, [3][memory + 2], of a structure's parameters.
template <class Number>
void parameters_to_taps(const Structure& structure, const std::vector<Number>& x, Number* taps) {
  if (structure.parameters == ParameterSet::taps) {
    std::copy(x.begin(), x.end(), taps);
    return;
  }
  const int memory = structure.settings.memory;
  std::vector<Number> work(static_cast<std::size_t>(memory + 2));
  const std::size_t pair_step = structure.parameters == ParameterSet::orders_by_channel ? 2 : 0;
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    const Number* gains = x.data() + 3 * channel;
    const Number* orders = x.data() + 3 * channel_count + pair_step * channel;
    fuse_taps(structure.settings.generator, gains[0], gains[1], gains[2], orders[0], orders[1],
              memory, taps + static_cast<std::size_t>(memory + 2) * channel, work.data());
  }
}

// The controller that a structure's parameters stand for.
inline ControllerDesign design_of(const Structure& structure, const std::vector<double>& x) {
  ControllerDesign design(structure.settings);
  if (structure.parameters == ParameterSet::taps) {
    design.taps = x;
    return design;
  }
  const std::size_t pair_step = structure.parameters == ParameterSet::orders_by_channel ? 2 : 0;
  for (std::size_t channel = 0; channel < channel_count; ++channel) {
    std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(3 * channel), 3, design.gains[channel]);
    design.alpha[channel] = x[std::size_t{9} + pair_step * channel];
    design.sigma[channel] = x[std::size_t{10} + pair_step * channel];
  }
  return design;
}

// The inverse: a design's parameters. Of free taps only those of the taps' structure are there.
inline std::vector<double> parameters_of(const Structure& structure,
                                         const ControllerDesign& design) {
  std::vector<double> x = design.taps;
  if (structure.parameters == ParameterSet::taps) {
    if (!x.empty()) return x;
    Structure fused = {design, ParameterSet::orders_by_channel};
    x.resize(static_cast<std::size_t>(channel_count) * static_cast<std::size_t>(design.memory + 2));
    parameters_to_taps(fused, parameters_of(fused, design), x.data());
    return x;
  }
  for (const auto& row : design.gains) x.insert(x.end(), row, row + 3);
  const bool by_channel = structure.parameters == ParameterSet::orders_by_channel;
  for (int channel = 0; channel < (by_channel ? channel_count : 1); ++channel) {
    x.push_back(design.alpha[channel]);
    x.push_back(design.sigma[channel]);
  }
  return x;
}

}  // namespace nfopidn
