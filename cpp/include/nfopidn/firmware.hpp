// Everything a microcontroller needs: layers L0 to L2. No heap, no exceptions, no RTTI, no Eigen,
// and no double when Scalar is float.
#pragma once

#include "nfopidn/controller.hpp"
#include "nfopidn/hardware.hpp"
#include "nfopidn/loop.hpp"
