// One sample of the recording: what the robot measured, and what the reference was.
#pragma once

#include "control.hpp"

struct Sample {
  Pose measured;
  Reference reference;
};
