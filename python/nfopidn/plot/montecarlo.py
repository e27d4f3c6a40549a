"""Figures of many runs: how costs spread, what drives them, where failures lie, the way there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nfopidn.arguments import real_numbers, shown, whole_number
from nfopidn.plot import style

_FAILED = {**style.DIVERGENCE}


def cost_histogram(
    costs: Any, limit: float | None = None, ax: Axes | None = None, label: str = "cost E"
) -> Axes:
    """Draw how often each cost occurs, on a logarithmic axis, with the limit.

    Parameters
    ----------
    costs
        (n,): positive, of the runs, or another metric
    limit
        a line there, and the share of the runs beyond it in words
    ax
        where; None: a new figure
    label
        of the axis

    Raises
    ------
    ValueError
        No costs, or some that are not positive.
    """
    values = real_numbers("costs", costs)
    if values.ndim != 1 or values.size == 0 or not (values > 0).all():
        raise ValueError("costs must be a list of positive numbers, at least one")
    ax = style.new_axes(ax)
    low, high = float(values.min()), float(values.max())
    if limit is not None:
        low, high = min(low, limit), max(high, limit)
    edges = np.geomspace(low / 1.02, high * 1.02, 61)
    ax.hist(values, bins=edges.tolist(), color=style.ROBOT["color"], alpha=0.75)
    ax.set_xscale("log")
    if limit is not None:
        beyond = float((values > limit).mean())
        ax.axvline(limit, label=f"limit {limit:g}: {beyond:.2%} beyond", **_FAILED)
        style.legend_above(ax)
    style.finish(ax, label, "runs")
    return ax


def tornado(
    names: Sequence[str],
    correlations: Any,
    standard_error: float = 0.0,
    ax: Axes | None = None,
) -> Axes:
    """Draw a bar for each parameter, the strongest on top.

    Parameters
    ----------
    names, correlations
        of a Sensitivity: parameters and their rank correlations
    standard_error
        of a correlation that is 0; a band of twice as much is drawn
    ax
        where; None: a new figure

    Raises
    ------
    ValueError
        Not as many names as correlations.
    """
    values = real_numbers("correlations", correlations)
    if values.shape != (len(names),) or not names:
        raise ValueError(
            f"correlations has the shape {values.shape}; must have one for each of the "
            f"{len(names)} names"
        )
    ax = style.new_axes(ax, (6.4, 1.2 + 0.35 * len(names)))
    order = np.argsort(np.abs(np.nan_to_num(values)), kind="stable")
    rows = np.arange(len(names))
    ax.barh(rows, np.nan_to_num(values[order]), color=style.ROBOT["color"], height=0.6)
    ax.axvspan(-2 * standard_error, 2 * standard_error, color="0.85", zorder=0)
    ax.axvline(0, color="0.3", linewidth=0.8)
    ax.set_yticks(rows, [str(names[place]) for place in order])
    ax.set_xlim(-1, 1)
    style.finish(ax, "rank correlation", "")
    return ax


def failures(
    parameters: Mapping[str, Any],
    failed: Any,
    x: str | None = None,
    y: str | None = None,
    ax: Axes | None = None,
    most: int = 20000,
) -> Axes:
    """Draw each run as a dot over two of its parameters, those that fail on top.

    Parameters
    ----------
    parameters
        (n,) each, by name
    failed
        (n,): which runs fail, as ~result.within(limits)
    x, y
        names; None: the first two
    ax
        where; None: a new figure
    most
        dots: of more runs the first ones are drawn

    Raises
    ------
    ValueError
        Fewer than two parameters, or a name that is none.
    """
    known = list(parameters)
    if len(known) < 2:
        raise ValueError(f"parameters has {len(known)} names; must have at least 2")
    x = known[0] if x is None else x
    y = next(name for name in known if name != x) if y is None else y
    for axis, name in (("x", x), ("y", y)):
        if name not in parameters:
            raise ValueError(f"{axis} is {shown(name)}; known: {', '.join(known)}")
    whole_number("most", most, 1)
    lost = np.asarray(failed, dtype=bool)[:most]
    ax = style.new_axes(ax, (5.2, 4.2))
    horizontal, vertical = np.asarray(parameters[x])[:most], np.asarray(parameters[y])[:most]
    good = {"color": style.ROBOT["color"], "alpha": 0.35, "linewidths": 0}
    ax.scatter(horizontal[~lost], vertical[~lost], s=6, label=f"{(~lost).sum()} within", **good)
    bad = {"color": _FAILED["color"], "marker": "x", "linewidths": 1.0}
    ax.scatter(horizontal[lost], vertical[lost], s=18, label=f"{lost.sum()} fail", **bad)
    style.finish(ax, x, y)
    style.legend_above(ax)
    return ax


def quantile_bands(
    t: Any,
    values: Any,
    shares: Sequence[float] = (0.05, 0.25, 0.5, 0.75, 0.95),
    label: str = "position error [m]",
    ax: Axes | None = None,
) -> Axes:
    """Draw between which values shares of the runs lie, along the path.

    Parameters
    ----------
    t
        (k,): times [s]
    values
        (m, k): of m runs; inf where a run has diverged
    shares
        of the runs, ascending, an odd number of them: bands are drawn between the first and the
        last, the second and the last but one, and a line at the middle one
    label
        of the axis
    ax
        where; None: a new figure

    Raises
    ------
    ValueError
        Shapes that do not fit, or shares that are no such list.
    """
    times, rows = real_numbers("t", t), np.asarray(values, dtype=float)
    if rows.ndim != 2 or times.shape != rows.shape[1:]:
        raise ValueError(f"values has the shape {rows.shape}; must be (runs, {times.size})")
    given = list(shares)
    if len(given) % 2 == 0 or sorted(given) != given or not 0 <= given[0] <= given[-1] <= 1:
        raise ValueError(f"shares is {shown(shares)}; must be an odd number in [0, 1], ascending")
    ax = style.new_axes(ax)
    # By order, not by interpolation: a run that has diverged counts as beyond all others.
    levels = np.quantile(rows, given, axis=0, method="inverted_cdf")
    finite = np.where(np.isfinite(levels), levels, np.nan)
    # A band that ends in diverged runs is drawn up to the top, and its name says so.
    top = 1.05 * np.nanmax(finite, initial=0.0)
    half = len(given) // 2
    for place in range(half):
        last = len(given) - 1 - place
        name = f"{given[place]:.0%} to {given[last]:.0%}"
        is_open = np.isfinite(levels[place]) & ~np.isfinite(levels[last])
        if is_open.any():
            name += ", open where more runs have diverged"
        ax.fill_between(
            times,
            finite[place],
            np.where(is_open, top, finite[last]),
            color=style.ROBOT["color"],
            alpha=0.18 + 0.12 * place,
            linewidth=0,
            label=name,
        )
    ax.plot(times, finite[half], label=f"{given[half]:.0%}", **style.ROBOT)
    style.finish(ax, "t [s]", label)
    style.legend_above(ax)
    return ax
