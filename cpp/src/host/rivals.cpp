// The other controllers.
#define NFOPIDN_DEFINES_RIVALS
#include "nfopidn/rivals/rivals.hpp"
