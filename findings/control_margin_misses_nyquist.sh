#!/usr/bin/env bash
# python-control: margin() calls an unstable sampled loop infinitely robust.
#
# One would guess: control.margin of a discrete-time loop gives the factor that makes the closed loop unstable.
# What happens: a crossing of the negative real axis at z = -1, the Nyquist frequency, is left out. There first-order
#   sampled loops cross. L(z) = k/(z - 1), a wheel speed or a heading under proportional control, is stable
#   for k < 2, so its gain margin is 2/k. margin() gives inf for every k; for k = 3, with the closed-loop pole at
#   -2, both the gain and the phase margin are inf. stability_margins does the same. A loop with
#   a sample more of delay crosses earlier and is right.
# Why it matters: a gain margin of inf reads as "cannot be too high". The first instability of a sampled loop without
#   delay is the one from sample to sample, exactly the one that is not seen.
# Seen with: control 0.10.2.
# Source: https://github.com/python-control/python-control/pull/469 (the search takes angles from 0 up to, without, pi).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check control==0.10.2 numpy==2.4.6 scipy==1.17.1

"$work/venv/bin/python" -W ignore - <<'PYTHON'
import control
import numpy as np


def row(name, loop, exact):
    gain_margin, phase_margin = control.margin(loop)[:2]
    pole = max(abs(control.feedback(loop, 1).poles()))
    print(f"{name:22s} gain margin {gain_margin:6.3f} (exact {exact:.3f}), phase margin {phase_margin:7.2f} degrees, "
          f"largest closed-loop pole {pole:.2f}")
    return gain_margin, phase_margin, pole


seen = {k: row(f"{k:g}/(z - 1)", control.tf([k], [1, -1], 0.02), 2 / k) for k in (0.5, 1.0, 1.9, 3.0)}
whole = control.stability_margins(control.tf([3.0], [1, -1], 0.02))[0]
delayed = row("0.5/(z^2 - z), delayed", control.tf([0.5], [1, -1, 0], 0.02), 2.0)

assert all(np.isinf(gain_margin) for gain_margin, _, _ in seen.values()), "the crossing at z = -1 is now found"
assert np.isinf(whole), "stability_margins now finds the crossing"
assert seen[3.0][2] > 1.9 and np.isinf(seen[3.0][1]), "the unstable loop no longer has infinite margins"
assert abs(delayed[0] - 2.0) < 1e-6, "the delayed loop's margin is no longer right"
PYTHON
