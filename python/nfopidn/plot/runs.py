"""Figures of one simulated run: its path, and its quantities against time."""

from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from nfopidn._core import SimulationResult
from nfopidn.plot import style
from nfopidn.plot.style import Panels

Numbers = NDArray[np.float64]

_HEADING_ARROWS = 24


def divergence_text(result: SimulationResult) -> str:
    """Return when the run diverged [s] in words, or nothing."""
    return "" if result.diverged_at is None else f"diverged at t = {result.diverged_at:.4g} s"


def _reference(result: SimulationResult) -> tuple[Numbers, Numbers]:
    """Return times [s] and rows of Scenario.reference, somewhat beyond a run that ended early.

    With all of them the run would be a sliver of its figure.
    """
    t = np.asarray(result.scenario.trajectory.t, dtype=np.float64)
    table = np.asarray(result.scenario.reference, dtype=np.float64)
    if result.diverged_at is None or len(result.columns["t"]) == 0:
        return t, table
    count = int(np.searchsorted(t, 1.3 * result.diverged_at, side="right"))
    return t[:count], table[:count]


def _wheel_pair(ax: Axes, t: Numbers, left: Numbers, right: Numbers, *, held: bool = True) -> None:
    """Draw a line for each wheel; `held` is what a torque is from a sample to the next."""
    drawstyle: Literal["steps-post", "default"] = "steps-post" if held else "default"
    ax.plot(t, left, drawstyle=drawstyle, label="left", **style.LEFT)
    ax.plot(t, right, drawstyle=drawstyle, label="right", **style.RIGHT)


def _finish_time(ax: Axes, result: SimulationResult, ylabel: str, *, note: bool = True) -> None:
    """Label a figure against time, with a legend and the time of divergence, if any."""
    style.finish(ax, "time [s]", ylabel)
    style.legend_above(ax)
    if result.diverged_at is None:
        return
    end = float(_reference(result)[0][-1])
    ax.set_xlim(-0.04 * end, 1.04 * end)
    ax.axvline(float(result.diverged_at), **style.DIVERGENCE)
    if note:
        ax.annotate(
            divergence_text(result),
            xy=(float(result.diverged_at), 0.5),
            xycoords=("data", "axes fraction"),
            xytext=(4, 0),
            textcoords="offset points",
            rotation=90,
            ha="left",
            va="center",
            fontsize=style.TICK_SIZE,
            color=style.DIVERGENCE["color"],
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0},
            zorder=6,
        )


def _finish_panels(panels: Panels, result: SimulationResult, ylabels: Sequence[str]) -> Panels:
    for i, (ax, ylabel) in enumerate(zip(panels, ylabels, strict=True)):
        _finish_time(ax, result, ylabel, note=i == 0)
        if ax is not panels[-1] and ax.get_shared_x_axes().joined(ax, panels[-1]):
            ax.set_xlabel("")
    panels[0].figure.align_ylabels(list(panels))
    return panels


def _start_pose(result: SimulationResult) -> tuple[float, float, float]:
    """Return where the run started, x, y [m], theta [rad], even if it has no row."""
    if len(result.columns["t"]) > 0:
        first = result.pose[0]
    elif result.scenario.initial_pose is not None:
        first = result.scenario.initial_pose
    else:
        first = result.scenario.reference[0]
    return float(first[0]), float(first[1]), float(first[2])


def _evenly_along(x: Numbers, y: Numbers, count: int) -> NDArray[np.intp]:
    """Return samples that are evenly apart along the path, not in time."""
    way = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(x), np.diff(y)))))
    return np.unique(np.searchsorted(way, np.linspace(0, way[-1], count + 1)[1:]))


def path(result: SimulationResult, ax: Axes | None = None) -> Axes:
    """Draw the reference's path and the robot's.

    Arrows along the robot's path show its heading, and an outline its start; the outline has the
    robot's size where that is neither too small to see nor too large for the figure.

    Parameters
    ----------
    result
        a run
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        x and y [m], equally scaled
    """
    ax = style.new_axes(ax, (5.4, 5.4))
    reference = result.scenario.reference
    x, y, theta = (np.asarray(result.columns[name]) for name in ("x", "y", "theta"))
    start = _start_pose(result)

    style.finish(ax, "x [m]", "y [m]")
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.07)
    lines = ax.plot(reference[:, 0], reference[:, 1], label="reference", **style.REFERENCE)
    lines += ax.plot(x, y, label="robot", **style.ROBOT)
    if len(x) > 0:
        at = _evenly_along(x, y, _HEADING_ARROWS)
        ax.quiver(
            x[at],
            y[at],
            np.cos(theta[at]),
            np.sin(theta[at]),
            angles="xy",
            scale=26,
            width=0.0032,
            headwidth=4.5,
            headlength=5,
            headaxislength=4.5,
            color=style.ROBOT["color"],
            zorder=3.5,
        )
    extent = float(np.ptp(np.concatenate((reference[:, :2], result.pose[:, :2])), axis=0).max())
    width = float(np.clip(result.scenario.robot.track_width, 0.05 * extent, 0.12 * extent))
    style.draw_robot(ax, start, width or result.scenario.robot.track_width)
    body = Line2D([], [], linestyle="none", marker="o", markersize=7, label="start")
    body.set(markerfacecolor="white", markeredgecolor=style.ROBOT["color"])
    style.legend_above(ax, handles=[*lines, body])
    ax.annotate(
        divergence_text(result),
        xy=(1, 1),
        xycoords="axes fraction",
        xytext=(0, 4),
        textcoords="offset points",
        ha="right",
        va="bottom",
        fontsize=style.TICK_SIZE,
        color=style.DIVERGENCE["color"],
    )
    return ax


