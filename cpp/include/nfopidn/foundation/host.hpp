// L0. Where the host side is compiled: in each unit that includes it, or once in a library.
//
// The headers of the host side declare their functions, and define those that are worth compiling
// once at their end, in a block `#ifdef NFOPIDN_DEFINES_UNIT`. On their own, as the target
// nfopidn::header_only has them, the headers define everything inline. The target nfopidn::nfopidn
// sets NFOPIDN_COMPILED: then cpp/src/host/UNIT.cpp alone has the block of its unit.
#pragma once

#ifdef NFOPIDN_COMPILED
#define NFOPIDN_HOST
#else
#define NFOPIDN_HOST inline
#define NFOPIDN_DEFINES_SIMULATION
#define NFOPIDN_DEFINES_SEARCH
#define NFOPIDN_DEFINES_STRUCTURES
#define NFOPIDN_DEFINES_RIVALS
#define NFOPIDN_DEFINES_TUNING
#define NFOPIDN_DEFINES_IO
#define NFOPIDN_DEFINES_ANALYSIS
#endif
