"""Figures of robustness: costs by variation, paths over a family, margins with their thresholds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from nfopidn._core import Controller, Rival, simulate
from nfopidn.families.family import Family
from nfopidn.families.runs import FamilyRuns
from nfopidn.plot import style
from nfopidn.plot.comparisons import stroke
from nfopidn.robustness.judgement import LEAST_GAIN_MARGIN
from nfopidn.robustness.verdict import Verdict

#: Of verdicts; each stands beside its word, so that it is readable without colours.
VERDICT_COLOURS: Final[Mapping[str, str]] = {
    "green": "#1b7f4d",
    "amber": "#a86200",
    "red": style.DIVERGENCE["color"],
}
_MARKERS = "osD^vP*X"
#: Delay that must be borne: less is red [samples].
LEAST_DELAY: Final = 1.0


def same_names(runs: Mapping[str, FamilyRuns]) -> tuple[str, ...]:
    """Return the variations' names, which must be those of all runs.

    Raises
    ------
    ValueError
        No runs, or runs of different families.
    """
    if not runs:
        raise ValueError("runs is empty; must have the runs of at least one controller")
    names = next(iter(runs.values())).names
    for controller, one in runs.items():
        if one.names != names:
            raise ValueError(
                f"runs of {controller!r} are of another family; must be of the first one's"
            )
    return names


def lost_names(runs: Mapping[str, FamilyRuns]) -> list[str]:
    """Return for each variation which controllers diverge, in words; "" where none does."""
    lost = [
        [name for name, one in runs.items() if one.diverged[place]]
        for place in range(len(same_names(runs)))
    ]
    return [
        f"{', '.join(names)} {'diverges' if len(names) == 1 else 'diverge'}" if names else ""
        for names in lost
    ]


def _mark_lost(ax: Axes, row: float, text: str) -> None:
    """Mark a row at the right edge, with the words beside the axes."""
    edge: dict[str, Any] = {"transform": ax.get_yaxis_transform(), "color": VERDICT_COLOURS["red"]}
    ax.plot([1.0], [row], marker="x", markersize=5, markeredgewidth=1.6, clip_on=False, **edge)
    ax.text(1.02, row, text, va="center", fontsize=style.TICK_SIZE - 1, **edge)


def variation_costs(runs: Mapping[str, FamilyRuns], ax: Axes | None = None) -> Axes:
    """Draw what each variation costs, a row a variation and a mark a controller.

    The axis is logarithmic. A run that diverges has no cost to compare: a red cross at the right
    edge stands for it, with the words who diverges.

    Parameters
    ----------
    runs
        of each controller by name, all of one family: what `simulate_many` returns, or the `runs`
        of verdicts
    ax
        where; None: a new figure

    Returns
    -------
    Axes
        with the drawing

    Raises
    ------
    ValueError
        No runs, or runs of different families.
    """
    names = same_names(runs)
    ax = style.new_axes(ax, (6.4, 1.1 + 0.31 * len(names)))
    rows = np.arange(len(names))[::-1]
    ax.set_xscale("log")
    for place, (controller, one) in enumerate(runs.items()):
        y = rows + 0.14 * ((len(runs) - 1) / 2 - place)
        kept = ~one.diverged
        colour = stroke(place)["color"]
        ax.plot(
            *(one.costs[kept], y[kept]),
            marker=_MARKERS[place % len(_MARKERS)],
            markersize=5,
            linestyle="none",
            color=colour,
            label=controller,
        )
    for row, text in zip(rows, lost_names(runs), strict=True):
        if text:
            _mark_lost(ax, float(row), text)
    ax.set_yticks(rows, names)
    ax.set_ylim(-0.6, len(names) - 0.4)
    style.finish(ax, "cost E, eq. 41 [-]", "")
    style.legend_above(ax)
    return ax


def path_bundle(family: Family, controller: Controller | Rival, ax: Axes | None = None) -> Axes:
    """Draw the paths that a controller drives on every scenario of a family.

    They are simulated again. A run that diverges is red and dashed until then, and is named.

    Parameters
    ----------
    family
        its first scenario's path is drawn as the reference, and so is each other one's that differs
    controller
        a Controller or a Rival
    ax
        where; None: a new figure

    Returns
    -------
    Axes
        with the drawing
    """
    ax = style.new_axes(ax, (5.6, 5.2))
    references: list[tuple[list[float], list[float]]] = []
    labelled = False
    for name, scenario in family.items():
        path = scenario.trajectory
        if (way := (path.x.tolist(), path.y.tolist())) not in references:
            label = None if references else "reference"
            references.append(way)
            ax.plot(*way, label=label, **style.REFERENCE)
        run = simulate(scenario, controller)
        x, y = run.columns["x"], run.columns["y"]
        if run.diverged_at is not None:
            ax.plot(x, y, label=f"{name}: diverges", **{**style.DIVERGENCE, "linewidth": 1.3})
            continue
        label = None if labelled else f"runs of {len(family)} scenarios"
        ax.plot(x, y, label=label, alpha=0.55, **{**style.ROBOT, "linewidth": 0.8})
        labelled = True
    style.finish(ax, "x [m]", "y [m]")
    ax.set_aspect("equal")
    _keep_to(ax, references)
    style.legend_above(ax, ncols=2)
    return ax


def _keep_to(ax: Axes, references: Sequence[tuple[list[float], list[float]]]) -> None:
    """Leave out how far a run goes that diverges: beyond half the path's size from it."""
    for way, limits in ((0, ax.set_xlim), (1, ax.set_ylim)):
        values = np.concatenate([one[way] for one in references])
        room = 0.5 * max(float(np.ptp(one[k])) for one in references for k in (0, 1))
        shown = np.array(ax.dataLim.intervalx if way == 0 else ax.dataLim.intervaly)
        low, high = max(shown[0], values.min() - room), min(shown[1], values.max() + room)
        limits(low - 0.04 * room, high + 0.04 * room)


