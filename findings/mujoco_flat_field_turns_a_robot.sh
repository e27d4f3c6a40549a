#!/usr/bin/env bash
# MuJoCo: on a flat height field a robot that stands still turns.
#
# One would guess: a height field whose heights are all zero is a plane, so that a robot without torque stays.
#   Swapping the plane for a height field to add bumps later changes nothing.
# What happens: a robot on ellipsoid or cylinder wheels turns by 3 degrees within 15 s, without torque, wheels rolling
#   against each other; on the plane, and on spheres, it stays to the last digit. Contacts of these shapes with a field
#   are found by a general algorithm on the prisms under the robot, whose points and normals are a little off.
# Why it matters: a simulated robot drifts in its heading with nothing to blame, and a controller with an integral
#   part learns a torque that the real floor does not ask for. The floor's height 0 hides it: everything looks flat.
# Seen with: mujoco-core 4.0.1.
# Source: https://github.com/google-deepmind/mujoco/issues/689 (a flat field of four heights does not behave as a plane)
#   and https://github.com/google-deepmind/mujoco/issues/236 (contacts with fields are found on prisms).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco-core==4.0.1

"$work/venv/bin/python" - <<'PYTHON'
import math

import mujoco

FLOORS = {"plane": '<geom type="plane" size="2 2 0.1"/>', "field": '<geom type="hfield" hfield="flat"/>'}
WHEELS = {
    "ellipsoid": 'type="ellipsoid" size="0.05 0.05 0.015"',
    "cylinder": 'type="cylinder" size="0.05 0.015"',
    "sphere": 'type="sphere" size="0.05"',
}


def heading_after(seconds, floor, wheel):
    """Return the heading [degrees] of a robot that has stood without torque; it started at 0."""
    wheels = "".join(f"""
        <body pos="0 {y} 0"><joint axis="0 1 0" damping="0.001"/>
          <geom {WHEELS[wheel]} euler="90 0 0" mass="0.2"/></body>""" for y in (0.15, -0.15))
    casters = "".join(f"""
        <geom type="sphere" size="0.02" pos="{x} 0 -0.03" mass="0.01" condim="1" priority="1"/>"""
                      for x in (-0.08, 0.08))
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <asset><hfield name="flat" nrow="20" ncol="20" size="2 2 0.1 0.1"/></asset>
          <worldbody>
            {FLOORS[floor]}
            <body pos="0 0 0.0505"><freejoint/>
              <geom type="box" size="0.1 0.08 0.02" mass="4" contype="0" conaffinity="0"/>{casters}{wheels}
            </body>
          </worldbody>
        </mujoco>""")
    data = mujoco.MjData(model)
    for _ in range(round(seconds / model.opt.timestep)):
        mujoco.mj_step(model, data)
    return math.degrees(2 * math.atan2(data.qpos[6], data.qpos[3]))


turned = {(floor, wheel): heading_after(15, floor, wheel) for floor in FLOORS for wheel in WHEELS}
for (floor, wheel), angle in turned.items():
    print(f"{wheel:9s} on a {floor}: heading after 15 s {angle:8.4f} degrees")
for wheel in WHEELS:
    assert abs(turned["plane", wheel]) < 1e-6, "a robot on a plane now turns"
for wheel in ("ellipsoid", "cylinder"):
    assert abs(turned["field", wheel]) > 1, "a robot on a flat height field now stays"
assert abs(turned["field", "sphere"]) < 1e-3, "a robot on spheres now turns, too"
PYTHON
