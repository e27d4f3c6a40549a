"""Figures of comparisons."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes

from nfopidn._core import SimulationResult
from nfopidn.plot import style

if TYPE_CHECKING:
    from nfopidn.comparison import Comparison

#: Colours that differ in luminance, and dashes, so that a print in grey is readable.
_COLOURS = ("#16365c", "#e98a2b", "#3fae82", "#a3305f", "#4b2a83", "#7aa6d6", "#6b6b6b", "#c9b037")
_DASHES: tuple[Any, ...] = ("-", (0, (4, 1.6)), (0, (1.5, 1.5)), (0, (6, 2, 1, 2)))


def stroke(place: int) -> dict[str, Any]:
    """Give the colour and dash of the controller at a place."""
    return {
        "color": _COLOURS[place % len(_COLOURS)],
        "linestyle": _DASHES[(place // 2 + place // len(_COLOURS)) % len(_DASHES)],
        "linewidth": 1.2,
    }


def comparison(result: Comparison, metric: str = "cost", ax: Axes | None = None) -> Axes:
    """Draw the medians of a metric, a row a controller and a mark a scenario.

    The bars reach from the lower to the upper quartile of the runs. A pair of which half the runs
    or more diverge has no median: an open mark at the right edge says so.

    Parameters
    ----------
    result
        what compare() has returned
    metric
        one of its values
    ax
        where; None: a new figure

    Raises
    ------
    ValueError
        A metric that is not known.
    """
    count = len(result.controllers)
    ax = style.new_axes(ax, (6.4, 1.1 + 0.27 * count))
    medians = result.median(metric)
    values = result.values[metric]
    order = np.argsort(-np.nan_to_num(medians[:, 0], nan=np.inf))
    markers = "osD^vP*X"
    drawn: list[float] = []
    for j, scenario in enumerate(result.scenarios):
        with np.errstate(invalid="ignore"):  # between infinite costs, of pairs that are not shown
            low, middle, high = np.quantile(values[order, j], [0.25, 0.5, 0.75], axis=1)
        shown = np.isfinite(middle) & (result.values["diverged"][order, j].mean(axis=1) < 0.5)
        drawn += [*middle[shown]]
        y = np.arange(count) + 0.12 * (j - (len(result.scenarios) - 1) / 2)
        ax.errorbar(
            middle[shown],
            y[shown],
            xerr=[(middle - low)[shown], (high - middle)[shown]],
            marker=markers[j % len(markers)],
            markersize=4.5,
            linestyle="none",
            color=_COLOURS[j % len(_COLOURS)],
            elinewidth=0.9,
            label=scenario,
        )
        ax.plot(
            np.ones(np.count_nonzero(~shown)),
            y[~shown],
            marker=markers[j % len(markers)],
            markersize=4.5,
            linestyle="none",
            color=_COLOURS[j % len(_COLOURS)],
            fillstyle="none",
            clip_on=False,
            transform=ax.get_yaxis_transform(),
        )
    ax.set_yticks(np.arange(count), [result.controllers[i] for i in order])
    ax.set_xscale("log" if drawn and min(drawn) > 0 else "linear")
    unit = result.unit(metric)
    label = "cost E, eq. 41" if metric == "cost" else metric.replace("_", " ")
    style.finish(ax, f"{label} [{unit}]" if unit else label, "")
    style.legend_above(ax)
    return ax


def paths(runs: Mapping[str, SimulationResult], ax: Axes | None = None) -> Axes:
    """Draw the driven paths of several controllers on one scenario.

    Parameters
    ----------
    runs
        by name; of those that diverge the part until then
    ax
        where; None: a new figure
    """
    ax = style.new_axes(ax, (5.6, 5.2))
    first = next(iter(runs.values()))
    ax.plot(first.columns["x_ref"], first.columns["y_ref"], label="reference", **style.REFERENCE)
    for place, (name, run) in enumerate(runs.items()):
        ax.plot(run.columns["x"], run.columns["y"], label=name, zorder=3, **stroke(place))
    style.finish(ax, "x [m]", "y [m]")
    ax.set_aspect("equal")
    style.legend_above(ax, ncols=3)
    return ax


def distances(runs: Mapping[str, SimulationResult], ax: Axes | None = None) -> Axes:
    """Draw how far from the reference several controllers are on one scenario, against time.

    Parameters
    ----------
    runs
        by name; of those that diverge the part until then
    ax
        where; None: a new figure
    """
    ax = style.new_axes(ax, (6.4, 3.8))
    for place, (name, run) in enumerate(runs.items()):
        distance = np.hypot(run.columns["e_x"], run.columns["e_y"])
        ax.plot(run.columns["t"], distance, label=name, zorder=3, **stroke(place))
    ax.set_yscale("log")
    style.finish(ax, "time [s]", "distance from the reference [m]")
    style.legend_above(ax, ncols=3)
    return ax
