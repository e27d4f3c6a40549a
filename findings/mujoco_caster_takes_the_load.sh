#!/usr/bin/env bash
# MuJoCo: how much of a robot's weight lies on its wheels has nothing to do with where its casters are.
#
# One would guess: of a robot with its centre of mass over the axle and a caster before and behind it, the wheels carry
#   most, and casters far away carry less than near ones; equal contacts share equally.
# What happens: the casters carry 66 % of the weight where they stand 5 cm from the axle, and the same at 30 cm. The
#   share follows from the inertia of the bodies that the contacts belong to: a contact's softness is made
#   proportional to the body's inverse inertia, and wheels stand at the ends of the axle, where the robot's roll makes
#   them light. With a fifth of the roll inertia the wheels carry 23 % in place of 34, although nothing rolls. Nothing in
#   the model speaks of stiffness or load.
# Why it matters: the load decides grip, and how much a wide wheel scrubs. Torques that a real robot's wheels
#   take skid in the simulator, or the reverse, and the roll inertia, which nobody measures for a planar robot, is
#   what a tuned gain depends on.
# Seen with: mujoco-core 4.0.1.
# Source: https://mujoco.readthedocs.io/en/stable/computation/index.html (the diagonal approximation of the constraints'
#   inverse inertia sets their regularisation) and https://github.com/newton-physics/newton/issues/2009 (how MuJoCo
#   uses body_invweight0, which is that of the whole chain at its start).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco-core==4.0.1

"$work/venv/bin/python" - <<'PYTHON'
import mujoco
import numpy as np


def share(x=0.1, roll=0.06, caster=""):
    """Return the share of the weight on the wheels of a robot at rest."""
    wheels = "".join(f"""
        <body pos="0 {y} 0"><joint axis="0 1 0"/><geom name="{name}" type="sphere" size="0.05" mass="0.1"/></body>"""
                     for name, y in (("left", 0.15), ("right", -0.15)))
    casters = "".join(f"""
        <geom type="sphere" size="0.02" pos="{place} 0 -0.03" mass="0" condim="1" priority="1" {caster}/>"""
                      for place in (-x, x))
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <worldbody>
            <geom type="plane" size="9 9 1"/>
            <body pos="0 0 0.05"><freejoint/>
              <inertial pos="0 0 0" mass="4" diaginertia="{roll} 0.06 0.06"/>{casters}{wheels}
            </body>
          </worldbody>
        </mujoco>""")
    data = mujoco.MjData(model)
    for _ in range(2000):
        mujoco.mj_step(model, data)
    mujoco.mj_forward(model, data)
    load, force = 0.0, np.zeros(6)
    for number, contact in enumerate(data.contact):
        if model.geom(contact.geom2).name in ("left", "right"):
            mujoco.mj_contactForce(model, data, number, force)
            load += force[0]
    return load / (model.body_mass.sum() * 9.81)


near, far, light = share(x=0.05), share(x=0.3), share(roll=0.012)
soft = share(caster='solref="0.2 1"')
print(f"share of the weight on the wheels: casters at 5 cm {near:.1%}, at 30 cm {far:.1%}; "
      f"a fifth of the roll inertia {light:.1%}; soft casters {soft:.1%}")
assert abs(near - far) < 1e-3, "the place of the casters now matters"
assert near < 0.45, "the wheels now carry as much as the casters"
assert light < 0.75 * near, "the roll inertia no longer matters"
assert soft > 0.9, "soft casters no longer leave the weight to the wheels"
PYTHON
