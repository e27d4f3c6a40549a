// The cost of candidates, and tunings.
#define NFOPIDN_DEFINES_TUNING
#include "nfopidn/rivals/tuning.hpp"
#include "nfopidn/tuning/tune.hpp"
