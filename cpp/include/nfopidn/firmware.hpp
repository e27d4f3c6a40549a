// Everything a microcontroller needs: layers L0 to L2. No heap, no exceptions, no RTTI, no Eigen,
// no C++ standard library, and no double when Scalar is float.
#pragma once

#include "nfopidn/bumpless.hpp"
#include "nfopidn/compiler.hpp"  // first: it says what the compiler lacks
#include "nfopidn/controller.hpp"
#include "nfopidn/guarded.hpp"
#include "nfopidn/loop.hpp"
#include "nfopidn/odometry.hpp"
#include "nfopidn/reference_table.hpp"
#include "nfopidn/self_test.hpp"
#include "nfopidn/velocity_output.hpp"
