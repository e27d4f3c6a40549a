#!/usr/bin/env bash
# MuJoCo: a robot read from its URDF has no chassis; the wheels turn, bolted to the world.
#
# One would guess: the URDF of a mobile robot (base_link with a mass and two wheels on continuous joints) gives a
#   body that can drive, as the root of a URDF is not attached to anything.
# What happens: the root link becomes the world. It is no body of its own any more, its 5 kg are gone from the
#   model without a warning, and the only two degrees of freedom are the wheels. Every simulation runs, the wheel
#   speeds look right, and the pose never changes. A massless link and a floating joint put above base_link in the
#   URDF bring the chassis and its six degrees of freedom back.
# Why it matters: wheel odometry computed from such a run looks like a perfect robot, one whose wheels carry no
#   load, and torques tuned on it are those of wheels in the air.
# Seen with: mujoco 4.0.0.
# Source: https://github.com/google-deepmind/mujoco/issues/1176 (the base link is deleted) and
#   https://github.com/robotology/icub-models/issues/155 (the first link turns into the world; a floating joint helps).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0

"$work/venv/bin/python" - <<'PYTHON'
import mujoco

WHEEL = """
    <link name="{side}_wheel"><inertial><mass value="0.4"/>
      <inertia ixx="0.0005" iyy="0.001" izz="0.0005" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="{side}" type="continuous"><parent link="base_link"/><child link="{side}_wheel"/>
      <origin xyz="0 {y} 0"/><axis xyz="0 1 0"/></joint>"""
CHASSIS = """
    <link name="base_link"><inertial><mass value="5"/>
      <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
FLOATING = """
    <link name="ground"/>
    <joint name="float" type="floating"><parent link="ground"/><child link="base_link"/></joint>"""


def load(extra):
    wheels = WHEEL.format(side="left", y="0.1") + WHEEL.format(side="right", y="-0.1")
    model = mujoco.MjModel.from_xml_string(f'<robot name="robot">{extra}{CHASSIS}{wheels}</robot>')
    names = [model.body(body).name for body in range(model.nbody)]
    print(f"  bodies {names}, mass {model.body_mass.sum():.1f} kg, degrees of freedom {model.nv}")
    return model


print("the URDF holds 5.8 kg: base_link 5.0 kg, two wheels of 0.4 kg")
print("as it is:")
plain = load("")
print("with a floating joint above base_link:")
floating = load(FLOATING)

data = mujoco.MjData(plain)
data.qvel[:] = 10.0
mujoco.mj_step(plain, data)
print(f"after a step at 10 rad/s the whole state is the two wheel angles: {data.qpos}")

assert plain.nv == 2 and abs(plain.body_mass.sum() - 0.8) < 1e-9, "the chassis is no longer lost"
assert floating.nv == 8 and abs(floating.body_mass.sum() - 5.8) < 1e-9, "the floating joint no longer helps"
PYTHON
