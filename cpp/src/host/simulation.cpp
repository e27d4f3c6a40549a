// Trajectories, scenarios, runs and their metrics, and filters of long memory.
#define NFOPIDN_DEFINES_SIMULATION
#include "nfopidn/simulation/playback.hpp"
#include "nfopidn/simulation/recorded.hpp"
