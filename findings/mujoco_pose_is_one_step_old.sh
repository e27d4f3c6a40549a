#!/usr/bin/env bash
# MuJoCo: after a step, a body's pose and its sensors show the state before that step.
#
# One would guess: after mj_step, data.body("base").xpos and a framepos sensor give the robot's pose now, equal to
#   the first three numbers of its free joint in qpos.
# What happens: qpos is new, xpos, xquat, xmat and every sensor are one step old, as they are computed before the
#   integration. mj_forward brings them up to date. The time in data.time is the new one.
# Why it matters: when the simulator runs at the control period, a loop closed over xpos has a whole sample of delay
#   that nobody asked for. Gains without margin that are stable with the pose from qpos are not with this one.
# Seen with: mujoco 4.0.0.
# Source: https://github.com/google-deepmind/mujoco/issues/889 and
#   https://github.com/google-deepmind/mujoco/issues/498 (the maintainers: values are those of the step's start).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0

"$work/venv/bin/python" - <<'PYTHON'
import mujoco

PERIOD = 0.1  # [s] of the simulator and of the controller
model = mujoco.MjModel.from_xml_string(f"""
    <mujoco>
      <option timestep="{PERIOD}" gravity="0 0 0"/>
      <worldbody>
        <body name="base"><freejoint name="base"/><geom size="0.1" mass="1"/></body>
      </worldbody>
      <actuator><motor joint="base" gear="1 0 0 0 0 0"/></actuator>
      <sensor><framepos objtype="body" objname="base"/></sensor>
    </mujoco>""")

data = mujoco.MjData(model)
data.qvel[0] = 1.0
for _ in range(3):
    mujoco.mj_step(model, data)
print(f"at 1 m/s, t = {data.time:.1f} s: x in qpos {data.qpos[0]:.3f} m, xpos {data.body('base').xpos[0]:.3f} m, "
      f"sensor {data.sensordata[0]:.3f} m")
old, sensed = data.body("base").xpos[0], data.sensordata[0]
mujoco.mj_forward(model, data)
print(f"after mj_forward:                                xpos {data.body('base').xpos[0]:.3f} m, "
      f"sensor {data.sensordata[0]:.3f} m")


def error_after(seconds, read):
    """Return |x| [m] after some seconds under one PD law, or when it passes 10 m; x starts at 0.1 m."""
    data = mujoco.MjData(model)
    data.qpos[0] = 0.1
    mujoco.mj_forward(model, data)
    before = read(data)
    while data.time < seconds and abs(data.qpos[0]) < 10.0:
        x = read(data)
        data.ctrl[0] = -10.0 * x - 13.0 * (x - before) / PERIOD
        before = x
        mujoco.mj_step(model, data)
    return abs(data.qpos[0])


new = error_after(20.0, lambda data: data.qpos[0])
late = error_after(20.0, lambda data: data.body("base").xpos[0])
print(f"one PD law on a mass, from 0.1 m: error {new:.1e} m on qpos, {late:.1e} m on xpos")
assert abs(data.qpos[0] - 0.3) < 1e-12, "qpos is no longer the new position"
assert abs(old - 0.2) < 1e-12 and abs(sensed - 0.2) < 1e-12, "xpos and the sensor are no longer one step old"
assert abs(data.body("base").xpos[0] - 0.3) < 1e-12, "mj_forward no longer brings xpos up to date"
assert new < 1e-6 and late > 1.0, "the old pose no longer destabilises this loop"
PYTHON
