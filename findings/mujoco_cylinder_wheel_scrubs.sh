#!/usr/bin/env bash
# MuJoCo: a robot on cylinder wheels turns at a third of the acceleration that its torques give.
#
# One would guess: wheels drawn as cylinders, as every URDF has them, touch the floor along a line and act like thin
#   wheels; their width is for the eye.
# What happens: a cylinder on a plane has a contact point at each rim. While the robot turns, the two rims of a wheel
#   have to run at different speeds, so both slip and brake. The yaw acceleration falls with the width: for a 4 kg
#   robot with 0.1 N·m a wheel it is 17.3 rad/s² on ellipsoids, 11.8 on tyres of 2 cm and 5.7 on tyres of 4 cm, a
#   third. Turning the torque five times higher hides most of it, as the loss is dry friction. Ellipsoid
#   wheels of the same sizes have one contact each and lose nothing.
# Why it matters: gains tuned on the model of a paper (point contacts) meet a yaw friction that they never saw, and
#   gains tuned in the simulator turn a real robot on thin wheels far too fast.
# Seen with: mujoco 4.0.0.
# Source: https://github.com/google-deepmind/mujoco/issues/575 (a cylinder standing on its contact points) and
#   https://mujoco.readthedocs.io/en/stable/computation/index.html (contacts are points, each with its own friction).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0

"$work/venv/bin/python" - <<'PYTHON'
import mujoco


def yaw_acceleration(wheel, half_width, torque=0.1):
    """Return the mean yaw acceleration [rad/s^2] over 0.2 s from rest, wheels driven against each other."""
    size = {"cylinder": f"0.05 {half_width}", "ellipsoid": f"0.05 0.05 {half_width}"}[wheel]
    sides = "".join(f"""
        <body pos="0 {y} 0"><joint name="{side}" axis="0 1 0"/>
          <geom type="{wheel}" size="{size}" euler="90 0 0" mass="0.2"/></body>"""
                    for side, y in (("left", 0.15), ("right", -0.15)))
    casters = "".join(f"""
        <geom type="sphere" size="0.02" pos="{x} 0 -0.03" mass="0.01" condim="1" priority="1"/>"""
                      for x in (-0.08, 0.08))
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="0.0005"/>
          <worldbody>
            <geom type="plane" size="5 5 0.1"/>
            <body pos="0 0 0.05"><freejoint/>
              <geom type="box" size="0.1 0.08 0.02" mass="4" contype="0" conaffinity="0"/>
              {casters}{sides}
            </body>
          </worldbody>
          <actuator><motor joint="left"/><motor joint="right"/></actuator>
        </mujoco>""")
    data = mujoco.MjData(model)
    while data.time < 0.5:  # The robot settles.
        mujoco.mj_step(model, data)
    contacts = data.ncon
    data.qvel[:] = 0.0
    data.ctrl[:] = [-torque, torque]
    while data.time < 0.7:
        mujoco.mj_step(model, data)
    return data.qvel[5] / 0.2, contacts - 2  # Two contacts are the casters'.


seen = {}
for wheel in ("ellipsoid", "cylinder"):
    for half_width in (0.005, 0.01, 0.02):
        seen[wheel, half_width], contacts = yaw_acceleration(wheel, half_width)
        print(f"{wheel:9s} {2000 * half_width:3.0f} mm wide: {seen[wheel, half_width]:6.2f} rad/s^2, "
              f"{contacts} contacts of the two wheels")
strong = yaw_acceleration("cylinder", 0.02, 0.5)[0] / yaw_acceleration("ellipsoid", 0.02, 0.5)[0]
print(f"at 0.5 N·m the 40 mm cylinders keep {strong:.0%} of the ellipsoids' acceleration")
ratio = seen["cylinder", 0.02] / seen["ellipsoid", 0.02]
print(f"at 0.1 N·m they keep {ratio:.0%}")
assert abs(seen["ellipsoid", 0.02] / seen["ellipsoid", 0.005] - 1.0) < 0.01, "ellipsoids now scrub, too"
assert 0.25 < ratio < 0.42 and 0.55 < strong < 0.8, "cylinder wheels no longer scrub as recorded"
PYTHON
