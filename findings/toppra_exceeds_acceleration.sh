#!/usr/bin/env bash
# TOPP-RA: the returned trajectory breaks its acceleration limit, more so on a finer grid.
#
# One would guess: compute_trajectory() returns a trajectory within the limits it was given, up to the grid's
#   error, and a grid ten times finer is ten times better.
# What happens: the speeds along the path keep the limits, but the trajectory that is returned by default is a spline
#   through them in time, which rings. With a limit of 1 the acceleration reaches 1.09 on a zigzag with the automatic grid
#   and 1.18 with 1000 intervals. parametrizer="ParametrizeConstAccel" gives 1.000 on both, at the same
#   duration. With collocation instead of interpolation, the default of torque constraints, 20 intervals
#   reach 2.2 to 2.6 times the limit with either.
# Why it matters: as a reference for a torque-limited robot it asks for torque that the robot does not have just where
#   the planner claims to use all of it: the controller saturates and is blamed.
# Seen with: toppra 0.6.10.
# Source: https://github.com/hungpham2511/toppra/issues/150 (the default is spline-based and vibrates),
#   https://github.com/hungpham2511/toppra/issues/198 (collocation does not keep the limits).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check toppra==0.6.10 numpy==2.4.6 scipy==1.17.1

"$work/venv/bin/python" -W ignore - <<'PYTHON'
import numpy as np
import toppra
from toppra.algorithm import TOPPRA
from toppra.constraint import DiscretizationType, JointAccelerationConstraint, JointVelocityConstraint

toppra.setup_logging("ERROR")
WAYPOINTS = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [2.0, 1.0]])
PATH = toppra.SplineInterpolator(np.linspace(0.0, 1.0, len(WAYPOINTS)), WAYPOINTS)
LIMIT = np.array([[-1.0, 1.0]] * 2)


def worst(intervals=None, scheme=None, **settings):
    """Return the largest acceleration of the trajectory over its limit."""
    chosen = {} if scheme is None else {"discretization_scheme": scheme}
    constraints = [JointVelocityConstraint(LIMIT), JointAccelerationConstraint(LIMIT, **chosen)]
    grid = None if intervals is None else np.linspace(0.0, 1.0, intervals + 1)
    trajectory = TOPPRA(constraints, PATH, gridpoints=grid, **settings).compute_trajectory(0.0, 0.0)
    times = np.linspace(0.0, trajectory.duration, 4001)
    largest = np.abs(trajectory(times, 2)).max()
    print(f"  {'automatic grid' if grid is None else f'{intervals} intervals':14s} "
          f"{settings.get('parametrizer', 'default'):22s} {scheme.name if scheme else 'default':14s} "
          f"{trajectory.duration:.3f} s, acceleration {largest:.3f}")
    return largest


print("limits: speed 1, acceleration 1")
automatic, fine = worst(), worst(1000)
steady = [worst(intervals, parametrizer="ParametrizeConstAccel") for intervals in (None, 1000)]
coarse = worst(20, DiscretizationType.Collocation)
assert automatic > 1.05 and fine > automatic, "the default no longer overshoots, or a finer grid helps now"
assert max(steady) < 1.005, "ParametrizeConstAccel no longer keeps the limit"
assert coarse > 2.0, "collocation on a coarse grid no longer breaks the limit"
PYTHON
