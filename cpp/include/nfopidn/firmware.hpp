// Everything a microcontroller needs: layers L0 to L2. No heap, no exceptions, no RTTI, no Eigen,
// no C++ standard library, and no double when Scalar is float.
#pragma once

#include "nfopidn/control/controller.hpp"
#include "nfopidn/firmware/bumpless.hpp"
#include "nfopidn/firmware/guarded.hpp"
#include "nfopidn/firmware/odometry.hpp"
#include "nfopidn/firmware/reference_table.hpp"
#include "nfopidn/firmware/self_test.hpp"
#include "nfopidn/firmware/velocity_output.hpp"
#include "nfopidn/foundation/compiler.hpp"  // first: it says what the compiler lacks
#include "nfopidn/loop/closed_loop.hpp"
#include "nfopidn/plant/feedforward.hpp"
#include "nfopidn/plant/motor.hpp"
