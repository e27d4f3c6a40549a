"""The paper's Table 2, Table 3, Fig. 3 and Figs. 5 to 11."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Text

from nfopidn import plot
from nfopidn._core import Controller, SimulationResult
from nfopidn.fractional import to_continuous
from nfopidn.plot import style
from nfopidn.study.cases import RUN_DIGITS, RUN_UNITS, TITLES, Cases
from nfopidn.study.files import Folder

_CHANNELS = ("x", "y", "theta")

#: Number of the paper's figure, our function, rows of panels, height [inch], what it shows.
_FIGURES: tuple[tuple[int, str, int, float, str], ...] = (
    (5, "path", 1, 4.4, "path"),
    (6, "orientation", 1, 3.0, "heading"),
    (8, "feedback_torque", 1, 3.0, "feedback torques"),
    (9, "total_torque", 1, 3.0, "total torques"),
    (10, "wheel_action", 3, 5.8, "torque, speed and power of the wheels"),
    (11, "velocities", 2, 4.4, "speed and turn rate"),
)


def gain_tables(cases: Cases, folder: Folder) -> None:
    """Write Table 3, the published discrete gains, and Table 2, continuous, from it by eq. 25."""
    controller = Controller.published()
    assert controller.gains is not None
    orders = {"alpha": controller.alpha, "sigma": controller.sigma}
    alpha, sigma = (float(np.mean(np.asarray(value))) for value in orders.values())
    continuous = to_continuous(controller.gains, alpha, sigma, cases.scenario.trajectory.dt)
    for name, title, gains, symbol in (
        ("table2_continuous_gains", "computed from Table 3 by eq. 25", continuous, "K"),
        ("table3_discrete_gains", "as printed, eq. 34", controller.gains, "k"),
    ):
        columns: dict[str, Any] = {"channel": _CHANNELS}
        columns |= {f"{symbol}{letter}": gains[:, i] for i, letter in enumerate("pid")}
        columns |= {"alpha": [alpha] * 3, "sigma": [sigma] * 3}
        folder.table(name, f"Table {name[5]}: gains and orders, {title}", columns, {})
    cases.report("gains")


def z_plane(cases: Cases, folder: Folder) -> None:
    """Draw Fig. 3: zeros and poles of the truncated operators of the published controller."""
    controller = Controller.published()
    alpha, sigma = (
        float(np.mean(np.asarray(value))) for value in (controller.alpha, controller.sigma)
    )
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    for ax, order in zip(figure.subplots(1, 2), (alpha, 1 - sigma), strict=True):
        plot.operator_z_plane(order, int(controller.memory), ax=ax)
    title = "Fig. 3: zeros and poles of the truncated operators of orders alpha and 1 - sigma"
    folder.figure("fig03_z_plane", title, figure)
    cases.report("z-plane")


def _head(ax: Axes, text: str) -> Text:
    """Write what a column of panels shows, above its legend."""
    return ax.set_title(text, loc="left", pad=18, fontsize=style.LABEL_SIZE, fontweight="bold")


def _beside(
    runs: dict[str, SimulationResult], draw: Callable[..., Any], rows: int, height: float
) -> Figure:
    """Draw the runs side by side, a column each, on shared axes."""
    figure = Figure(figsize=(9.6, height), layout="constrained")
    shared: Any = {} if draw is plot.path else {"sharex": True, "sharey": "row"}
    grid = figure.subplots(rows, len(runs), squeeze=False, **shared)
    for column, (name, run) in zip(grid.T, runs.items(), strict=True):
        if rows > 1:
            draw(run, axes=column)
        else:
            draw(run, ax=column[0])
        _head(column[0], f"{TITLES[name]}, E = {run.cost:.6f}")
    for ax in grid[:, 1:].flat:
        ax.set_ylabel("")
    return figure


def run_figures(cases: Cases, folder: Folder) -> None:
    """Draw Figs. 5 to 11 of both runs, and write the runs."""
    runs = cases.runs
    for number, name, rows, height, what in _FIGURES:
        figure = _beside(runs, getattr(plot, name), rows, height)
        folder.figure(f"fig{number:02}_{name}", f"Fig. {number}: {what}", figure)
        if name == "orientation":
            only = Figure(figsize=(9.6, 3.0), layout="constrained")
            # Three samples a cusp, and between them a hundredth of that: panels of their own.
            whole, arcs, cusp = only.subplots(1, 3)
            for ax in (whole, arcs, cusp):
                plot.feedforward_torque(runs["published"], ax=ax)
            arcs.set_ylim(-0.03, 0.03)
            cusp.set_xlim(48.5, 51.5)
            for ax in (arcs, cusp):
                ax.set_ylabel("")
            title = "Fig. 7: feedforward torques, the same for all gains"
            folder.figure("fig07_feedforward_torque", title, only)
    for name, run in runs.items():
        title = f"Run with the {TITLES[name]}".replace("the tuned", "the gains tuned")
        folder.table(f"run_{name}", title, run.columns, RUN_UNITS, RUN_DIGITS)
    cases.report("runs")
