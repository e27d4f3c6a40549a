// The control step as the firmware calls it. Compiled by itself, for the board and for the host.
#pragma once

#include "nfopidn/firmware.hpp"

using Pose = nfopidn::Measurement<float>;
using Reference = nfopidn::ReferenceSample<float>;
using Torques = nfopidn::TorquePair<float>;

// As after power-on.
void control_reset();

// The limited torques [N m] of one sample, every 0.2 s. Inside, a positive left torque turns the
// robot counter-clockwise (docs/theory.md): for a robot of REP-103 exchange left and right.
Torques control_step(const Pose& measured, const Reference& reference);
