"""Figures of identification: measured against simulated motion, and what is left."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from nfopidn.plot import style

_INK: Final = {False: ("white", "0.15", "0.9"), True: ("#14181f", "0.85", "0.28")}
_MEASURED: Final = {False: "#a3a3a3", True: "#6f7785"}
_SIMULATED: Final = {False: "#16365c", True: "#8ec1ff"}
_SEEN: Final = {False: "#e98a2b", True: "#ffb366"}
_CHANNELS: Final = (
    ("x", "x [m]", "#4b2a83", "#b79bff"),
    ("y", "y [m]", "#2a8a62", "#6fe0b4"),
    ("theta", "heading [rad]", "#a3305f", "#ff8fbf"),
)


def identification(
    result: Any, axes: Sequence[Axes] | None = None, dark: bool = False
) -> style.Panels:
    """Draw measured and simulated poses, the residuals over the noise, and their correlations.

    Parameters
    ----------
    result
        of identify().
    axes
        five: x, y, heading, residuals, correlations. None: a new figure's.
    dark
        light strokes on dark ground.

    Returns
    -------
    (5,) Axes
    """
    if axes is None:
        figure = plt.figure(figsize=(7.2, 8.2), layout="constrained", facecolor=_INK[dark][0])
        panels = np.asarray(figure.subplots(5, 1), dtype=np.object_).ravel()
        for panel in panels[1:4]:
            panel.sharex(panels[0])
    else:
        panels = style.new_panels(axes, 5)
    t = np.asarray(result.t)
    for i, (_, label, *_rest) in enumerate(_CHANNELS):
        ax = panels[i]
        ax.plot(
            t, result.measured[:, i], ".", markersize=2.4, color=_MEASURED[dark], label="measured"
        )
        for k, number in enumerate(np.unique(result.window)):
            rows = result.window == number
            seen = bool(result.validation[rows][0])
            ax.plot(
                t[rows],
                result.simulated[rows, i],
                color=_SEEN[dark] if seen else _SIMULATED[dark],
                linewidth=1.3,
                linestyle=(0, (4, 1.6)) if seen else "-",
                label=None if k else "simulated",
            )
        _finish(ax, "time [s]" if i == 2 else "", label, dark)
    panels[0].plot(
        [], [], color=_SEEN[dark], linestyle=(0, (4, 1.6)), label="in validation windows"
    )
    style.legend_above(panels[0], labelcolor=_INK[dark][1])
    _residuals(panels[3], result, dark)
    _correlations(panels[4], result, dark)
    return panels


def _finish(ax: Axes, xlabel: str, ylabel: str, dark: bool) -> None:
    """Label the axes, on light or dark ground."""
    style.finish(ax, xlabel, ylabel)
    ground, ink, grid = _INK[dark]
    ax.set_facecolor(ground)
    ax.grid(True, color=grid, linewidth=0.5)
    ax.tick_params(colors=ink)
    for label in (ax.xaxis.label, ax.yaxis.label):
        label.set_color(ink)
    for spine in ax.spines.values():
        spine.set_color(ink)


def _residuals(ax: Axes, result: Any, dark: bool) -> None:
    deviation = np.array([result.noise[0], result.noise[0], result.noise[1]])
    rows = (result.measured - result.simulated) / deviation
    for i, (name, _, light, bright) in enumerate(_CHANNELS):
        colour = bright if dark else light
        ax.plot(result.t, rows[:, i], ".", markersize=1.8, color=colour, label=name)
    for limit in (-2, 2):
        ax.axhline(limit, **{**style.LIMIT, "color": _INK[dark][1]})
    ax.set_ylim(-6.5, 6.5)
    _finish(ax, "time [s]", "residual / noise", dark)
    style.legend_above(ax, labelcolor=_INK[dark][1], markerscale=3)


def _correlations(ax: Axes, result: Any, dark: bool) -> None:
    for i, (name, _, light, bright) in enumerate(_CHANNELS):
        test = result.whiteness[name]
        lags = np.arange(1, len(test.correlations) + 1) + 0.2 * (i - 1)
        ax.vlines(lags, 0, test.correlations, color=bright if dark else light, linewidth=1.6)
    bound = result.whiteness["x"].bound
    for limit in (-bound, bound):
        ax.axhline(limit, **{**style.LIMIT, "color": _INK[dark][1]})
    ax.axhline(0, color=_INK[dark][1], linewidth=0.6)
    _finish(ax, "lag [rows]", "correlation", dark)
