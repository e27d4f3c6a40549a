#!/usr/bin/env bash
# PyBullet: a wheel under torque control does not turn, and a torque lasts for one step only.
#
# One would guess: setJointMotorControl2(..., TORQUE_CONTROL, force=0.01) puts 0.01 N·m on the wheel until another
#   command comes, as the position and velocity modes do with theirs.
# What happens: every joint of a loaded URDF comes with a motor that holds speed 0, and the torque is added to it: the
#   wheel stands still under any torque, also 100 N·m. The motor has to be switched off by a velocity command
#   with force=0. Then the torque acts, but is forgotten after one stepSimulation. With both cared for, the wheel is
#   still 13 % slow after a second, since each link has linear and angular damping of 0.04 that the URDF never
#   mentions; changeDynamics takes them away.
# Why it matters: the loop of a torque controller sampled more slowly than the simulator drives for one step in ten,
#   and the tuner finds gains ten times too high, or a robot that never moves.
# Seen with: pybullet 3.2.7.
# Source: https://github.com/bulletphysics/bullet3/issues/1562 (each joint has a motor that keeps it at rest) and
#   https://github.com/bulletphysics/bullet3/issues/2135 (only torques last for a single step).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check --only-binary :all: pybullet==3.2.7 numpy==2.4.6

"$work/venv/bin/python" - <<'PYTHON'
import pybullet

INERTIA = 0.001  # [kg m^2] about the axle
with open("wheel.urdf", "w", encoding="utf-8") as file:
    file.write(f"""
        <robot name="wheel">
          <link name="base"><inertial><mass value="1"/>
            <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
          <link name="wheel"><inertial><mass value="0.4"/>
            <inertia ixx="0.0005" iyy="0.0005" izz="{INERTIA}" ixy="0" ixz="0" iyz="0"/></inertial></link>
          <joint name="axle" type="continuous"><parent link="base"/><child link="wheel"/><axis xyz="0 0 1"/></joint>
        </robot>""")
pybullet.connect(pybullet.DIRECT)


def speed(torque, motor_off=False, every=1, damping=True):
    """Return the wheel's speed [rad/s] after 1 s (240 steps); the torque is commanded at every n-th step."""
    pybullet.resetSimulation()
    body = pybullet.loadURDF("wheel.urdf", useFixedBase=True, flags=pybullet.URDF_USE_INERTIA_FROM_FILE)
    if motor_off:
        pybullet.setJointMotorControl2(body, 0, pybullet.VELOCITY_CONTROL, force=0)
    if not damping:
        for link in (-1, 0):
            pybullet.changeDynamics(body, link, linearDamping=0, angularDamping=0)
    for step in range(240):
        if step % every == 0:
            pybullet.setJointMotorControl2(body, 0, pybullet.TORQUE_CONTROL, force=torque)
        pybullet.stepSimulation()
    return pybullet.getJointState(body, 0)[1]


expected = 0.01 / INERTIA
held = speed(0.01)
forced = speed(100.0)
damped = speed(0.01, motor_off=True)
free = speed(0.01, motor_off=True, damping=False)
tenth = speed(0.01, motor_off=True, every=10, damping=False)
print(f"0.01 N·m on {INERTIA} kg m^2 for 1 s should give {expected:.2f} rad/s; it gives:")
print(f"  as loaded                             {held:6.3f} rad/s (with 100 N·m: {forced:.3f})")
print(f"  motor switched off                    {damped:6.3f} rad/s")
print(f"  ... and the links' damping off        {free:6.3f} rad/s")
print(f"  ... commanded at every tenth step     {tenth:6.3f} rad/s")
assert held == 0.0 and forced == 0.0, "the wheel is no longer held"
assert 0.85 < damped / expected < 0.89, "the undeclared damping has changed"
assert abs(free / expected - 1.0) < 1e-6, "the remedies no longer give Newton's law"
assert abs(tenth / expected - 0.1) < 0.001, "a torque now lasts longer than one step"
PYTHON
