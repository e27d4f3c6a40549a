#!/usr/bin/env bash
# WPIMath: LTVUnicycleController spins a robot that is to stand still; Ramsete, which it replaces, does not.
#
# One would guess: with reference speeds of zero a robot 10 cm beside its goal stays there: it cannot move sideways.
# What happens: the gain on the lateral error hardly depends on the speed, down to zero: 15.8 rad/s per metre at
#   0.01 m/s and 15.8 at 0. A robot with 0.1 m of lateral error at standstill starts to turn at 1.6 rad/s, ends
#   at 85 degrees from the goal's heading, and creeps along its new axis: the sideways error has been traded for one
#   of 9 cm along the path. Between -0.01 and 0 m/s the gain changes its sign, so that at the end of a
#   reverse manoeuvre it jumps from one direction to the other. Ramsete answers 0 in the same place.
# Why it matters: the end of every stop-to-stop trajectory is such a place. A comparison that counts heading or
#   the last pose finds an error of its own making, and a real robot swings round at its goal.
# Seen with: robotpy-wpimath 2026.2.2.
# Source: https://github.com/wpilibsuite/allwpilib/pull/6494 (Ramsete is deprecated: LTVUnicycleController is called a
#   drop-in replacement).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check robotpy-wpimath==2026.2.2

"$work/venv/bin/python" - <<'PYTHON'
import math

from wpimath.controller import LTVUnicycleController, RamseteController
from wpimath.geometry import Pose2d

PERIOD = 0.02  # [s]
GOAL = Pose2d(0.0, 0.0, 0.0)


def turn_rate(controller, speed):
    return controller.calculate(Pose2d(0.0, -0.1, 0.0), GOAL, speed, 0.0).omega


def park(controller, seconds):
    """Start 0.1 m to the right of the goal, with speeds of zero as the reference; return the last pose."""
    x, y, heading = 0.0, -0.1, 0.0
    for _ in range(round(seconds / PERIOD)):
        command = controller.calculate(Pose2d(x, y, heading), GOAL, 0.0, 0.0)
        x += PERIOD * command.vx * math.cos(heading)
        y += PERIOD * command.vx * math.sin(heading)
        heading += PERIOD * command.omega
    return x, y, math.degrees(heading)


ltv, ramsete = LTVUnicycleController(PERIOD), RamseteController()
print("commanded turn rate [rad/s] for a lateral error of 0.1 m:")
for speed in (1.0, 0.01, 0.0, -0.001, -0.01, -1.0):
    print(f"  at {speed:6.3f} m/s: LTV {turn_rate(ltv, speed):6.3f}, Ramsete {turn_rate(ramsete, speed):6.3f}")
ltv_end, ramsete_end = park(ltv, 10.0), park(ramsete, 10.0)
print("after 10 s at standstill, LTV:     x {:.3f} m, y {:.3f} m, heading {:.1f} degrees".format(*ltv_end))
print("after 10 s at standstill, Ramsete: x {:.3f} m, y {:.3f} m, heading {:.1f} degrees".format(*ramsete_end))

assert abs(turn_rate(ltv, 0.0)) > 1.5 and turn_rate(ramsete, 0.0) == 0.0, "the gains at standstill have changed"
assert turn_rate(ltv, 0.0) * turn_rate(ltv, -0.01) < 0.0, "the sign no longer jumps just below zero"
assert ltv_end[2] > 80.0 and ltv_end[0] > 0.08, "LTV no longer turns the parked robot"
assert ramsete_end == (0.0, -0.1, 0.0), "Ramsete no longer leaves the parked robot alone"
PYTHON
