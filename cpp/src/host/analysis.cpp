// Orbits, stability, basins of attraction, fractional operators.
#define NFOPIDN_DEFINES_ANALYSIS
#include "nfopidn/analysis/basin.hpp"
#include "nfopidn/analysis/conversion.hpp"
#include "nfopidn/analysis/floquet.hpp"
#include "nfopidn/analysis/linear_plant.hpp"
#include "nfopidn/analysis/rational.hpp"

namespace nfopidn {

template class StepMap<double>;
template class StepMap<Dual<double>>;

}  // namespace nfopidn
