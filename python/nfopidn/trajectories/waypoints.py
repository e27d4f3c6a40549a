"""From waypoints to a trajectory that the robot can drive."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil, inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Robot, Trajectory
from nfopidn.arguments import real_number, real_numbers, whole_number
from nfopidn.trajectories.limits import Limits, uses
from nfopidn.trajectories.pieces import (
    Piece,
    Points,
    choose_stops,
    event_of_piece,
    event_of_turn,
    fit_pieces,
    wrap,
)
from nfopidn.trajectories.smoothing import Event, sample_within
from nfopidn.trajectories.timing import speed_limit

_Array = NDArray[np.float64]

#: Farther from the origin than this, positions are moved [m].
FAR = 1e4
#: Points nearer than this are at one place [m].
COINCIDE = 1e-6
_MOST_SAMPLES = 1e7
#: Places on the way to the greatest speed.
_PLACES_TO_SPEED = 40
#: Samples over which accelerations are averaged unless smoothing is given.
_SMOOTHED_SAMPLES = 5


@dataclass(frozen=True)
class Plan:
    """A trajectory through waypoints and how it came about.

    Attributes
    ----------
    trajectory
        from rest to rest, a sample at rest at both ends.
    fastest
        Time [s] of the fastest motion within the limits, rests included, before smoothing and
        sampling, which take the rest of the trajectory's time.
    length
        of the path [m].
    stops
        (number of the waypoint, why) of each stop between the ends.
    use
        For each finite limit, the largest share of it that a sample uses.
    """

    trajectory: Trajectory
    fastest: float
    length: float
    stops: tuple[tuple[int, str], ...]
    use: dict[str, float]


def _per_point(name: str, given: Any, count: int, least: float, most: float, free: float) -> _Array:
    """Return numbers of the points (N,); nan, where a point has none, becomes `free`."""
    if given is None:
        return np.full(count, free)
    numbers = real_numbers(name, given)
    if numbers.shape != (count,):
        raise ValueError(f"{name} has shape {numbers.shape}; must have one number a point, {count}")
    for k in np.flatnonzero(~np.isnan(numbers) & ~((numbers >= least) & (numbers <= most))):
        raise ValueError(
            f"{name}[{k}] is {numbers[k]:g}; must be in [{least:g}, {most:g}], or nan where the "
            "point has none"
        )
    return np.where(np.isnan(numbers), free, numbers)


def _directions(given: Any, count: int, closed: bool) -> NDArray[np.bool_]:
    """Return the flags (N,) of the legs that leave each point."""
    if given is None:
        return np.zeros(count, dtype=bool)
    flags = real_numbers("reverse", given)
    if flags.shape == (count - 1,) and not closed:
        flags = np.append(flags, flags[-1] if count > 1 else 0)
    if flags.shape != (count,):
        raise ValueError(
            f"reverse has shape {flags.shape}; must have one flag for the leg that leaves each of "
            f"{count} points"
        )
    for k in np.flatnonzero((flags != 0) & (flags != 1)):
        raise ValueError(f"reverse[{k}] is {flags[k]:g}; must be 0 or 1")
    backwards: NDArray[np.bool_] = flags != 0
    return backwards


def _positions(points: Any) -> _Array:
    xy = real_numbers("points", points)
    if xy.ndim != 2 or xy.shape[1] != 2:
        raise ValueError(f"points has shape {xy.shape}; must be (N, 2), x and y [m] of each")
    if len(xy) < 2:
        raise ValueError(f"points has {len(xy)} rows; a path needs at least 2")
    for k in np.flatnonzero(~np.isfinite(xy).all(axis=1)):
        raise ValueError(f"points[{k}] is ({xy[k, 0]:g}, {xy[k, 1]:g}); must be finite")
    if np.abs(xy).max() > 1e9:
        k = np.argmax(np.abs(xy).max(axis=1))
        raise ValueError(
            f"points[{k}] is ({xy[k, 0]:g}, {xy[k, 1]:g}); must be in [-1e+09, 1e+09] m"
        )
    return xy


def _check_apart(xy: _Array, theta: _Array) -> None:
    """Refuse neighbours at one place."""
    near = np.hypot(*np.diff(xy, axis=0).T) <= COINCIDE
    for k in np.flatnonzero(near):
        why = "give its dwell to wait there"
        if np.isfinite(theta[k : k + 2]).all() and theta[k] != theta[k + 1]:
            why = "the robot turns on the spot where a heading asks for it; give the one wanted"
        raise ValueError(
            f"points[{k}] and points[{k + 1}] are both at ({xy[k, 0]:g}, {xy[k, 1]:g}); leave one "
            f"out ({why})"
        )


def _read(
    points: Any, theta: Any, speed: Any, reverse: Any, dwell: Any, closed: bool, laps: int
) -> tuple[Points, tuple[float, float], list[str]]:
    """Return the points of all laps about an origin near them, the origin, and what to say."""
    xy = _positions(points)
    count = len(xy)
    headings = _per_point("theta", theta, count, -1e6, 1e6, np.nan)
    speeds = _per_point("speed", speed, count, 0.0, 1e6, inf)
    dwells = _per_point("dwell", dwell, count, 0.0, 1e6, 0.0)
    backwards = _directions(reverse, count, closed)
    notes = []
    origin = (0.0, 0.0)
    if np.abs(xy).max() > FAR:
        origin = (float(np.round(xy[0, 0])), float(np.round(xy[0, 1])))
        xy = xy - origin
        notes.append(
            f"moved by ({-origin[0]:g}, {-origin[1]:g}) m, as the points lie far from the origin; "
            "Trajectory.origin has what writers add again"
        )
    number = np.arange(count)
    if closed:
        if np.hypot(*(xy[-1] - xy[0])) <= COINCIDE:
            xy, headings, speeds, dwells = xy[:-1], headings[:-1], speeds[:-1], dwells[:-1]
            backwards, number = backwards[:-1], number[:-1]
            notes.append("the last point is the first: the path is closed there once")
        if len(xy) < 3:
            raise ValueError(f"points has {len(xy)} places; a closed path needs at least 3")
        lap = np.tile(np.arange(len(xy)), laps)
        every = np.append(lap, 0)
        legs = backwards[lap]
    elif laps != 1:
        raise ValueError(f"laps is {laps}; must be 1 for a path that is not closed")
    else:
        every, legs = np.arange(count), backwards[:-1]
    _check_apart(xy[every], headings[every])
    stop = np.zeros(len(every), dtype=bool)
    stop[[0, -1]] = True
    read = Points(
        xy[every],
        headings[every],
        speeds[every],
        dwells[every],
        legs,
        stop,
        number[every],
        set(),
        {},
    )
    if closed:
        read.dwell[-1] = 0.0  # it is the start's, and a lap's end waits in between alone
        read.theta[-1] = read.theta[0]
    return read, origin, notes


def _unattainable(
    points: Points,
    first: int,
    last: int,
    piece: Piece,
    event: Event,
    limits: Limits,
    robot: Robot | None,
) -> list[tuple[float, str]]:
    """Return each speed that is given at a point and that no motion can have there, in words.

    Before the words stands the share of it that can be had.
    """
    found = []
    free = replace(event.motion, speed=np.full(len(event.motion.s), inf))
    most, by = speed_limit(free, limits, robot)
    for k in range(first, last + 1):
        wanted = points.speed[k]
        if not np.isfinite(wanted) or wanted == 0:
            continue
        place = int(np.argmin(np.abs(event.motion.s - piece.at_points[k - first])))
        allowed = float(np.sqrt(most[place]))
        if wanted <= allowed * (1 + 1e-9):
            continue
        name = str(by[place])
        limit = getattr(limits, name.rsplit(maxsplit=1)[-1])
        which = f"{name}, {limit:g}," if limit < inf else f"{name}, by friction and back EMF,"
        x, y = points.xy[k]
        words = (
            f"speed[{points.number[k]}] is {wanted:g} m/s; cannot be driven: at "
            f"{event.motion.s[place]:.4g} m along the path from the stop before, at ({x:.4g}, "
            f"{y:.4g}), {which} allows {allowed:.4g} m/s"
        )
        found.append((allowed / wanted, words))
    return found


def _finest(limits: Limits, robot: Robot | None) -> float:
    """Return how far apart places may be [m]: a part of the way to the greatest speed."""
    speed, pull = limits.speed, limits.acceleration
    if robot is not None:
        speed = min(speed, robot.wheel_radius * min(limits.wheel_speed, limits.no_load_speed))
        pull = min(pull, 2.0 * limits.wheel_torque / (robot.mass * robot.wheel_radius))
    return speed**2 / (2.0 * pull) / _PLACES_TO_SPEED


def _items(
    points: Points, fitted: list[Any], limits: Limits, robot: Robot | None, dt: float
) -> tuple[list[Event | int], list[tuple[float, str]]]:
    """Return the motions along the pieces, turns on the spot and rests, in order.

    And the speeds that are given and cannot be had, as _unattainable() has them.
    """
    items: list[Event | int] = []
    too_fast: list[tuple[float, str]] = []

    def turn_to(pose: _Array, heading: float) -> _Array:
        angle = float(wrap(heading - pose[2]))
        event = event_of_turn(pose, angle)
        if event is None:
            return pose
        if min(limits.turn_acceleration, limits.wheel_torque) == inf:
            raise ValueError(
                f"cannot be driven: at ({pose[0]:.4g}, {pose[1]:.4g}) the robot turns on the spot "
                f"by {angle:.3g} rad, and nothing limits how fast; give limits.turn_acceleration "
                "or limits.wheel_torque"
            )
        items.append(event)
        turned: _Array = pose + np.array([0.0, 0.0, angle])
        return turned

    pose: _Array | None = None
    for first, last, piece, s, kappa, change in fitted:
        begin = piece.pose(s[:1])[0]
        if pose is None:
            pose = begin.copy()
            if np.isfinite(points.theta[0]):
                pose[2] = points.theta[0]
        elif np.isfinite(points.theta[first]):
            pose = turn_to(pose, points.theta[first])
        items.append(ceil(points.dwell[first] / dt - 1e-9))
        turn_to(pose, begin[2])
        event = event_of_piece(piece, s, kappa, change, points.speed[first : last + 1])
        too_fast += _unattainable(points, first, last, piece, event, limits, robot)
        items.append(event)
        pose = piece.pose(s)[-1]
    assert pose is not None
    if np.isfinite(points.theta[-1]):
        turn_to(pose, points.theta[-1])
    items.append(ceil(points.dwell[-1] / dt - 1e-9))
    return items, too_fast


def _check_size(items: list[Event | int], limits: Limits, robot: Robot | None, dt: float) -> None:
    """Refuse what would take more samples than a trajectory has."""
    total = 0.0
    for item in items:
        total += item * dt if isinstance(item, int) else float(item.plan(limits, robot)[1][-1])
    if total / dt > _MOST_SAMPLES:
        raise ValueError(
            f"the motion takes {total:.4g} s, {total / dt:.3g} samples of dt {dt:g} s; a "
            f"trajectory has at most {_MOST_SAMPLES:g}"
        )


def plan_waypoints(
    points: Any,
    limits: Limits,
    dt: float,
    robot: Robot | None = None,
    theta: Any = None,
    speed: Any = None,
    reverse: Any = None,
    dwell: Any = None,
    closed: bool = False,
    laps: int = 1,
    tolerance: float = 0.0,
    corner: float = 2.0,
    smoothing: float | None = None,
    *,
    lower_speeds: bool = False,
) -> Plan:
    """Return from_waypoints()'s trajectory with its time, its stops and its use of the limits.

    Parameters, errors: those of from_waypoints(). With `lower_speeds` a speed that limits do not
    allow at its point is lowered to what they do, in place of being refused; the notes say so.
    """
    if not isinstance(limits, Limits):
        raise ValueError(f"limits is {limits!r}; must be a Limits")
    limits.check_robot(robot)
    dt = real_number("dt", dt, 1e-6, 1e3, " s")
    laps = whole_number("laps", laps, 1, 10**6)
    tolerance = real_number("tolerance", tolerance, 0.0, 1e6, " m")
    corner = real_number("corner", corner, 1e-3, float(np.pi), " rad")
    if smoothing is None:
        smoothing = _SMOOTHED_SAMPLES * dt
    smoothing = real_number("smoothing", smoothing, 0.0, 1e3, " s")
    read, origin, notes = _read(points, theta, speed, reverse, dwell, closed, laps)
    choose_stops(read, corner)
    ring = bool(closed) and not read.stop[1:-1].any()
    fitted = fit_pieces(read, ring, tolerance, _finest(limits, robot))
    items, too_fast = _items(read, fitted, limits, robot, dt)
    if too_fast and not lower_speeds:
        raise ValueError(too_fast[0][1])
    _check_size(items, limits, robot, dt)
    sampled = sample_within(items, limits, robot, dt, smoothing, origin)
    trajectory = sampled.trajectory
    length = sum(piece.length for _, _, piece, *_ in fitted)
    stops = tuple((int(read.number[k]), read.why[k]) for k in sorted(read.why))
    use = {one.name: float(one.ratio.max()) for one in uses(trajectory, limits, robot)}
    notes.insert(
        0,
        f"from waypoints: {length:.4g} m in {trajectory.t[-1]:.4g} s "
        f"({sampled.fastest:.4g} s before smoothing and sampling); of the limits it uses "
        + ", ".join(f"{name} {100 * share:.0f} %" for name, share in use.items()),
    )
    if too_fast:
        notes.append(f"slower than asked at {len(too_fast)} points; most: {min(too_fast)[1]}")
    if stops:
        notes.append("stops at " + ", ".join(f"points[{k}] ({why})" for k, why in stops))
    return Plan(_core.annotate(trajectory, notes), sampled.fastest, length, stops, use)


def from_waypoints(
    points: Any,
    limits: Limits,
    dt: float,
    robot: Robot | None = None,
    theta: Any = None,
    speed: Any = None,
    reverse: Any = None,
    dwell: Any = None,
    closed: bool = False,
    laps: int = 1,
    tolerance: float = 0.0,
    corner: float = 2.0,
    smoothing: float | None = None,
) -> Trajectory:
    """Return the fastest trajectory through waypoints that keeps limits, from rest to rest.

    The path is a spline with four continuous derivatives, of least integral of its third one's
    square, cut where the robot must stop: at a dwell, a change of the direction of travel, a speed
    of 0, a corner, a heading off the path, or where the curve would bend within a twentieth of the
    leg beside it. There the robot turns on the spot. Along the path it is as fast as the limits
    allow (Pham and Pham 2018). Every limit holds at every sample of v, omega and their derivatives,
    which are differences of the samples; where smoothing would exceed one, the motion is slower.

    Parameters
    ----------
    points
        (N, 2), x and y [m]. Farther than 1e4 m from the origin they are moved to the first one;
        `Trajectory.origin` has by what.
    limits
        Limits of speed, acceleration, ...; those of wheels need `robot`.
    dt
        Sample time [s]; a piece between stops takes a whole number of samples.
    robot
        the Robot whose wheels are limited.
    theta
        (N,) [rad], the robot's heading at points; nan where it is free. Nearer than corner/2 to
        the way there it gives the curve's tangent; otherwise the robot stops and turns to it.
    speed
        (N,) [m/s], the largest speed at points, linear in the path between two neighbours that both
        have one; nan where it is free, 0 to stop.
    reverse
        (N,) or (N - 1,), whether the robot drives backwards on the leg that leaves each point.
    dwell
        (N,) [s], how long the robot waits at points.
    closed
        The path goes on from the last point to the first, where the motion begins and ends at rest.
    laps
        of a closed path.
    tolerance
        How far the curve may pass inner points [m]; 0: through them.
    corner
        Turn between legs [rad] beyond which the robot stops to turn on the spot.
    smoothing
        Time [s] over which the acceleration is averaged, so that the feedforward torques are
        continuous; None: five samples; 0: none.

    Raises
    ------
    ValueError
        Names the argument, its value and its range; neighbours at one place; or, where a given
        speed cannot be driven, the place along the path, the limit and what it allows.
    """
    return plan_waypoints(
        points,
        limits,
        dt,
        robot,
        theta,
        speed,
        reverse,
        dwell,
        closed,
        laps,
        tolerance,
        corner,
        smoothing,
    ).trajectory
