// The methods of search.
#define NFOPIDN_DEFINES_SEARCH
#include "nfopidn/search/method.hpp"
