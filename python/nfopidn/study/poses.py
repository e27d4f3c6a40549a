"""Other initial poses: the way to the path, and how long it takes."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from nfopidn._core import SimulationResult, simulate
from nfopidn.comparison.comparison import SETTLED_WITHIN, settling_time
from nfopidn.plot import style
from nfopidn.study.cases import TITLES, Cases, distance
from nfopidn.study.files import Cell, Folder

_POSES = 16
_AWAY = 0.5  # [m] from the reference's start
_SHOWN = 30.0  # [s] of each path
_PAPER = "paper"
_PAPER_COLOUR = style.RIGHT["color"]
_ABOVE = 1.06  # of the figure's last time, where those are marked that never settle

_POINT: style.Stroke = {"linestyle": "none", "zorder": 3.0}
_OUTCOMES: dict[str, style.Stroke] = {
    "settles": {**_POINT, "marker": "o", "color": style.ROBOT["color"]},
    "never settles": {
        **_POINT,
        "marker": "^",
        "color": style.ROBOT["color"],
        "markerfacecolor": "white",
    },
    "diverges": {**_POINT, "marker": "x", "color": style.DIVERGENCE["color"]},
}

Pose = tuple[float, float, float]


def initial_poses(cases: Cases) -> dict[str, Pose]:
    """Return poses around the reference's start, heading as it does, and the paper's own.

    Their names are the direction from the start in degrees, and `paper`.
    """
    x, y, theta = cases.scenario.reference[0, :3].tolist()
    poses: dict[str, Pose] = {}
    for k in range(_POSES):
        angle = 2 * np.pi * k / _POSES
        name = f"{np.degrees(angle):g}"
        poses[name] = (float(x + _AWAY * np.cos(angle)), float(y + _AWAY * np.sin(angle)), theta)
    paper = cases.scenario.initial_pose
    assert paper is not None
    return {**poses, _PAPER: paper}


def settled_at(run: SimulationResult) -> float | None:
    """Return the settling time [s]; None if the run never settles."""
    time = settling_time(run)
    return time if np.isfinite(time) else None


def _outcome(run: SimulationResult) -> str:
    if run.diverged_at is not None:
        return "diverges"
    return "never settles" if settled_at(run) is None else "settles"


def _row(gains: str, name: str, run: SimulationResult) -> dict[str, Cell]:
    pose = run.scenario.initial_pose
    assert pose is not None
    away = distance(run)
    return {
        "gains": gains,
        "direction": name,
        "x": pose[0],
        "y": pose[1],
        "theta": pose[2],
        "cost": run.cost,
        "outcome": _outcome(run),
        "settled_at": settled_at(run),
        "share_of_samples_beyond": float(np.mean(away > SETTLED_WITHIN)),
        "largest_error": run.metrics["position_max"],
        "diverged_at": run.diverged_at,
    }


def _colour(k: int) -> tuple[float, float, float, float]:
    """Return the colour of a direction, of a luminance of its own."""
    return mpl.colormaps["viridis"](0.88 * k / (_POSES - 1))


def _draw_paths(ax: Axes, runs: dict[str, SimulationResult]) -> None:
    """Draw the first seconds of each run, coloured by its direction, and its start."""
    reference = next(iter(runs.values())).scenario.reference
    shown = round(_SHOWN / next(iter(runs.values())).scenario.trajectory.dt)
    line: dict[str, Any] = {**style.REFERENCE, "label": "reference"}
    ax.plot(*reference[:shown, :2].T, **line)
    for k, (name, run) in enumerate(runs.items()):
        x, y = run.pose[:shown:2, :2].T
        stroke: dict[str, Any] = {"linewidth": 0.9, "color": _colour(k)}
        if name == _PAPER:
            stroke = {**style.RIGHT, "linewidth": 1.6, "label": "the paper's start"}
        ax.plot(x, y, **{"zorder": 3.0, **stroke})
        ax.plot(x[:1], y[:1], "o", markersize=3, color=stroke["color"], zorder=4.0)
    style.finish(ax, "x [m]", "y [m]")
    ax.set_aspect("equal", adjustable="datalim")
    style.legend_above(ax)


def _draw_shares(ax: Axes, rows: list[dict[str, Cell]], end: float) -> None:
    """Draw how long each run is beyond, and when it settles, if it does."""
    places = np.arange(len(rows))
    shares = [float(row["share_of_samples_beyond"] or 0) * end for row in rows]
    colours = [
        _colour(k) if row["direction"] != _PAPER else _PAPER_COLOUR for k, row in enumerate(rows)
    ]
    ax.bar(
        places,
        shares,
        color=colours,
        alpha=0.6,
        width=0.7,
        label=f"time beyond {SETTLED_WITHIN:g} m",
    )
    for outcome, stroke in _OUTCOMES.items():
        at = [k for k, row in enumerate(rows) if row["outcome"] == outcome]
        times: Any = [
            _ABOVE * end if rows[k]["settled_at"] is None else rows[k]["settled_at"] for k in at
        ]
        if at:
            ax.plot(at, times, label=outcome, **stroke)
    style.finish(ax, "direction of the start from the path's [degree]", "time [s]")
    ax.set_xticks(places, [str(row["direction"]) for row in rows], rotation=60)
    ax.set_ylim(0, 1.12 * end)
    style.legend_above(ax)


def pose_study(cases: Cases, folder: Folder) -> None:
    """Draw and write the runs from other initial poses, with published and with tuned gains."""
    poses = initial_poses(cases)
    figure = Figure(figsize=(9.6, 7.4), layout="constrained")
    grid = figure.subplots(2, 2, height_ratios=(1.5, 1))
    rows: list[dict[str, Cell]] = []
    for column, (gains, controller) in zip(grid.T, cases.controllers.items(), strict=True):
        runs = {
            name: simulate(cases.scenario.replace(initial_pose=pose), controller)
            for name, pose in poses.items()
        }
        own = [_row(gains, name, run) for name, run in runs.items()]
        _draw_paths(column[0], runs)
        title = f"{TITLES[gains]}, first {_SHOWN:g} s"
        column[0].set_title(title, loc="left", pad=18, fontsize=style.LABEL_SIZE, fontweight="bold")
        _draw_shares(column[1], own, float(cases.scenario.trajectory.t[-1]))
        rows += own
    title = f"Runs from {_POSES} poses {_AWAY:g} m from the path's start, and from the paper's"
    folder.figure("poses", title, figure)
    units = {"direction": "degree", **dict.fromkeys(("x", "y", "largest_error"), "m")}
    units |= {"theta": "rad", "settled_at": "s", "diverged_at": "s"}
    folder.table("poses", title, {key: [row[key] for row in rows] for key in rows[0]}, units)
    cases.report("initial poses")
