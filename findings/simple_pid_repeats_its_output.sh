#!/usr/bin/env bash
# simple-pid: in a simulation the controller gives its first output for ever, even when dt is passed.
#
# One would guess: pid(measurement, dt=0.005) computes an output for a sample of 5 ms; without dt the real clock is used.
# What happens: an output is only computed when the time since the last one reaches sample_time, 0.01 s by default. By
#   the real clock, a simulation of 200 samples takes a millisecond, so it sees the first output 200
#   times. With dt the given value alone is compared with sample_time and is not added up: each dt of 5 ms
#   is below 10 ms, so nothing is ever computed again. At dt=0.01 all is well. sample_time=None cures it.
# Why it matters: as the baseline of a comparison, PID becomes a constant torque, or the first torque of the path, and
#   any controller wins; tuning its gains at 200 Hz changes nothing but the first sample.
# Seen with: simple-pid 2.0.1.
# Source: https://github.com/jellevos/simple-ros-pid (a fork for simulated time: a new output is only calculated when
#   sample_time has passed); the docstring of PID.__call__ in the package says dt is for simulations.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check simple-pid==2.0.1

"$work/venv/bin/python" - <<'PYTHON'
from simple_pid import PID


def simulate(step, pass_dt=True, **settings):
    """Drive x' = u from 0 to 1 for 2 s; return x at the end and the number of different outputs."""
    pid = PID(2.0, 0.0, 0.0, setpoint=1.0, **settings)
    x, outputs = 0.0, set()
    for _ in range(round(2.0 / step)):
        u = pid(x, dt=step) if pass_dt else pid(x)
        outputs.add(u)
        x += step * u
    return x, len(outputs)


print("x' = u, gain 2, 2 s: the exact end is 0.98")
clock = simulate(0.01, pass_dt=False)
fine = simulate(0.005)
coarse = simulate(0.01)
cured = simulate(0.005, sample_time=None)
print(f"  step 10 ms, the real clock             x = {clock[0]:.3f}, {clock[1]} different outputs in 200 calls")
print(f"  step  5 ms, dt passed                  x = {fine[0]:.3f}, {fine[1]} different outputs in 400 calls")
print(f"  step 10 ms, dt passed                  x = {coarse[0]:.3f}, {coarse[1]} different outputs in 200 calls")
print(f"  step  5 ms, dt passed, sample_time=None  x = {cured[0]:.3f}, {cured[1]} different outputs in 400 calls")
assert clock[1] <= 3, "the real clock no longer holds back a fast simulation"
assert fine[1] == 1 and fine[0] > 3.9, "a dt below sample_time now computes an output"
assert coarse[1] > 100 and cured[1] > 100 and abs(cured[0] - 0.98) < 0.01, "the cases that work have changed"
PYTHON
