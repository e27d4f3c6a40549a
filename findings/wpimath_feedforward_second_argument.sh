#!/usr/bin/env bash
# WPIMath: feedforward.calculate(10, 20) does not mean 10 m/s and 20 m/s^2, as its documentation says.
#
# One would guess: SimpleMotorFeedforwardMeters(kS, kV, kA).calculate(velocity, acceleration) returns
#   kS sign(v) + kV v + kA a; the guide shows calculate(10, 20) with that comment.
# What happens: the second argument is the velocity of the next period, 20 ms later unless the constructor is told
#   another. With kV = 2, kA = 0.5 the call returns 280 V for the expected 30 V. Constant speed written as (v, 0)
#   asks the robot to stop within 20 ms: calculate(1, 0) is -24 V where 2 V are wanted. In Python both are plain
#   numbers, so that nothing can object.
# Why it matters: the feedforward of a trajectory is its largest part. Code written after the guide drives both
#   motors into their limits, at constant speed backwards.
# Seen with: robotpy-wpimath 2026.2.2.
# Source: https://docs.wpilib.org/en/latest/_sources/docs/software/advanced-controls/controllers/feedforward.rst.txt
#   (the call with an acceleration); the docstring of calculate in the package names currentVelocity, nextVelocity.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check robotpy-wpimath==2026.2.2

"$work/venv/bin/python" - <<'PYTHON'
import math

from wpimath.controller import SimpleMotorFeedforwardMeters

KS, KV, KA = 0.0, 2.0, 0.5  # [V], [V s/m], [V s^2/m]
feedforward = SimpleMotorFeedforwardMeters(KS, KV, KA)
faster = SimpleMotorFeedforwardMeters(KS, KV, KA, 0.005)

print("kV = 2 V s/m, kA = 0.5 V s^2/m")
for velocity, second in ((10.0, 20.0), (1.0, 0.0), (1.0, 1.0)):
    print(f"  calculate({velocity:g}, {second:g}): {feedforward.calculate(velocity, second):8.3f} V; "
          f"as velocity and acceleration {KV * velocity + KA * second:g} V")
print(f"  calculate(1, 0) with a period of 5 ms: {faster.calculate(1.0, 0.0):.3f} V")


def next_velocity(velocity, following, period):
    """Return the voltage that takes kA v' + kV v = u from one velocity to another in a period."""
    decay = math.exp(-KV / KA * period)
    return KV * (following - decay * velocity) / (1.0 - decay)


for velocity, second in ((10.0, 20.0), (1.0, 0.0), (1.0, 1.0)):
    found = feedforward.calculate(velocity, second)
    assert abs(found - next_velocity(velocity, second, 0.02)) < 1e-9, "the second argument has another meaning now"
assert feedforward.calculate(1.0, 0.0) < -20.0 and faster.calculate(1.0, 0.0) < -90.0
PYTHON
