"""Figures of Pareto fronts."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from nfopidn._core import metric_fields
from nfopidn.plot import style

if TYPE_CHECKING:
    from nfopidn.tuning.pareto_result import ParetoResult

# Colours that stand out from a white and from a black ground alike.
_POINT = {"color": "#3b82c4", "s": 16, "linewidths": 0, "zorder": 3.0}
_STEPS = {"color": "#3b82c4", "linewidth": 0.9, "alpha": 0.55, "zorder": 2.0}
_KNEE = {"color": "#e98a2b", "s": 70, "marker": "D", "linewidths": 0, "zorder": 4.0}
_CHOSEN = {"color": "#c2417c", "s": 90, "marker": "*", "linewidths": 0, "zorder": 4.1}
_COLUMNS = 3


def pareto_front(
    result: ParetoResult,
    ax: Axes | Sequence[Axes] | style.Panels | None = None,
    chosen: int | None = None,
) -> Axes | style.Panels:
    """Draw a Pareto front with its knee; of more than two objectives each pair of them.

    Parameters
    ----------
    result
        what tune(objectives=...) has returned
    ax
        where; None: a new figure. Of m > 2 objectives there are m (m - 1) / 2 Axes, in the order
        of itertools.combinations
    chosen
        place of a point to mark, as result.choose() gives it

    Returns
    -------
    Axes
        of more than two objectives an array of them

    Raises
    ------
    ValueError
        An empty front, another number of Axes, or no such place.
    """
    if len(result) == 0:
        raise ValueError("the front is empty; there is nothing to draw")
    if chosen is not None and not 0 <= chosen < len(result):
        raise ValueError(f"chosen is {chosen}; must be in [0, {len(result) - 1}]")
    names = result["objective_names"]
    pairs = list(combinations(range(len(names)), 2))
    panels = _panels(ax, len(pairs))
    marks = [(result.choose(), "knee", _KNEE)]
    if chosen is not None:
        marks.append((chosen, f"point {chosen}", _CHOSEN))
    for panel, (first, second) in zip(panels, pairs, strict=True):
        rows = result["objectives"][:, [first, second]]
        if len(names) == 2:
            panel.step(rows[:, 0], rows[:, 1], where="post", **_STEPS)
        panel.scatter(rows[:, 0], rows[:, 1], label=f"front, {len(rows)} points", **_POINT)
        for place, text, mark in marks:
            panel.scatter(*rows[place], label=text, **mark)
        _finish(panel, _label(names[first]), _label(names[second]))
    style.legend_above(panels[0])
    return panels if len(pairs) > 1 else panels[0]


def _panels(ax: Any, count: int) -> style.Panels:
    if ax is None:
        if count == 1:
            return np.array([style.new_axes(None)], dtype=np.object_)
        columns = min(count, _COLUMNS)
        rows = -(-count // columns)
        size = (3.1 * columns, 0.4 + 2.6 * rows)
        figure = plt.figure(figsize=size, layout="constrained")
        panels = np.atleast_1d(figure.subplots(rows, columns)).ravel()
        for spare in panels[count:]:
            spare.set_axis_off()
        return np.asarray(panels[:count], dtype=np.object_)
    given = np.asarray([ax] if isinstance(ax, Axes) else ax, dtype=np.object_).ravel()
    if given.size != count:
        raise ValueError(f"ax has {given.size} Axes; must have {count}")
    return given


def _finish(ax: Axes, xlabel: str, ylabel: str) -> None:
    style.finish(ax, xlabel, ylabel)
    ax.grid(True, color="0.5", alpha=0.25, linewidth=0.5)  # as thin on a black ground


def _label(name: str) -> str:
    unit, _ = metric_fields().get(name, ("", ""))
    words = {"cost": "cost E", "worst": "worst scenario's cost E"}.get(name, name.replace("_", " "))
    return f"{words} [{unit}]" if unit else words


def hypervolume(result: ParetoResult, ax: Axes | None = None) -> Axes:
    """Draw how a Pareto front grew: the share of the objectives' box that it dominates.

    Parameters
    ----------
    result
        what tune(objectives=...) has returned
    ax
        where; None: a new figure
    """
    ax = style.new_axes(ax)
    history = result["history"]
    ax.plot(history["nfev"], history["hypervolume"], color=_POINT["color"], linewidth=1.3)
    _finish(ax, "evaluations", "hypervolume, share of the box")
    return ax
