"""The fastest motion along a path under limits, by two passes over a grid.

After Pham and Pham, "A New Approach to Time-Optimal Path Parameterization Based on Reachability
Analysis", IEEE Transactions on Robotics 34(3), 2018. The position along the path is s; what is
sought is w = (ds/dt)^2 at the grid's points and u = d^2s/dt^2 between them. Every limit of an
acceleration or a torque is a half-plane A u + B w <= C at both ends of an interval. Backwards, the
largest w from which the end can still be reached; forwards, the largest u that stays below it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Robot
from nfopidn.trajectories.limits import Limits

_Array = NDArray[np.float64]
_Rows = list[tuple[float, float, float]]

#: Friction that grows with speed is linear in w about the motion found last.
_FRICTION_PASSES = 4
#: Least w between the ends, a part of the largest.
_CRAWL = 1e-6
#: Below this a limit's coefficient counts as none, against the other one's.
_NONE = 1e-12


@dataclass(frozen=True)
class Motion:
    """How a path moves the robot at N places s [m or rad], equally far apart.

    v = drive ds/dt and omega = turn ds/dt; slope is d(turn)/ds. Along a path s is its length, drive
    1 or -1 and turn its curvature; on the spot s is an angle, drive 0 and turn 1 or -1.
    """

    s: _Array
    drive: _Array
    turn: _Array
    slope: _Array
    #: Largest speed [m/s] that is asked for at each place; infinity where none is.
    speed: _Array

    @property
    def step(self) -> float:
        """Distance between two places."""
        return float(self.s[-1] / (len(self.s) - 1))


def _wheel_factors(motion: Motion, robot: Robot) -> list[_Array]:
    """Return each wheel's turning rate [rad/s] for ds/dt = 1."""
    half = 0.5 * robot.track_width * motion.turn
    return [(motion.drive + sign * half) / robot.wheel_radius for sign in (1.0, -1.0)]


def speed_limit(
    motion: Motion, limits: Limits, robot: Robot | None
) -> tuple[_Array, NDArray[np.str_]]:
    """Return the largest (ds/dt)^2 at each place that limits of speeds allow, and which does."""
    with np.errstate(divide="ignore"):
        drive, turn = np.abs(motion.drive), np.abs(motion.turn)
        bounds = {
            "speed": (np.minimum(limits.speed, motion.speed) / drive) ** 2,
            "turn_rate": (limits.turn_rate / turn) ** 2,
            "lateral_acceleration": limits.lateral_acceleration / (drive * turn),
        }
        if robot is not None:
            left = limits.wheel_torque - limits.coulomb_friction
            fastest = limits.wheel_speed
            if limits.torque_slope > 0:
                fastest = min(fastest, left / limits.torque_slope)
            for side, factor in zip(("left", "right"), _wheel_factors(motion, robot), strict=True):
                bounds[f"{side} wheel_speed"] = (fastest / np.abs(factor)) ** 2
    table = np.nan_to_num(np.stack(list(bounds.values())), nan=inf, posinf=inf)
    return table.min(axis=0), np.array(list(bounds))[table.argmin(axis=0)]


def _half_planes(
    motion: Motion, limits: Limits, robot: Robot | None, scale: _Array, about: _Array
) -> list[_Array]:
    """Return the rows (A, B, C), each (3, N), of A u + B w <= C.

    `scale` makes the limits smaller at places, `about` is the w that friction is linear about.
    """
    n = len(motion.s)
    zero = np.zeros(n)
    rows: list[_Array] = []

    def both(a: _Array, b: _Array, upper: _Array, lower: _Array) -> None:
        rows.append(np.stack([a, b, upper]))
        rows.append(np.stack([-a, -b, lower]))

    forward = np.abs(motion.drive)
    if forward.any():
        slower = limits.acceleration if limits.deceleration is None else limits.deceleration
        both(forward, zero, limits.acceleration * scale, slower * scale)
    both(motion.turn, motion.slope, *[limits.turn_acceleration * scale] * 2)
    if robot is not None and limits.wheel_torque < inf:
        drive = 0.5 * robot.mass * robot.wheel_radius
        steer = robot.inertia * robot.wheel_radius / robot.track_width
        for sign, factor in zip((1.0, -1.0), _wheel_factors(motion, robot), strict=True):
            # The root of w lies below its tangent at `about`.
            friction = limits.torque_slope * np.abs(factor)
            root = np.sqrt(about)
            rise = np.divide(0.5 * friction, root, out=np.zeros(n), where=root > 0)
            left = limits.wheel_torque - limits.coulomb_friction - 0.5 * friction * root
            a = drive * motion.drive + sign * steer * motion.turn
            b = sign * steer * motion.slope
            rows.append(np.stack([a, b + rise, left * scale]))
            rows.append(np.stack([-a, -b + rise, left * scale]))
    return [row for row in rows if np.isfinite(row).all()]


def _per_place(rows: list[_Array]) -> list[_Rows]:
    table = np.stack(rows)  # (rows, 3, N)
    return [[(a, b, c) for a, b, c in place] for place in table.transpose(2, 0, 1).tolist()]


def _interval(here: _Rows, there: _Rows, step: float) -> _Rows:
    """Return an interval's rows: those at its start and, with w + 2 step u, at its end."""
    return here + [(a + 2.0 * step * b, b, c) for a, b, c in there]


