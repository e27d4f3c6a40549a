// L4. What a search for a controller may change: the parameters of a structure, their bounds, and
// which of them are free, frozen or tied.
#pragma once

#include "nfopidn/search/box.hpp"
#include "nfopidn/tuning/structures.hpp"

namespace nfopidn {

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
  // All parameters of a structure.
  template <class Number>
  std::vector<Number> full(const Number* x) const {
    std::vector<Number> result(source.size());
    for (std::size_t i = 0; i < source.size(); ++i) {
      result[i] = source[i] >= 0 ? x[source[i]] : Number(fixed[i]);
    }
    return result;
  }
  // The inverse: the free ones. Of parameters that are tied the first one counts.
  Point free(const std::vector<double>& every, Eigen::Index dimension) const {
    Point x = Point::Zero(dimension);
    for (std::size_t i = source.size(); i-- > 0;) {
      if (source[i] >= 0) x(source[i]) = every[i];
    }
    return x;
  }
};

// How finely a search looks at small parameters: see Box::power. Good gains and orders lie near the
// lower end of generous bounds.
inline Point tuning_powers(const Point& low) {
  return (low.array() >= 0).select(Point::Constant(low.size(), 2), Point::Ones(low.size()));
}
// The same for the free parameters of a structure, of which some have a power of their own.
inline Point tuning_powers(const Structure& structure, const FreeParameters& parameters,
                           const Point& low) {
  Point power = tuning_powers(low);
  const std::vector<ParameterBounds> bounds = default_bounds(structure);
  for (std::size_t i = 0; i < bounds.size(); ++i) {
    const double own = bounds[i].power;
    if (own < 0 || parameters.source[i] < 0) continue;
    const Eigen::Index place = parameters.source[i];
    if (own != Box::logarithmic || low(place) > 0) power(place) = own;
  }
  return power;
}

struct ParameterSpace {
  Structure structure;
  FreeParameters parameters;
  Point low, high;  // of the free ones

  // All parameters are free within their default bounds.
  static ParameterSpace whole(const Structure& structure) {
    const std::vector<ParameterBounds> bounds = default_bounds(structure);
    ParameterSpace space = {structure, FreeParameters::all(bounds.size()), {}, {}};
    space.low.resize(static_cast<Eigen::Index>(bounds.size()));
    space.high.resize(space.low.size());
    for (Eigen::Index i = 0; i < space.low.size(); ++i) {
      space.low(i) = bounds[static_cast<std::size_t>(i)].low;
      space.high(i) = bounds[static_cast<std::size_t>(i)].high;
    }
    return space;
  }

  Eigen::Index dimension() const { return low.size(); }
  Box box() const { return {low, high, tuning_powers(structure, parameters, low)}; }

  // The controller of a point of the space.
  ControllerDesign design(const Point& x) const {
    return design_of(structure, parameters.full(x.data()));
  }
  // The free parameters that a controller has; they may lie beyond the bounds.
  Point free_parameters(const ControllerDesign& design) const {
    return parameters.free(parameters_of(structure.parameters, design), dimension());
  }
  // The nearest point of the space.
  Point within(const Point& x) const { return x.cwiseMax(low).cwiseMin(high); }
};

}  // namespace nfopidn
