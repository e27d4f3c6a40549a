"""Figures of a run: its path, and torques, velocities and errors against time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import SimulationResult
from nfopidn.reporting.numbers import Short, short
from nfopidn.reporting.strokes import (
    ERROR_THETA,
    ERROR_X,
    ERROR_Y,
    LIMIT,
    OTHER,
    REFERENCE,
    ROBOT,
    Figure,
    area,
    axis,
    figure,
    line,
    markers,
    stacked,
)

Array = NDArray[np.float64]

#: Rows of the run tables that all scenarios of a page share, and the least of each.
_MOST_ROWS = 3500
_FEWEST_ROWS = 300
_OUTLINES = 14  # of the robot along its path
_CIRCLE = 24  # points of an outline
_SMALLEST_ROBOT, _LARGEST_ROBOT = 0.065, 0.12  # its width as part of the path's extent

_TIME_DIGITS = 9
_TORQUES = ("tau_ref", "tau_fb", "tau")
#: With all torques below this part of the limit, the limit lies beyond the figure's scale.
_LEAST_OF_LIMIT = 0.3
_LABELS = {"left": "left wheel torque [N m]", "right": "right wheel torque [N m]"}
_RUN_COLUMNS = (
    *("t", "x_ref", "y_ref", "theta_ref", "x", "y", "theta", "v", "omega"),
    *("e_x", "e_y", "e_theta", "tau_ref_left", "tau_ref_right"),
    *("tau_fb_left", "tau_fb_right", "tau_left", "tau_right"),
)


def row_step(rows: int, scenarios: int) -> int:
    """Return which rows of a run a page shows: each, every second, ..."""
    most = max(_MOST_ROWS // scenarios, _FEWEST_ROWS)
    return max(1, -(-rows // most))


def _shown(rows: int, step: int) -> NDArray[np.intp]:
    """Return the rows that are shown, the last one among them."""
    places = np.arange(0, rows, step)
    return places if rows == 0 or places[-1] == rows - 1 else np.append(places, rows - 1)


def columns(run: SimulationResult, step: int) -> dict[str, Short]:
    """Return what the figures and the slider show of a run, and the whole reference's path."""
    reference = np.asarray(run.scenario.reference)
    rows = _shown(len(run), step)
    table = {name: run.columns[name][rows] for name in _RUN_COLUMNS}
    table |= {"v_ref": reference[rows, 3], "omega_ref": reference[rows, 4]}
    path = reference[_shown(len(reference), step)]
    table |= {"path_x": path[:, 0], "path_y": path[:, 1]}
    return {
        name: short(values, _TIME_DIGITS if name == "t" else 6) for name, values in table.items()
    }


def _points(run: SimulationResult) -> Array:
    return np.concatenate((np.asarray(run.scenario.reference)[:, :2], run.pose[:, :2]))


def robot_scale(run: SimulationResult) -> float:
    """Return by how much the robot must be drawn larger, or smaller, to be seen well."""
    extent = float(np.ptp(_points(run), axis=0).max())
    width = run.scenario.robot.track_width
    if extent == 0:
        return 1.0
    return float(np.clip(width, _SMALLEST_ROBOT * extent, _LARGEST_ROBOT * extent)) / width


def _outlines(run: SimulationResult, radius: float) -> tuple[Short, Short]:
    """Return the robot's outline with its heading at places evenly apart along its path."""
    pose = run.pose
    way = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(pose[:, :2], axis=0).T))))
    places = np.searchsorted(way, np.linspace(0, way[-1], _OUTLINES, endpoint=False))
    turn = np.linspace(0, 2 * np.pi, _CIRCLE + 1)
    x: list[float] = []
    y: list[float] = []
    for px, py, theta in pose[np.unique(places)]:
        # From the centre to the front, then once round.
        x += [px, *(px + radius * np.cos(theta + turn)), np.nan]
        y += [py, *(py + radius * np.sin(theta + turn)), np.nan]
    return short(x, 5), short(y, 5)