def orientation(result: SimulationResult, ax: Axes | None = None) -> Axes:
    """Draw the reference's heading and the robot's against time.

    Both are continuous. The robot's is shifted by the whole turns that bring its start nearest to
    the reference's.

    Parameters
    ----------
    result
        a run
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        heading [rad] against time [s]
    """
    ax = style.new_axes(ax)
    t, reference = _reference(result)
    theta = np.asarray(result.columns["theta"], dtype=np.float64)
    if len(theta) > 0:
        turns = np.round((reference[0, 2] - theta[0]) / (2 * np.pi))
        theta = theta + 2 * np.pi * turns
    ax.plot(t, reference[:, 2], label="reference", **style.REFERENCE)
    ax.plot(result.columns["t"], theta, label="robot", **style.ROBOT)
    _finish_time(ax, result, "heading θ [rad]")
    return ax


def feedforward_torque(result: SimulationResult, ax: Axes | None = None) -> Axes:
    """Draw the reference torques of both wheels against time (eqs. 9, 10).

    Parameters
    ----------
    result
        a run
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        torque [N m] against time [s]
    """
    ax = style.new_axes(ax)
    t, reference = _reference(result)
    _wheel_pair(ax, t, reference[:, 5], reference[:, 6])
    _finish_time(ax, result, "feedforward torque [N m]")
    return ax


def feedback_torque(result: SimulationResult, ax: Axes | None = None) -> Axes:
    """Draw the controller's part of both wheels' torque against time, before the limit.

    Parameters
    ----------
    result
        a run
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        torque [N m] against time [s]
    """
    ax = style.new_axes(ax)
    columns = result.columns
    _wheel_pair(ax, columns["t"], columns["tau_fb_left"], columns["tau_fb_right"])
    _finish_time(ax, result, "feedback torque [N m]")
    return ax


def total_torque(result: SimulationResult, ax: Axes | None = None) -> Axes:
    """Draw the torque that both wheels get against time, and its limit.

    Parameters
    ----------
    result
        a run
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        torque [N m] against time [s]
    """
    ax = style.new_axes(ax)
    columns, limit = result.columns, float(result.scenario.torque_limit)
    _wheel_pair(ax, columns["t"], columns["tau_left"], columns["tau_right"])
    ax.axhline(limit, label=f"limit {limit:.4g} N m", **style.LIMIT)
    ax.axhline(-limit, **style.LIMIT)
    _finish_time(ax, result, "torque [N m]")
    return ax


def wheel_speeds(result: SimulationResult) -> tuple[Numbers, Numbers]:
    """Return the wheels' speeds [rad/s], left and right: (v ± L omega/2)/r, plus for the left."""
    robot, columns = result.scenario.robot, result.columns
    turn = 0.5 * robot.track_width * columns["omega"]
    return (columns["v"] + turn) / robot.wheel_radius, (columns["v"] - turn) / robot.wheel_radius


def wheel_action(result: SimulationResult, axes: Sequence[Axes] | Panels | None = None) -> Panels:
    """Draw torque, speed and power of each wheel against time.

    A wheel's speed is (v ± L omega/2)/r, plus for the left one, as the paper's sign has it.

    Parameters
    ----------
    result
        a run
    axes
        three Axes where to draw; None makes a figure

    Returns
    -------
    numpy.ndarray
        three Axes: torque [N m], speed [rad/s], power [W], against time [s]
    """
    panels = style.new_panels(axes, 3)
    columns = result.columns
    t = columns["t"]
    left, right = wheel_speeds(result)
    _wheel_pair(panels[0], t, columns["tau_left"], columns["tau_right"])
    _wheel_pair(panels[1], t, left, right, held=False)
    _wheel_pair(panels[2], t, columns["tau_left"] * left, columns["tau_right"] * right)
    return _finish_panels(panels, result, ("torque [N m]", "wheel speed [rad/s]", "power [W]"))


def velocities(result: SimulationResult, axes: Sequence[Axes] | Panels | None = None) -> Panels:
    """Draw linear and angular speed of reference and robot against time.

    Parameters
    ----------
    result
        a run
    axes
        two Axes where to draw; None makes a figure

    Returns
    -------
    numpy.ndarray
        two Axes: v [m/s] and omega [rad/s] against time [s]
    """
    panels = style.new_panels(axes, 2)
    t, reference = _reference(result)
    for ax, column, name in zip(panels, (3, 4), ("v", "omega"), strict=True):
        ax.plot(t, reference[:, column], label="reference", **style.REFERENCE)
        ax.plot(result.columns["t"], result.columns[name], label="robot", **style.ROBOT)
    return _finish_panels(panels, result, ("speed v [m/s]", "turn rate ω [rad/s]"))


def errors(result: SimulationResult, axes: Sequence[Axes] | Panels | None = None) -> Panels:
    """Draw the errors in the robot's frame, reference minus robot, against time.

    Parameters
    ----------
    result
        a run
    axes
        two Axes where to draw; None makes a figure

    Returns
    -------
    numpy.ndarray
        two Axes: e_x and e_y [m], and e_theta [rad], against time [s]
    """
    panels = style.new_panels(axes, 2)
    columns = result.columns
    strokes = {"x": style.ERROR_X, "y": style.ERROR_Y, "theta": style.ERROR_THETA}
    for ax, name in zip(panels[[0, 0, 1]], strokes, strict=True):
        symbol = r"$e_\theta$" if name == "theta" else f"$e_{name}$"
        ax.plot(columns["t"], columns[f"e_{name}"], label=symbol, **strokes[name])
    return _finish_panels(panels, result, ("position error [m]", "heading error [rad]"))
