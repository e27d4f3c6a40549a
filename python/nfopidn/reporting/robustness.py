"""How well a tuned controller bears another robot: its verdict in figures and rows."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from nfopidn._core import Controller, Rival, Scenario, simulate
from nfopidn.families.family import Family
from nfopidn.families.runs import FamilyRuns, simulate_many
from nfopidn.plot.robustness import MarginBar, lost_names, margin_bars_of
from nfopidn.reporting.numbers import short
from nfopidn.reporting.settings import Row
from nfopidn.reporting.strokes import (
    LOST,
    REFERENCE,
    ROBOT,
    Figure,
    Trace,
    axis,
    figure,
    line,
    markers,
    words,
)
from nfopidn.robustness import Verdict, digest
from nfopidn.tuning.result import TuneResult, scenario_list

#: The rival that the costs stand beside, as it comes.
_YARDSTICK = "LQR"
_MOST_PHASE = 90.0  # where the track of a phase margin ends [degrees]
_ROW_HEIGHT = 30  # [px]
_ROOM = 12.0  # for words, right of the largest cost, as a factor
_SHIFT = 0.13  # of the marks of two controllers, in rows
#: Points of all paths of a bundle together, and the least of each.
_MOST_POINTS, _FEWEST_POINTS = 6000, 60


@dataclass
class Bar:
    """A margin as the page draws it: shares of the track, 0 to 100."""

    margin: MarginBar
    length: float
    least: float | None


@dataclass
class Robustness:
    """What the page says of a verdict."""

    verdict: Verdict
    bars: list[Bar]
    rows: list[Row]
    figures: dict[str, Figure]


def robustness_of(result: TuneResult) -> Robustness | None:
    """Gather it; None where there is no verdict, as of a reference that never moves."""
    try:
        verdict = result.verdict
    except ValueError:
        return None
    family = _judged_family(result, verdict)
    runs = {"tuned": verdict.runs}
    if not (isinstance(result.controller, Rival) and result.controller.law == "lqr"):
        first = family.scenarios[0]
        runs[_YARDSTICK] = simulate_many(family, Rival("lqr", robot=first.model or first.robot))
    return Robustness(
        verdict,
        [_bar(one) for one in margin_bars_of(verdict)],
        [Row(name.capitalize(), text, "") for name, text in verdict.rows()],
        {"variations": variations(runs), "bundle": bundle(family, result.controller)},
    )


def _judged_family(result: TuneResult, verdict: Verdict) -> Family:
    """Return the family that the verdict was found on."""
    family: Family | None = result.get("family")
    if family is not None and family.names == verdict.runs.names:
        return family
    judged: Scenario = next(
        one for one in scenario_list(result.scenario) if digest(one) == verdict.scenario_digest
    )
    return judged.variations("standard")


def _bar(margin: MarginBar) -> Bar:
    known = [one for one in (margin.value, margin.least or 0.0) if np.isfinite(one)]
    reach = 1.25 * max([*known, 1e-9])
    if margin.unit == "degrees":
        reach = max(_MOST_PHASE, reach)
    length = 0.0 if np.isnan(margin.value) else min(100.0, 100 * margin.value / reach)
    return Bar(margin, length, None if margin.least is None else 100 * margin.least / reach)


def variations(runs: dict[str, FamilyRuns]) -> Figure:
    """Draw what each variation costs, a row a variation and a mark a controller.

    Runs that diverge are a cross at the right edge, with the words.
    """
    names = next(iter(runs.values())).names
    rows = np.arange(len(names))[::-1]
    kept = np.concatenate([one.costs[~one.diverged] for one in runs.values()])
    kept = kept[kept > 0]
    low, high = (0.5 * kept.min(), 2 * kept.max()) if kept.size else (0.01, 1.0)
    lost = [(float(row), text) for row, text in zip(rows, lost_names(runs), strict=True) if text]
    if lost:
        high *= _ROOM
    traces: list[Trace] = []
    marks = (("robot", "circle", "robot"), ("other", "square", "paper"))
    for place, ((name, one), (colour, symbol, fill)) in enumerate(
        zip(runs.items(), marks[: len(runs)], strict=True)
    ):
        y = rows + _SHIFT * (1 - 2 * place) * (len(runs) > 1)
        shown = ~one.diverged
        traces.append(
            markers(
                *(short(one.costs[shown]), short(y[shown]), name, colour),
                fill=fill,
                symbol=symbol,
                columns={"name": [names[i] for i in np.flatnonzero(shown)]},
                hover=[["variation", "name", ""], ["cost E", "x", ""]],
            )
        )
    if lost:
        at = short([high / 1.2] * len(lost)), short(row for row, _ in lost)
        traces.append(markers(*at, "diverges", "bad", symbol="x", size=9, width=2.2))
        traces.append(words(*at, [text for _, text in lost], "bad"))
    labels = [",\n".join(name.rsplit(", ", 1)) for name in names]
    up = axis("", range=[-0.7, len(names) - 0.3], ticks=rows.tolist(), labels=labels)
    across = axis("cost E, eq. 41 [-]", log=True, range=short([low, high]))
    return figure(traces, 90 + _ROW_HEIGHT * len(names), across, up)


def bundle(family: Family, controller: Controller | Rival) -> Figure:
    """Draw the paths driven on every scenario of a family; what diverges is named."""
    points = max(_FEWEST_POINTS, _MOST_POINTS // len(family))
    traces: list[Trace] = []
    lost: list[Trace] = []
    references: list[tuple[Any, Any]] = []
    for name, scenario in family.items():
        path = scenario.trajectory
        step = max(1, -(-len(path) // points))
        way = short(path.x[::step]), short(path.y[::step])
        if way not in references:
            references.append(way)
        run = simulate(scenario, controller)
        x, y = (short(run.columns[key][::step], 5) for key in ("x", "y"))
        told = {"columns": {"name": [name] * len(x)}, "hover": [["", "name", ""]]}
        if run.diverged_at is None:
            thin = {**ROBOT, "width": 0.9}
            traces.append(line(x, y, f"runs of {len(family)} variations", thin, **told))
        else:
            lost.append(line(x, y, f"{name}: diverges", LOST, **told))
    ways = [line(*way, "reference", REFERENCE) for way in references]
    box = [_box([one[k] for one in references], [t["xy"[k]] for t in traces]) for k in (0, 1)]
    room = 0.08 * max(high - low for low, high in box)
    across, up = (
        axis(f"{name} [m]", range=short([low - room, high + room]))
        for name, (low, high) in zip("xy", box, strict=True)
    )
    return figure([*ways, *traces, *lost], 460, across, up, equal=True)


def _box(references: list[Any], runs: list[Any]) -> tuple[float, float]:
    """Return what is to be seen: the references, and runs up to half their size beyond."""
    own = np.concatenate([np.array(one, dtype=float) for one in references])
    room = 0.5 * float(np.ptp(own))
    all_of_them = np.concatenate([own, *(np.array(one, dtype=float) for one in runs)])
    return (
        max(float(np.nanmin(all_of_them)), float(own.min()) - room),
        min(float(np.nanmax(all_of_them)), float(own.max()) + room),
    )