@dataclass(frozen=True)
class MarginBar:
    """One margin as it is drawn.

    Attributes
    ----------
    title
        "gain", "phase" or "delay"
    unit
        "dB", "degrees" or "samples"
    value
        inf where nothing bounds it, nan where it is not known
    least
        threshold, or None
    colour
        "green", "amber" or "red"
    text
        the value, and the colour's word and reason if it is not green
    """

    title: str
    unit: str
    value: float
    least: float | None
    colour: str
    text: str


def margin_bars_of(verdict: Verdict) -> tuple[MarginBar, MarginBar, MarginBar]:
    """Return gain, phase and delay margin of a verdict, with the thresholds that it judges by.

    The delay is what the loop bears on its path in simulation, since red is judged by that.
    """
    margin, limits = verdict.margin, verdict.limits
    gain = np.nan if margin is None else margin.decibels
    phase = np.nan if margin is None else float(np.degrees(margin.phase))
    delay = 0.0 if limits is None else float(limits.extra_delay)
    lost = "red: not stable" if not verdict.stable else "red: off its path"

    def bar(title: str, unit: str, value: float, least: float | None, below: str) -> MarginBar:
        if margin is None:
            return MarginBar(title, unit, np.nan, least, "red", lost)
        if np.isnan(value):
            return MarginBar(title, unit, value, least, "green", "not known")
        one = unit.removesuffix("s")
        number = "unbounded" if np.isinf(value) else f"{value:.3g} {one if value == 1 else unit}"
        if least is not None and value < least:
            return MarginBar(
                title,
                unit,
                value,
                least,
                below,
                f"{number}, {below}: under {least:g} {one if least == 1 else unit}",
            )
        return MarginBar(title, unit, value, least, "green", number)

    return (
        bar("gain", "dB", gain, LEAST_GAIN_MARGIN, "amber"),
        bar("phase", "degrees", phase, None, "green"),
        bar("delay", "samples", delay, LEAST_DELAY, "red"),
    )


def margin_bars(
    verdicts: Mapping[str, Verdict], axes: Sequence[Axes] | None = None
) -> np.ndarray[tuple[int], np.dtype[np.object_]]:
    """Draw gain, phase and delay margin of controllers as bars, with the verdict's thresholds.

    A bar under its threshold has the colour of the verdict that follows from it, and the word. The
    delay is the one that the loop bears on its path in simulation.

    Parameters
    ----------
    verdicts
        by the controllers' names
    axes
        three Axes; None: a new figure

    Returns
    -------
    numpy.ndarray
        (3,) Axes: gain [dB], phase [degrees], delay [samples]

    Raises
    ------
    ValueError
        No verdicts, or another number of Axes.
    """
    if not verdicts:
        raise ValueError("verdicts is empty; must have the verdict of at least one controller")
    if axes is None:
        height = 0.9 + 0.42 * len(verdicts)
        figure = plt.figure(figsize=(9.6, height), layout="constrained")
        axes = list(figure.subplots(1, 3, sharey=True))
    panels = style.new_panels(axes, 3)
    rows = np.arange(len(verdicts))[::-1]
    bars = [margin_bars_of(verdict) for verdict in verdicts.values()]
    for panel, ax in enumerate(panels):
        column = [row[panel] for row in bars]
        first = column[0]
        finite = [one.value for one in column if np.isfinite(one.value)]
        reach = 1.25 * max([*finite, first.least or 0.0, 1e-9])
        for y, one in zip(rows, column, strict=True):
            length = 0.0 if np.isnan(one.value) else min(one.value, reach)
            ax.barh(y, length, height=0.5, color=VERDICT_COLOURS[one.colour], alpha=0.85)
            ax.text(
                *(0.02 * reach, y + 0.27, one.text),
                va="bottom",
                fontsize=style.TICK_SIZE,
                color="#222222" if one.colour == "green" else VERDICT_COLOURS[one.colour],
            )
        if first.least is not None:
            ax.axvline(first.least, **style.LIMIT)
        ax.set_xlim(0, reach)
        ax.set_ylim(-0.5, len(verdicts) - 0.1)
        style.finish(ax, f"{first.title} margin [{first.unit}]", "")
    panels[0].set_yticks(rows, [f"{name}\n{verdict.colour}" for name, verdict in verdicts.items()])
    for label, verdict in zip(panels[0].get_yticklabels(), verdicts.values(), strict=True):
        label.set_color(VERDICT_COLOURS[verdict.colour])
    return panels