def _largest_start(rows: _Rows, most: float, end: float, step: float) -> float:
    """Return the largest w in [0, most] from which w + 2 step u in [0, end] can be had.

    The room hi(w) - lo(w) that rows leave to u is concave in w and not negative at 0; from the
    right Newton's steps come down to its zero without passing it.
    """
    two = 2.0 * step
    w = most
    sloped = []
    for a, b, c in rows:
        if abs(a) > _NONE * abs(b):
            sloped.append((1.0 / a, b, c))
        elif b > 0:
            w = min(w, c / b)
    for _ in range(100):
        high, high_slope = (end - w) / two, -1.0 / two
        low, low_slope = -w / two, -1.0 / two
        for per_a, b, c in sloped:
            bound = (c - b * w) * per_a
            if per_a > 0:
                if bound < high:
                    high, high_slope = bound, -b * per_a
            elif bound > low:
                low, low_slope = bound, -b * per_a
        room, slope = high - low, high_slope - low_slope
        if room >= 0 or slope >= 0:
            break
        w = max(0.0, w - room / slope)
        if room > -1e-13 * (1.0 + abs(high) + abs(low)):
            break
    return w


def _largest_acceleration(rows: _Rows, w: float, end: float, step: float) -> float:
    """Return the largest u that rows allow at w, and that comes to no more than `end`."""
    u = (end - w) / (2.0 * step)
    for a, b, c in rows:
        if a > 0 and abs(a) > _NONE * abs(b):
            u = min(u, (c - b * w) / a)
    return max(u, -w / (2.0 * step))


def fastest(
    motion: Motion, limits: Limits, robot: Robot | None = None, scale: _Array | None = None
) -> _Array:
    """Return the largest w = (ds/dt)^2 (N,) at the places of a path, from rest to rest.

    Parameters
    ----------
    motion
        at N places.
    limits, robot
        as of from_waypoints().
    scale
        factor (N,) in (0, 1] of limits at places: speeds' squares and accelerations.
    """
    factor = np.ones(len(motion.s)) if scale is None else scale
    most, _ = speed_limit(motion, limits, robot)
    most = most * factor
    step = motion.step
    about = np.minimum(most, _reach(motion, limits, robot))
    passes = _FRICTION_PASSES if robot is not None and limits.torque_slope > 0 else 1
    w = about
    for _ in range(passes):
        places = _per_place(_half_planes(motion, limits, robot, factor, about))
        w = _two_passes(places, most, step)
        about = np.maximum(w, 1e-4 * max(float(w.max()), 1e-12))
    return w


def _reach(motion: Motion, limits: Limits, robot: Robot | None) -> float:
    """Return a (ds/dt)^2 that no motion from rest over this path exceeds, where limits tell one."""
    bound = inf
    if np.abs(motion.drive).any():
        bound = 2.0 * limits.acceleration * motion.s[-1]
    if robot is not None and limits.wheel_torque < inf:
        pull = 2.0 * limits.wheel_torque / (robot.mass * robot.wheel_radius)
        spin = limits.wheel_torque * robot.track_width / (robot.inertia * robot.wheel_radius)
        bound = min(bound, 2.0 * motion.s[-1] * (pull + spin))
    elif not np.abs(motion.drive).any():
        bound = 2.0 * limits.turn_acceleration * motion.s[-1]
    return bound


def _two_passes(places: list[_Rows], most: _Array, step: float) -> _Array:
    """Return w at the places: backwards what can be left, forwards what can be reached."""
    last = len(places) - 1
    intervals = [_interval(places[i], places[i + 1], step) for i in range(last)]
    bound = most.tolist()
    bound[0] = bound[last] = 0.0
    ceiling = [0.0] * (last + 1)
    for i in range(last - 1, -1, -1):
        ceiling[i] = _largest_start(intervals[i], bound[i], ceiling[i + 1], step)
    w = [0.0] * (last + 1)
    for i in range(last):
        u = _largest_acceleration(intervals[i], w[i], ceiling[i + 1], step)
        w[i + 1] = min(max(0.0, w[i] + 2.0 * step * u), ceiling[i + 1])
    # Where the places do not resolve a bend, nothing may seem possible; it is passed at a crawl.
    crawl = _CRAWL * max(w)
    w[1:last] = [max(one, crawl) for one in w[1:last]]
    return np.array(w)


def times(motion: Motion, w: _Array) -> _Array:
    """Return when the motion is at each place [s]; ds/dt is linear in time in between."""
    root = np.sqrt(w)
    both = root[1:] + root[:-1]
    stuck = np.flatnonzero(both <= 0)
    if stuck.size:
        raise StandstillError(int(stuck[0]))
    return np.concatenate([[0.0], np.cumsum(2.0 * np.diff(motion.s) / both)])


class StandstillError(ValueError):
    """The path cannot be passed at a place: no speed is left there."""

    def __init__(self, place: int) -> None:
        super().__init__(f"no speed is left at place {place}")
        self.place = place


def position(motion: Motion, w: _Array, at: _Array) -> Any:
    """Return s(t) as a piecewise polynomial of SciPy, still before its start and after its end."""
    from scipy.interpolate import PPoly

    root = np.sqrt(w)
    span = np.diff(at)
    rate = np.diff(root) / span
    pieces = np.stack([0.5 * rate, root[:-1], motion.s[:-1]])
    return PPoly(pieces, at, extrapolate=False)
