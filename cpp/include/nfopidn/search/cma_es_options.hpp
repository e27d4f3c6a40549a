// L3. Settings of CMA-ES.
#pragma once

#include "nfopidn/foundation/schema.hpp"

namespace nfopidn {

struct CmaEsOptions {
  int population = 0;
  double step = 0.3;
  double start_step = 0.1;
  double growth = 4;
  double tolerance = 1e-6;

  template <class Visitor>
  static constexpr void fields(Visitor&& visit) {
    using C = CmaEsOptions;
    visit(field("population", &C::population, "", between(0, 1e6),
                "points in a generation of the first run, at least 2; 0: 4 + 3 ln(dimension), "
                "rounded down"));
    visit(field("step", &C::step, "", between(1e-9, 10),
                "standard deviation that a run starts with, in units of the box"));
    visit(field("start_step", &C::start_step, "", between(1e-9, 10),
                "the same for the first run where a start point is given"));
    visit(field("growth", &C::growth, "", between(1, 100),
                "factor by which each restart enlarges the population"));
    visit(field("tolerance", &C::tolerance, "", between(0, 1),
                "a run ends when its costs have differed by less than this, relative to the best "
                "of them, for some generations"));
  }
};

// The default, 0, apart, a population has at least a better and a worse point.
inline Finding check_options(const CmaEsOptions& options) {
  const Finding finding = check_ranges(options);
  if (finding.status != Status::ok || options.population != 1) return finding;
  return {Status::inconsistent, "population", 1, between(0, 1e6)};
}
inline const char* rule_of(const CmaEsOptions& /*options*/) { return "0 or at least 2"; }

}  // namespace nfopidn
