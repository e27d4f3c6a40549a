#!/usr/bin/env bash
# MuJoCo: a body whose mass and inertia are set through MjSpec has its centre of mass somewhere else.
#
# One would guess: body.mass, body.inertia and body.explicitinertial = True give a body of that mass about its own
#   frame; the place of the inertia (ipos), which is not a number until it is set, defaults to that frame.
# What happens: the model compiles without a warning, with the right total mass. Each body's offset from its parent is
#   added a second time as the place of its centre of mass: a robot whose axle is 0.5 m above the floor has its centre
#   of mass at 0.9 m in place of 0.5, and five times the roll inertia. The text of the same spec (to_xml) has no
#   <inertial> at all, and cannot be read back. With ipos = [0, 0, 0] everything is right.
# Why it matters: a wheel's body stands half a track beside the robot's, so that the yaw inertia of a robot made this
#   way is wrong by the wheels' share, the load moves between wheels and casters, and gains tuned on it are those of
#   another robot. Mass and gravity, which one would check first, are right.
# Seen with: mujoco-core 4.0.1.
# Source: https://github.com/google-deepmind/mujoco/issues/2370 (the text lacks inertia set through MjSpec) and
#   https://mujoco.readthedocs.io/en/stable/XMLreference.html#body-inertial (in the text the place is required).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco-core==4.0.1

"$work/venv/bin/python" - <<'PYTHON'
import mujoco
import numpy as np


def robot(with_place):
    """A body of 4 kg, 0.5 m above the floor, and one of 1 kg on a hinge, 0.3 m beside it."""
    spec = mujoco.MjSpec()
    base = spec.worldbody.add_body(name="base", pos=[0, 0, 0.5])
    base.add_freejoint()
    wheel = base.add_body(name="wheel", pos=[0, 0.3, 0])
    wheel.add_joint(axis=[0, 1, 0])
    for body, mass in ((base, 4.0), (wheel, 1.0)):
        body.mass, body.inertia, body.explicitinertial = mass, [0.1, 0.1, 0.1], True
        if with_place:
            body.ipos = [0, 0, 0]
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    column = np.zeros(model.nv)
    unit = np.zeros(model.nv)
    unit[3] = 1.0
    mujoco.mj_mulM(model, data, column, unit)
    text = spec.to_xml()
    try:
        read = f"reads back {mujoco.MjModel.from_xml_string(text).body_mass.sum():.1f} kg"
    except ValueError as error:
        read = f"does not read back: {str(error).splitlines()[0]}"
    print(f"ipos {'set' if with_place else 'left'}: {model.body_mass.sum():.1f} kg, centre of mass at "
          f"{data.subtree_com[1].round(3).tolist()} m, roll inertia {column[3]:.3f} kg m^2; the text {read}")
    return data.subtree_com[1].copy(), column[3], "<inertial" in text


placed, roll, kept = robot(True)
left, other_roll, lost = robot(False)
np.testing.assert_allclose(placed, [0, 0.06, 0.5], atol=1e-12)
assert kept and abs(roll - (0.2 + 0.3**2)) < 1e-12, "with ipos the model is no longer right"
assert abs(left[2] - 0.9) < 1e-9 and other_roll > 4 * roll, "without ipos the centre of mass is no longer elsewhere"
assert not lost, "the text without ipos now has the inertia"
PYTHON
