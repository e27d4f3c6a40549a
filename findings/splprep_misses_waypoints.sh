#!/usr/bin/env bash
# SciPy: splprep draws a path that misses its waypoints by half a metre.
#
# One would guess: splprep([x, y]), the usual way from waypoints to a smooth path, interpolates, as its sister splrep
#   and CubicSpline do; s is there to ask for smoothing.
# What happens: without s, splprep smooths, splrep does not. The default allows a sum of squared distances of about the
#   number of points, which is the right amount if each point has an error of 1 (metre). Fifty exact points on a
#   circle of 1 m give a closed thing with radii from 0.74 to 1.47 m, in one cubic piece. In millimetres the
#   same call follows the points; so the shape depends on the unit. s=0 interpolates.
# Why it matters: rooms, tables and laboratory robots have paths of this size. The controller follows the reference
#   perfectly and the robot misses the waypoints, and curvature and torques are those of another path.
# Seen with: scipy 1.17.1.
# Source: https://github.com/scipy/scipy/pull/16860 (what s=None means) and
#   https://github.com/scipy/scipy/issues/11916 (the right s depends on the data's own scale).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check numpy==2.4.6 scipy==1.17.1

"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
from scipy.interpolate import splev, splprep, splrep

ANGLES = np.linspace(0.0, 2.0 * np.pi, 50)


def worst(unit, **settings):
    """Return the largest distance [m] of the path from a circle of 1 m, points given in a unit [1/m]."""
    points = [unit * np.cos(ANGLES), unit * np.sin(ANGLES)]
    spline, _ = splprep(points, **settings)
    radii = np.hypot(*splev(np.linspace(0.0, 1.0, 500), spline)) / unit
    print(f"  splprep, unit 1/{unit:g} m, {settings or 'defaults'}: radii {radii.min():.3f} to {radii.max():.3f} m, "
          f"{len(spline[0]) - 7} pieces")
    return np.abs(radii - 1.0).max()


print("50 exact points on a circle of 1 m")
metres, millimetres, exact = worst(1.0), worst(1000.0), worst(1.0, s=0)
sister = splrep(ANGLES, np.cos(ANGLES))
miss = np.abs(splev(ANGLES, sister) - np.cos(ANGLES)).max()
print(f"  splrep, defaults: misses its points by {miss:.0e}")
assert metres > 0.2, "splprep no longer smooths by default"
assert millimetres < 0.01 and exact < 1e-4 and miss < 1e-12, "the cases that are right have changed"
PYTHON
