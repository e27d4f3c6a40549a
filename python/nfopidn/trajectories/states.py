"""From a log of poses with uneven stamps to a trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Trajectory
from nfopidn.arguments import real_number, real_numbers
from nfopidn.trajectories.waypoints import FAR

_Array = NDArray[np.float64]

#: A position counts as an outlier where it lies this many times farther from the line between its
#: neighbours than nine in ten others do, and the speeds to and from it exceed the others' likewise.
_FARTHER, _FASTER = 20.0, 5.0
_MOST_TURN = 0.75 * np.pi
_LEAST_STAMPS = 3
_MOST_STAMP = 1e15


def _column(name: str, given: Any, count: int | None) -> _Array:
    numbers = real_numbers(name, given)
    if numbers.ndim != 1:
        raise ValueError(f"{name} has {numbers.ndim} dimensions; must have 1")
    if count is not None and len(numbers) != count:
        raise ValueError(f"{name} has {len(numbers)} numbers; must have as many as t, {count}")
    for k in np.flatnonzero(~np.isfinite(numbers)):
        raise ValueError(f"{name}[{k}] is {numbers[k]}; must be finite")
    return numbers


def _check_order(t: _Array) -> None:
    for k in np.flatnonzero(np.diff(t) < 0) + 1:
        raise ValueError(
            f"t[{k}] is {float(t[k])!r} s, before t[{k - 1}], {float(t[k - 1])!r} s; the stamps "
            "must not fall (a log of two clocks, or samples out of order: sort them, or take the "
            "stamps of one clock)"
        )


def _merged(
    t: _Array, columns: list[_Array], notes: list[str]
) -> tuple[_Array, list[_Array], NDArray[np.int64]]:
    """Return the samples with one a stamp, the mean of those that share it, and first numbers."""
    first = np.flatnonzero(np.concatenate([[True], np.diff(t) > 0]))
    if len(first) == len(t):
        return t, columns, first
    size = np.diff(np.append(first, len(t)))
    merged = [np.add.reduceat(column, first) / size for column in columns]
    spread = np.hypot(
        *(
            np.maximum.reduceat(column, first) - np.minimum.reduceat(column, first)
            for column in columns[:2]
        )
    )
    repeated = int(len(t) - len(first))
    worst = int(np.argmax(spread))
    notes.append(
        f"{repeated} of {len(t)} stamps repeat the one before; the mean of their samples is taken "
        f"(at most {spread[worst]:.3g} m apart, at t[{first[worst]}])"
    )
    return t[first], merged, first


def _check_outliers(
    t: _Array, x: _Array, y: _Array, number: NDArray[np.int64], speed_limit: float | None
) -> None:
    """Refuse positions that no robot reaches: faster than a limit, or far off and back again."""
    step = np.hypot(np.diff(x), np.diff(y))
    speed = step / np.diff(t)
    if speed_limit is not None:
        for k in map(int, np.flatnonzero(speed > speed_limit)):
            raise ValueError(
                f"sample {number[k + 1]} lies {step[k]:.4g} m from sample {number[k]}, "
                f"{t[k + 1] - t[k]:.4g} s before: a speed of {speed[k]:.4g} m/s; speed_limit is "
                f"{speed_limit:g} m/s"
            )
    if len(t) < 5:
        return
    share = (t[1:-1] - t[:-2]) / (t[2:] - t[:-2])
    off = np.hypot(*(c[1:-1] - (c[:-2] + share * (c[2:] - c[:-2])) for c in (x, y)))
    common = float(np.percentile(off, 90))
    usual = float(np.percentile(speed, 90))
    # Both steps of a wild sample are long; of the ends, which have no line, the one.
    found = 1 + np.flatnonzero(
        (off > _FARTHER * common) & (np.minimum(speed[:-1], speed[1:]) > _FASTER * usual)
    )
    ends = [0] if speed[0] > 4 * _FASTER * usual and speed[1] <= _FASTER * usual else []
    ends += [len(t) - 1] if speed[-1] > 4 * _FASTER * usual and speed[-2] <= _FASTER * usual else []
    for k in sorted([*found.tolist(), *ends]):
        jump, fast = (step[0], speed[0]) if k == 0 else (step[k - 1], speed[k - 1])
        raise ValueError(
            f"sample {number[k]} is an outlier: ({x[k]:.6g}, {y[k]:.6g}) lies {jump:.4g} m from "
            f"its neighbour, a speed of {fast:.4g} m/s, where nine in ten steps are below "
            f"{usual:.4g} m/s; leave it out, or give speed_limit if the robot is that fast"
        )
    _check_jumps(t, step, speed, usual, number)


def _check_jumps(
    t: _Array, step: _Array, speed: _Array, usual: float, number: NDArray[np.int64]
) -> None:
    """Refuse a single step that is far longer than all others: a pose that was reset."""
    order = np.sort(speed)
    k = int(np.argmax(speed))
    if usual > 0 and speed[k] > 4 * _FASTER * max(usual, float(order[-2])):
        raise ValueError(
            f"sample {number[k + 1]} is an outlier: the position jumps by {step[k]:.4g} m in "
            f"{t[k + 1] - t[k]:.4g} s, a speed of {speed[k]:.4g} m/s, where nine in ten steps are "
            f"below {usual:.4g} m/s; cut the log there, or give speed_limit if the robot is that "
            "fast"
        )


def _headings(
    t: _Array, x: _Array, y: _Array, v: _Array, omega: _Array | None, still: float
) -> _Array:
    """Return headings from the motion's direction, turned where v < 0; at rest they hold.

    With omega the heading turns by it while the robot stands.
    """
    dx, dy = np.gradient(x, t), np.gradient(y, t)
    moving = (np.hypot(dx, dy) >= still) & (np.abs(v) >= still)
    if not moving.any():
        raise ValueError(
            f"v: the robot never moves faster than {still:g} m/s, so that the positions tell no "
            "heading; give theta"
        )
    theta = np.arctan2(dy, dx) + np.where(v < 0, np.pi, 0.0)
    known = np.flatnonzero(moving)
    turned = np.zeros(len(t))
    if omega is not None:
        turned[1:] = np.cumsum(0.5 * (omega[1:] + omega[:-1]) * np.diff(t))
    before = np.maximum(np.searchsorted(known, np.arange(len(t)), side="right") - 1, 0)
    base = known[before]
    return np.where(moving, theta, theta[base] + turned - turned[base])


def _interpolant(t: _Array, column: _Array) -> Any:
    from scipy.interpolate import Akima1DInterpolator

    if len(t) < 4:
        return lambda at: np.interp(at, t, column)
    return Akima1DInterpolator(t, column, method="makima")


def _resampling_error(t: _Array, x: _Array, y: _Array) -> tuple[float, float, int]:
    """Return (largest, root mean square, sample) of what every other sample tells of the rest [m].

    An upper estimate of the error between samples: the distance that is bridged is twice theirs. A
    gap that is wider than that counts with the square of how much.
    """
    kept = np.arange(0, len(t), 2)
    left = np.arange(1, len(t) - 1, 2)
    off = np.hypot(*(_interpolant(t[kept], c[kept])(t[left]) - c[left] for c in (x, y)))
    step = np.diff(t)
    wider = max(1.0, float(step.max() / (2.0 * np.median(step)))) ** 2
    return wider * float(off.max()), float(np.sqrt(np.mean(off**2))), int(left[np.argmax(off)])


@dataclass(frozen=True)
class _States:
    """A log with one sample a stamp, about an origin near it."""

    t: _Array
    x: _Array
    y: _Array
    theta: _Array | None
    v: _Array | None
    omega: _Array | None
    number: NDArray[np.int64]  # of each sample in what was given
    origin: tuple[float, float]


def _read(given: dict[str, Any], t: Any, notes: list[str]) -> _States:
    """Check a log; say what was made of repeated stamps and of positions far away."""
    stamps = _column("t", t, None)
    for name in ("x", "y"):
        if given[name] is None:
            raise ValueError(f"{name} is None; must be (N,) numbers")
    columns = {k: _column(k, one, len(stamps)) for k, one in given.items() if one is not None}
    if len(stamps) and np.abs(stamps).max() > _MOST_STAMP:
        raise ValueError(f"t[0] is {stamps[0]:g}; must be in s, as nanoseconds divided by 1e9")
    _check_order(stamps)
    if "theta" in columns:
        columns["theta"] = np.unwrap(columns["theta"])
    names = list(columns)
    stamps, merged, number = _merged(stamps, [columns[name] for name in names], notes)
    columns = dict(zip(names, merged, strict=True))
    if len(stamps) < _LEAST_STAMPS:
        raise ValueError(
            f"t has {len(stamps)} different stamps; a trajectory needs {_LEAST_STAMPS}"
        )
    x, y = columns["x"], columns["y"]
    origin = (0.0, 0.0)
    if max(np.abs(x).max(), np.abs(y).max()) > FAR:
        origin = (float(np.round(x[0])), float(np.round(y[0])))
        x, y = x - origin[0], y - origin[1]
        notes.append(
            f"moved by ({-origin[0]:g}, {-origin[1]:g}) m, as the positions lie far from the "
            "origin; Trajectory.origin has what writers add again"
        )
    theta, v, omega = (columns.get(name) for name in ("theta", "v", "omega"))
    return _States(stamps, x, y, theta, v, omega, number, origin)


def _equal_steps(states: _States, dt: float | None, notes: list[str]) -> tuple[_Array, float]:
    """Return the times to resample to and their step; say how far that is from the stamps."""
    stamps = states.t
    step = np.diff(stamps)
    if dt is None:
        dt = float(np.median(step))
        notes.append(f"dt is {dt:.6g} s, the median step of the stamps")
    dt = real_number("dt", dt, 1e-6, 1e3, " s")
    notes.append(
        f"stamps are {step.min():.4g} to {step.max():.4g} s apart; resampled to {dt:.6g} s"
    )
    steps = int(np.floor((stamps[-1] - stamps[0]) / dt + 1e-6))
    if not 2 <= steps < 10**7:
        raise ValueError(
            f"dt is {dt:g} s; the stamps last {stamps[-1] - stamps[0]:.4g} s, which must be 3 to "
            "1e7 samples"
        )
    if len(stamps) >= 5:
        worst, rms, where = _resampling_error(stamps, states.x, states.y)
        notes.append(
            f"error of resampling: at most {worst:.3g} m, {rms:.3g} m rms, estimated at every "
            f"other sample from the rest (largest at t[{states.number[where]}])"
        )
    return np.minimum(stamps[0] + dt * np.arange(steps + 1), stamps[-1]), dt


def _compared(trajectory: Trajectory, states: _States) -> list[str]:
    """Say how far given speeds are from those of the positions and headings."""
    found = []
    for name, given, unit in (("v", states.v, "m/s"), ("omega", states.omega, "rad/s")):
        if given is None:
            continue
        own = getattr(trajectory, name)
        off = own - np.interp(trajectory.t, states.t - states.t[0], given)
        found.append(
            f"{name} is that of the {'positions' if name == 'v' else 'headings'}, "
            f"{np.sqrt(np.mean(off**2)):.3g} {unit} rms from the one given"
        )
    return found


def _given_headings(states: _States, standstill_speed: float | None) -> _Array | None:
    """Return headings (N,) that are given, or follow from the sign of v; None where neither is.

    Raises
    ------
    ValueError
        Names the sample where the heading turns so far that its sense cannot be told.
    """
    headings = states.theta
    if headings is None:
        if states.v is None:
            return None
        still = 1e-3 if standstill_speed is None else standstill_speed
        still = real_number("standstill_speed", still, 0.0, 1e3, " m/s")
        found = _headings(states.t, states.x, states.y, states.v, states.omega, still)
        headings = np.unwrap(found)
    turn = np.abs(np.diff(headings))
    for k in np.flatnonzero(turn > _MOST_TURN):
        raise ValueError(
            f"sample {states.number[k + 1]} is an outlier: the heading turns by {turn[k]:.4g} rad "
            f"in {states.t[k + 1] - states.t[k]:.4g} s, and which way cannot be told; a heading "
            "that flips by pi is a direction of travel: give v with its sign"
        )
    return headings


def from_states(
    t: Any,
    x: Any,
    y: Any,
    theta: Any = None,
    v: Any = None,
    omega: Any = None,
    dt: float | None = None,
    speed_limit: float | None = None,
    standstill_speed: float | None = None,
) -> Trajectory:
    """Return a trajectory with equal steps from a log of states.

    Stamps may be uneven, and repeat; the mean of samples that share a stamp is taken. Between
    samples the positions follow Akima's modified interpolation, whose error is estimated by
    leaving out every other sample. `Trajectory.notes` says all that was done.

    Parameters
    ----------
    t
        (N,) stamps [s], N >= 3 different ones, not falling. The trajectory begins at 0.
    x, y
        (N,) [m]. Farther than 1e4 m from the origin they are moved to the first one;
        `Trajectory.origin` has by what.
    theta
        (N,) headings [rad], any turn added: reversing and turning on the spot keep their meaning.
        None: the direction of motion, or of v < 0 its opposite.
    v
        (N,) speed along the heading [m/s]; its sign alone is used, where theta is None. How far it
        is from the positions' own is reported.
    omega
        (N,) [rad/s]; turns the heading while the robot stands, where theta is None and v is given.
    dt
        Sample time [s]; None: the median step of the stamps.
    speed_limit
        [m/s] beyond which a step between samples is refused; None: outliers are found against the
        other samples.
    standstill_speed
        [m/s], as of Trajectory.from_samples().

    Raises
    ------
    ValueError
        Names the argument and its sample; an outlier by its sample, jump and speed.
    """
    if speed_limit is not None:
        speed_limit = real_number("speed_limit", speed_limit, 1e-6, 1e6, " m/s")
    notes: list[str] = []
    states = _read({"x": x, "y": y, "theta": theta, "v": v, "omega": omega}, t, notes)
    _check_outliers(states.t, states.x, states.y, states.number, speed_limit)
    at, dt = _equal_steps(states, dt, notes)
    headings = _given_headings(states, standstill_speed)
    trajectory = Trajectory.from_samples(
        _interpolant(states.t, states.x)(at),
        _interpolant(states.t, states.y)(at),
        dt,
        theta=None if headings is None else np.interp(at, states.t, headings),
        standstill_speed=standstill_speed,
        origin=states.origin,
    )
    notes += _compared(trajectory, states)
    if headings is None:
        notes.append("the heading is the direction of motion: nothing tells reversing from it")
    notes += trajectory.notes
    return _core.annotate(trajectory, notes)