def path(run: SimulationResult, radius: float) -> Figure:
    """Draw the reference's and the robot's path; the page adds the robot at the slider's time."""
    outlines = _outlines(run, radius) if len(run) > 1 else ([], [])
    points = _points(run)
    low, high = points.min(axis=0) - 2 * radius, points.max(axis=0) + 2 * radius
    ranges = [short(pair) for pair in zip(low, high, strict=True)]
    unnamed = {"legend": False, "moves": True}
    traces = [
        line("@path_x", "@path_y", "reference", REFERENCE),
        line(*outlines, "robot along the way", {"colour": "outline", "width": 1}, legend=False),
        line("@x", "@y", "robot", ROBOT, hover=_PATH_HOVER),
        markers([], [], _AT_TIME, "mark", fill="mark", symbol="diamond", size=10, moves=True),
        area([], [], "body", "body", **unnamed),
        area([], [], "wheels", "robot", **unnamed),
    ]
    across, up = axis("x [m]", range=ranges[0]), axis("y [m]", range=ranges[1])
    return figure(traces, 560, across, up, equal=True)


_AT_TIME = "reference at the slider's time"
#: Label, column and unit of what is shown at a point of the path.
_PATH_HOVER = [["t", "t", "s"], ["x", "x", "m"], ["y", "y", "m"]]


def _end(run: SimulationResult) -> float:
    """Return where the time axes end, somewhat beyond a run that ended early."""
    last = float(run.scenario.trajectory.t[-1])
    return last if run.diverged_at is None else min(last, 1.1 * run.diverged_at)


def torques(run: SimulationResult) -> Figure:
    """Draw each wheel's feedforward, feedback and limited total, and the limit."""
    limit, end = float(run.scenario.torque_limit), _end(run)
    columns = [f"{name}_{side}" for name in _TORQUES for side in ("left", "right")]
    peak = max(float(np.abs(run.columns[name]).max(initial=0)) for name in columns)
    beyond = 0 < peak < _LEAST_OF_LIMIT * limit
    limit_name = f"limit ±{limit:g} N m" + (", beyond the scale" if beyond else "")
    traces = []
    for i, side in enumerate(("left", "right")):
        for column, name, stroke in (
            (f"@tau_ref_{side}", "feedforward", REFERENCE),
            (f"@tau_fb_{side}", "feedback", OTHER),
            (f"@tau_{side}", "total, limited", ROBOT),
        ):
            traces.append(line("@t", column, name, stroke, panel=i, steps=True))
        ends = short([limit, limit, np.nan, -limit, -limit], 12)
        across = short([0, end, np.nan, 0, end], _TIME_DIGITS)
        traces.append(line(across, ends, limit_name, LIMIT, panel=i))
    found = stacked(traces, (_LABELS["left"], _LABELS["right"]), end)
    if beyond:
        for panel in found["panels"]:
            panel["range"] = short([-1.1 * peak, 1.1 * peak])
    return found


def velocities(run: SimulationResult) -> Figure:
    """Draw speed and turn rate of reference and robot."""
    traces = []
    for i, name in enumerate(("v", "omega")):
        traces += [
            line("@t", f"@{name}_ref", "reference", REFERENCE, panel=i),
            line("@t", f"@{name}", "robot", ROBOT, panel=i),
        ]
    return stacked(traces, ("speed v [m/s]", "turn rate ω [rad/s]"), _end(run))


def errors(run: SimulationResult) -> Figure:
    """Draw the pose errors in the robot's frame."""
    traces = [
        line("@t", "@e_x", "forward", ERROR_X),
        line("@t", "@e_y", "lateral", ERROR_Y),
        line("@t", "@e_theta", "heading", ERROR_THETA, panel=1),
    ]
    return stacked(traces, ("position error [m]", "heading error [rad]"), _end(run))
