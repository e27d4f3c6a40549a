// The cost of candidates and of drawn runs, and tunings.
#define NFOPIDN_DEFINES_TUNING
#include "nfopidn/rivals/tuning.hpp"

#include "nfopidn/tuning/measured_runs.hpp"
#include "nfopidn/tuning/tune.hpp"
