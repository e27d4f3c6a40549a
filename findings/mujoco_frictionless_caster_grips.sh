#!/usr/bin/env bash
# MuJoCo: a caster declared frictionless grips the floor like rubber.
#
# One would guess: a ball caster with condim="1" (a contact without friction) or friction="0 0 0" slides.
# What happens: neither attribute has any effect. The contact takes the larger condim and the larger friction
#   of the two geoms, and the floor has the defaults, 3 and 1. A ball that is pushed along at 1 m/s slows to
#   0.71 m/s and rolls, exactly as without the attributes. Only a higher priority makes the caster's values
#   count. Nothing is said while the model is compiled.
# Why it matters: the usual way to model a caster of a differential-drive robot leaves a body that is dragged
#   sideways in every turn. Torques, turning rates and tuned gains are then those of another robot.
# Seen with: mujoco 4.0.0.
# Source: https://github.com/google-deepmind/dm_control/issues/28 (for a pair of geoms with different condim the
#   larger one is used) and https://github.com/Genesis-Embodied-AI/genesis-world/issues/2718 (MuJoCo: the higher
#   priority wins, else the larger value of each coefficient).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"  # MuJoCo writes its log into the current folder.
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check mujoco==4.0.0

"$work/venv/bin/python" - <<'PYTHON'
import mujoco


def push(caster):
    """Push a ball along the floor at 1 m/s; return its speed [m/s] 0.3 s later and the condim in force."""
    model = mujoco.MjModel.from_xml_string(f"""
        <mujoco>
          <option timestep="0.001"/>
          <worldbody>
            <geom type="plane" size="5 5 0.1"/>
            <body pos="0 0 0.05">
              <freejoint/>
              <geom type="sphere" size="0.05" mass="1" {caster}/>
            </body>
          </worldbody>
        </mujoco>""")
    data = mujoco.MjData(model)
    while data.time < 0.5:  # The ball settles on the floor.
        mujoco.mj_step(model, data)
    data.qvel[:] = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    while data.time < 0.8:
        mujoco.mj_step(model, data)
    return data.qvel[0], data.contact[0].dim


declared = {}
for caster in (
    "",
    'condim="1"',
    'friction="0 0 0"',
    'condim="1" friction="0 0 0"',
    'condim="1" priority="1"',
):
    declared[caster] = push(caster)
    speed, condim = declared[caster]
    print(f"caster with {caster or 'no attribute':29s} speed after 0.3 s {speed:.4f} m/s, condim in force {condim}")

rolls = declared[""][0]
assert abs(rolls - 5.0 / 7.0) < 0.01, "a ball no longer ends up rolling at 5/7 of its speed"
for caster in ('condim="1"', 'friction="0 0 0"', 'condim="1" friction="0 0 0"'):
    assert declared[caster] == declared[""], f"{caster} now has an effect"
assert declared['condim="1" priority="1"'][0] > 0.9999, "priority no longer lets the caster slide"
PYTHON
