// What of a controller is searched for.
#define NFOPIDN_DEFINES_STRUCTURES
#include "nfopidn/tuning/structures.hpp"

namespace nfopidn {

template LawParameters<double> law_parameters(const ControllerDesign&);
template void parameters_to_law(const Structure&, const std::vector<double>&, double*);

}  // namespace nfopidn
