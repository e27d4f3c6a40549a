"""What a log holds of a motion and its commands, checked and brought to SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Robot
from nfopidn.arguments import real_number, real_numbers, shown
from nfopidn.formats import Log

Array = NDArray[np.float64]

COMMANDS = {
    "torque": ("tau_left", "tau_right"),
    "voltage": ("voltage_left", "voltage_right"),
    "velocity": ("v_command", "omega_command"),
    "odometry": ("counts_left", "counts_right"),
}
_UNITS = {"torque": "N m", "voltage": "V", "velocity": "m/s, rad/s", "odometry": "counts"}
_POSE = ("x", "y", "theta")
_COUNTS = ("counts_left", "counts_right")
LEAST_ROWS = 50


@dataclass(frozen=True)
class Motion:
    """A log as the models take it.

    Attributes
    ----------
    t
        (n,) stamps of the poses [s], rising, the first is 0.
    pose
        (n, 3) x, y [m], theta [rad] without jumps.
    command_t
        (m,) stamps of the commands [s] on the same zero, rising; each holds until the next.
    command
        (m, 2) in the paper's sign where they are of wheels: the left one turns counter-clockwise.
    notes
        what was made of the log.
    """

    t: Array
    pose: Array
    command_t: Array
    command: Array
    notes: tuple[str, ...]

    @property
    def dt(self) -> float:
        """Sample time of the commands [s]: the median of their steps."""
        return float(np.median(np.diff(self.command_t)))


def motion_of(
    log: Any,
    commands: Any,
    model: str,
    signs: str,
    robot: Robot | None,
    counts_per_turn: float | None,
    counter_range: float | None,
) -> Motion:
    """Return the motion and the commands of a log.

    Raises
    ------
    ValueError
        A column is missing, of another length, not finite; stamps fall; there are too few rows.
    """
    columns = _mapping(log, commands, model)
    notes: list[str] = list(log.notes) if isinstance(log, Log) else []
    names = COMMANDS[model]
    counted = all(name in columns for name in _COUNTS)
    posed = all(name in columns for name in _POSE)
    odometry = model == "odometry"
    if not posed and (odometry or not counted):
        raise ValueError(
            f"log has no column {_missing(columns, _POSE)}; it needs t, {', '.join(_POSE)} "
            f"{'' if odometry else '(or ' + ' and '.join(_COUNTS) + ') '}"
            f"and {', '.join(names)} [{_UNITS[model]}]; it has "
            f"{', '.join(map(str, columns)) or 'none'}"
        )
    needed = ("t", *(_POSE if posed else _COUNTS), *names)
    if _missing(columns, needed):
        raise ValueError(
            f"log has no column {_missing(columns, needed)}; model={model!r} needs "
            f"{', '.join(needed)}"
        )
    of_pose = {name: _column(columns, name) for name in needed[:-2]}
    of_command = {name: _column(columns, name) for name in names}
    clock = "t_command" if "t_command" in columns else "t"
    of_command["t"] = _column(columns, clock)
    of_pose = _rising(of_pose, "t", notes)
    of_command = _rising(of_command, clock, notes)
    if clock != "t":
        notes.append("commands have their own clock: the delay is that and the clocks' difference")
    if not posed:
        _reckon(of_pose, signs, robot, counts_per_turn, counter_range, notes)
    elif counted and not odometry:
        notes.append("counts are not used, as there are poses")
    zero = of_pose["t"][0]
    if odometry:
        _rates(of_command, counts_per_turn, counter_range, notes)
    command = np.column_stack([of_command[name] for name in names])
    if model != "velocity" and signs == "rep103":
        command = command[:, ::-1]
    pose = np.column_stack([of_pose["x"], of_pose["y"], np.unwrap(of_pose["theta"])])
    pose[:, :2] -= pose[0, :2]
    return Motion(
        of_pose["t"] - zero, pose, of_command["t"] - zero, np.ascontiguousarray(command), (*notes,)
    )


def _mapping(log: Any, commands: Any, model: str) -> dict[str, Any]:
    """Return the columns of a mapping, a data frame or a Log, with those of the commands."""
    columns: dict[str, Any] = {}
    if isinstance(log, Log):
        if commands is None:
            raise ValueError(
                f"commands is None, and log is a Log of states alone; must be a mapping of t and "
                f"{', '.join(COMMANDS[model])}"
            )
        if log.t is None or log.theta is None:
            what = "times" if log.t is None else "headings"
            raise ValueError(f"log of {log.source or 'no source'} has no {what}")
        columns = {"t": log.t + log.start, "x": log.x, "y": log.y, "theta": log.theta}
    else:
        columns = _named("log", log)
    if commands is not None:
        given = _named("commands", commands)
        if "t" not in given:
            raise ValueError("commands has no column t; its own stamps [s]")
        columns["t_command"] = given.pop("t")
        columns |= {name: column for name, column in given.items() if name in COMMANDS[model]}
    return columns


def _named(what: str, given: Any) -> dict[str, Any]:
    if not hasattr(given, "keys") or not hasattr(given, "__getitem__"):
        raise ValueError(f"{what} is a {type(given).__name__}; must be a mapping of columns")
    return {str(name): given[name] for name in given.keys()}  # noqa: SIM118 (of data frames too)


def _missing(columns: Mapping[str, Any], needed: tuple[str, ...]) -> str:
    return ", ".join(name for name in needed if name not in columns)


def _column(columns: Mapping[str, Any], name: str) -> Array:
    column = real_numbers(f"log[{name!r}]", columns[name])
    if column.ndim != 1:
        raise ValueError(f"log[{name!r}] has the shape {column.shape}; must be a list of numbers")
    bad = np.flatnonzero(~np.isfinite(column))
    if len(bad):
        raise ValueError(f"log[{name!r}][{bad[0]}] is {column[bad[0]]}; must be finite")
    return column


def _rising(columns: dict[str, Array], clock: str, notes: list[str]) -> dict[str, Array]:
    """Return the rows whose stamps rise: of repeated stamps the last row."""
    rows = columns["t"].shape
    for name, column in columns.items():
        if column.shape != rows:
            raise ValueError(
                f"log[{name!r}] has {column.size} numbers; must have as many as log[{clock!r}], "
                f"{rows[0]}"
            )
    if rows[0] < LEAST_ROWS:
        raise ValueError(f"log[{clock!r}] has {rows[0]} rows; must have at least {LEAST_ROWS}")
    t = columns["t"]
    steps = np.diff(t)
    if (steps < 0).any():
        place = int(np.argmax(steps < 0))
        raise ValueError(
            f"log[{clock!r}] falls: {t[place]:.9g} s is followed by {t[place + 1]:.9g} s in row "
            f"{place + 1}; sort the rows, or leave those of another run away"
        )
    keep = np.append(steps > 0, True)
    if not keep.all():
        notes.append(
            f"{int((~keep).sum())} rows repeat a stamp of {clock}: of such the last counts"
        )
    columns = {name: column[keep] for name, column in columns.items()}
    if len(columns["t"]) < LEAST_ROWS:
        raise ValueError(
            f"log[{clock!r}] has {len(columns['t'])} different stamps; must have at least "
            f"{LEAST_ROWS}"
        )
    steps = np.diff(columns["t"])
    typical = float(np.median(steps))
    if np.abs(steps - typical).max() > 0.02 * typical:
        notes.append(
            f"stamps of {clock} are uneven: steps of {steps.min():.3g} to {steps.max():.3g} s "
            f"about {typical:.3g} s"
        )
    return columns


def _reckon(
    columns: dict[str, Array],
    signs: str,
    robot: Robot | None,
    per_turn: float | None,
    counter_range: float | None,
    notes: list[str],
) -> None:
    """Add the poses that the wheels' counters tell."""
    if robot is None:
        raise ValueError("robot is None; counts become poses by its wheel_radius and track_width")
    turned_by = _angles(columns, per_turn, counter_range, notes)
    angles = [turned_by[name] for name in (_COUNTS if signs == "rep103" else _COUNTS[::-1])]
    right_of_left = np.diff(angles[1]), np.diff(angles[0])
    distance = 0.5 * robot.wheel_radius * (right_of_left[0] + right_of_left[1])
    turned = robot.wheel_radius / robot.track_width * (right_of_left[0] - right_of_left[1])
    theta = np.concatenate([[0.0], np.cumsum(turned)])
    middle = theta[:-1] + 0.5 * turned
    chord = distance * np.sinc(0.5 * turned / np.pi)
    columns["theta"] = theta
    columns["x"] = np.concatenate([[0.0], np.cumsum(chord * np.cos(middle))])
    columns["y"] = np.concatenate([[0.0], np.cumsum(chord * np.sin(middle))])
    notes.append(
        "poses are reckoned from counts with the robot's wheel_radius "
        f"{robot.wheel_radius:g} m and track_width {robot.track_width:g} m"
    )


