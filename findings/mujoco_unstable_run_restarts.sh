#!/usr/bin/env bash
# MuJoCo: a loop that is unstable ends at the start pose, with time set back, and no exception.
#
# One would guess: when a controller makes the simulation diverge, the states grow, become inf or NaN, and a cost
#   computed from them is NaN as well, so that a search or a test notices.
# What happens: as soon as a state or an acceleration is too large, MuJoCo resets the data to the model's start and
#   goes on. Position, speed and time are zero again; one line goes to the standard error stream and a log file. A
#   run of a fixed number of steps ends with finite values close to the start, where many references begin and end.
#   data.warning counts the event; the flag autoreset="disable" keeps the state as it is.
# Why it matters: a tuner that scores the last pose, or the mean over a run cut into resets, prefers wildly unstable
#   gains to poor ones; loops "while data.time < end" take longer and repeat the start.
# Seen with: mujoco 4.0.0.
# Source: https://github.com/google-deepmind/mujoco/issues/168 (the warning and the reset),
#   https://github.com/google-deepmind/mujoco/issues/1570 (the maintainers: look at mjData.warning).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0

"$work/venv/bin/python" - <<'PYTHON'
import mujoco
import numpy as np


def run(gain, flag=""):
    """Hold a mass at x = 0 from 0.1 m with a damping that is far too high; return what a caller sees."""
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="0.02" gravity="0 0 0">{flag}</option>
          <worldbody>
            <body><joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1" mass="0.1"/></body>
          </worldbody>
          <actuator><motor joint="rail"/></actuator>
        </mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[0] = 0.1
    largest = 0.0
    for _ in range(500):
        data.ctrl[0] = -0.5 * data.qpos[0] - gain * data.qvel[0]
        mujoco.mj_step(model, data)
        largest = max(largest, abs(data.qpos[0]))
    resets = int(sum(warning.number for warning in data.warning))
    print(f"  damping {gain:4.0f} N·s/m {flag and 'no autoreset':13s} x {data.qpos[0]:9.2e} m, largest {largest:.1e} m, "
          f"time {data.time:5.2f} s, warnings {resets}")
    return data.qpos[0], data.time, largest, resets


print("500 steps of 20 ms (10 s) from 0.1 m; the loop is stable below 10 N·s/m")
stable = run(1.0)
unstable = run(15.0)
kept = run(15.0, '<flag autoreset="disable"/>')
assert abs(stable[0]) < 1e-2 and abs(stable[1] - 10.0) < 1e-6 and stable[3] == 0
assert np.isfinite(unstable[0]) and unstable[1] < 9.9 and unstable[2] > 1e6, "an unstable run no longer restarts"
assert unstable[3] > 0 and abs(kept[1] - 10.0) < 1e-6, "the warning or the flag no longer works"
PYTHON
