#!/usr/bin/env bash
# WPILib: a trajectory that waits or turns on the spot has poses of nan, and the acceleration column moves the robot.
#
# One would guess: Trajectory.sample(t) between two states at one place, as where a robot waits for a gripper or turns on
#   the spot, is that place, and the rotation goes from one to the other. Between other states it lies in between by
#   time; `acceleration` is there for a follower's feedforward.
# What happens: the pose's x and y are nan and its rotation 0 from just after the first of the two states until just
#   before the second. sample() goes along the segment by the distance covered at the first state's velocity and
#   acceleration, over the segment's length, which is 0/0. The same formula stands still for a whole segment if its first
#   state has velocity 0 and a file of another program has 0 as acceleration, and then jumps to the next state.
# Why it matters: followers (RAMSETE, LTV) turn nan into nan wheel speeds, at every stop of an otherwise right
#   PathWeaver file; with 0 accelerations the robot does not leave, and then leaps. The states themselves look right.
# Seen with: robotpy-wpimath 2026.2.2.
# Source: https://github.com/wpilibsuite/allwpilib/blob/main/wpimath/src/main/native/cpp/trajectory/Trajectory.cpp
#   (State::Interpolate divides by the distance between the poses); the class documentation speaks of no such condition.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check robotpy-wpimath==2026.2.2

"$work/venv/bin/python" - <<'PYTHON'
import math

from wpimath.geometry import Pose2d, Rotation2d
from wpimath.trajectory import Trajectory


def made(*states):
    """Return a trajectory of states (time, velocity, acceleration, x, heading)."""
    return Trajectory([Trajectory.State(t, v, a, Pose2d(x, 0, Rotation2d(h)), 0) for t, v, a, x, h in states])


def show(name, trajectory, times):
    """Print and return x and heading at times."""
    print(name)
    found = []
    for t in times:
        pose = trajectory.sample(t).pose
        found.append((pose.x, pose.rotation().radians()))
        print(f"  {t:.2f} s: x {pose.x:.3f} m, heading {pose.rotation().radians():.3f} rad")
    return found


stop = made((0, 0, 1, 0, 0), (1, 1, -1, 0.5, 0), (2, 0, 0, 1, 0), (3, 0, 1, 1, 0), (4, 1, 0, 1.5, 0))
waits = show("moves, waits from 2 to 3 s, moves", stop, (0.5, 1.5, 2.0, 2.5, 3.5))
spot = show("turns on the spot from 1 to 2 rad", made((0, 0, 0, 0, 1), (1, 0, 0, 0, 2)), (0.0, 0.5, 1.0))
flat = show("0 as acceleration", made((0, 0, 0, 0, 0), (1, 1, 0, 0.5, 0), (2, 1, 0, 1.5, 0)), (0.25, 0.99, 1.5))

assert [x for x, _ in waits[:3]] == [0.125, 0.875, 1.0] and abs(waits[4][0] - 1.125) < 1e-9, "other samples have changed"
assert math.isnan(waits[3][0]), "a trajectory that waits is sampled now"
assert math.isnan(spot[1][0]) and spot[1][1] == 0, "a turn on the spot is sampled now"
assert flat[0][0] == flat[1][0] == 0 and abs(flat[2][0] - 1.0) < 1e-9, "a segment with 0 as acceleration moves now"
PYTHON