def _angles(
    columns: Mapping[str, Array],
    per_turn: float | None,
    counter_range: float | None,
    notes: list[str],
) -> dict[str, Array]:
    """Return the angles of the wheels [rad] without the counters' jumps."""
    if per_turn is None:
        raise ValueError("counts_per_turn is None; must be the counts of a wheel's turn")
    turn = real_number("counts_per_turn", per_turn, 1, 1e9)
    angles = {}
    for name in _COUNTS:
        counts = columns[name]
        if counter_range is not None:
            span = real_number("counter_range", counter_range, 2, 2.0**64)
            turns = np.abs(np.diff(counts)) > 0.5 * span
            if turns.any():
                notes.append(f"{name} goes round {int(turns.sum())} times at {span:g}")
            counts = np.unwrap(counts, period=span)
        steps = np.abs(np.diff(counts))
        usual = float(np.percentile(steps, 90))
        if steps.max() > max(100 * usual, 10 * turn):
            place = int(np.argmax(steps))
            raise ValueError(
                f"log[{name!r}] jumps by {shown(float(steps[place]))} counts in row {place + 1}; "
                "where the counter goes round, counter_range says at what (65536 of 16 bits)"
            )
        angles[name] = counts * (2 * np.pi / turn)
    return angles


def _rates(
    columns: dict[str, Array],
    per_turn: float | None,
    counter_range: float | None,
    notes: list[str],
) -> None:
    """Put the wheels' turning rates until the next row [rad/s] in the place of the counts."""
    for name, angle in _angles(columns, per_turn, counter_range, notes).items():
        columns[name] = np.append(np.diff(angle) / np.diff(columns["t"]), 0.0)


def held(motion: Motion, edges: Array, delay: float) -> Array:
    """Return the mean of the command over each cell between edges, delayed by `delay` [s].

    Commands are held until the next, the last for a sample time; beyond it is zero.
    """
    t = np.append(motion.command_t, motion.command_t[-1] + motion.dt)
    sums = np.zeros((len(t), 2))
    sums[1:] = np.cumsum(motion.command * np.diff(t)[:, None], axis=0)
    at = edges - delay
    integral = np.column_stack([np.interp(at, t, sums[:, i]) for i in (0, 1)])
    mean: Array = np.diff(integral, axis=0) / np.diff(at)[:, None]
    return mean
