"""What a page says: its sections, gathered from a tuning result."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from nfopidn._core import Controller, Rival, Scenario, SimulationResult, simulate
from nfopidn.reporting import analysis_figures, run_figures
from nfopidn.reporting.law import Law, law_of
from nfopidn.reporting.numbers import Short, readable
from nfopidn.reporting.robustness import Robustness, robustness_of
from nfopidn.reporting.settings import (
    Row,
    differences,
    metric_rows,
    scenario_groups,
    value_text,
)
from nfopidn.reporting.strokes import Figure
from nfopidn.reporting.verdict import basin_of, basin_text, stability_rows, verdict_text
from nfopidn.stability import loop
from nfopidn.tuning.result import TuneResult, scenario_list

_LONGEST_DOCUMENT = 20_000  # characters
_SAME_COST = 1e-6  # relative


@dataclass
class Stability:
    """The loop's verdict, or why there is none."""

    verdict: str  # a word or two
    text: str
    rows: list[Row]
    why_no_figure: str = ""
    figure: Figure | None = None


@dataclass
class Section:
    """One scenario."""

    title: str
    note: str
    settings: dict[str, list[Row]]
    run: SimulationResult
    metrics: list[Row]
    stability: Stability
    basin: str
    basin_share: str
    columns: dict[str, Short]
    row_step: int
    robot_radius: float
    robot_scale: float
    figures: dict[str, Figure]
    document: str

    @property
    def divergence(self) -> str:
        """Say when the run diverged, or nothing."""
        at = self.run.diverged_at
        return "" if at is None else f"The run diverges at {readable(at)} s and ends there."

    def headline(self, key: str, unit: str = "") -> str:
        """Write one metric of the run."""
        return f"{readable(self.run.metrics[key])} {unit}".rstrip()


def _stability(scenario: Scenario, controller: Controller | Rival) -> Stability:
    if isinstance(controller, Rival):
        text = f"The library analyses loops of NFOPIDN controllers alone, not of {controller.law}."
        return Stability("not analysed", text, [])
    try:
        found = loop(scenario, controller)
    except ValueError as error:
        return Stability("no verdict", f"There is no verdict. {error}.", [])
    rows, text = stability_rows(found), verdict_text(found)
    stability = Stability(found.verdict.replace("_", " "), text, rows)
    if found.verdict == "no_orbit":
        return stability
    try:
        stability.figure = analysis_figures.multipliers(found)
    except ValueError as error:
        stability.why_no_figure = f"There is no figure of the multipliers: {error}."
    return stability


def _title(scenario: Scenario) -> str:
    path = scenario.trajectory
    name = value_text("name", path.name, "")
    laps = "" if path.laps == 1 else f", {path.laps} laps"
    return f"{name[0].upper()}{name[1:]}, {readable(path.period)} s a lap{laps}"


def _document(text: str) -> str:
    """Return a document laid out for reading, or nothing if it is too long for a page."""
    pretty = json.dumps(json.loads(text), indent=1)
    return pretty if len(pretty) <= _LONGEST_DOCUMENT else ""


def section(scenario: Scenario, result: TuneResult, first: Scenario, count: int) -> Section:
    """Simulate a scenario and find out all that the page says of it."""
    controller: Controller | Rival = result.controller
    run = simulate(scenario, controller)
    step = run_figures.row_step(len(scenario.trajectory), count)
    scale = run_figures.robot_scale(run)
    radius = 0.5 * scale * scenario.robot.track_width
    stability = _stability(scenario, controller)
    figures = {
        "path": run_figures.path(run, radius),
        "torques": run_figures.torques(run),
        "velocities": run_figures.velocities(run),
        "errors": run_figures.errors(run),
    }
    basin, basin_share = "", "not analysed"
    if not isinstance(controller, Rival):
        found = basin_of(scenario, controller)
        basin, basin_share = basin_text(found), f"{found.share:.0%}"
        figures["basin"] = analysis_figures.basin(found)
    if stability.figure is not None:
        figures["multipliers"] = stability.figure
    return Section(
        title=_title(scenario),
        note=_note(scenario, run, result, first, count),
        settings=scenario_groups(scenario),
        run=run,
        metrics=metric_rows(run),
        stability=stability,
        basin=basin,
        basin_share=basin_share,
        columns=run_figures.columns(run, step),
        row_step=step,
        robot_radius=radius,
        robot_scale=scale,
        figures=figures,
        document=_document(scenario.to_json()),
    )


def _note(
    scenario: Scenario, run: SimulationResult, result: TuneResult, first: Scenario, count: int
) -> str:
    """Return how a scenario differs from the first one, and its cost from that of the file."""
    if count > 1:
        changed = differences(scenario, first)
        return "" if scenario is first else f"Other than the first: {changed or 'nothing'}."
    if "family" in result:
        return (
            f"The search reported E = {readable(result.fun, 7)}, of a family of "
            f"{len(result.family)} scenarios; the controller gives {readable(run.cost, 7)} here."
        )
    if abs(run.cost - result.fun) <= _SAME_COST * abs(run.cost):
        return ""
    return (
        f"The search reported E = {readable(result.fun, 7)}; the controller gives "
        f"{readable(run.cost, 7)} here."
    )


def search_rows(result: TuneResult) -> list[Row]:
    """Return what was searched, how, and how it ended."""
    structure = result.get("structure", "")
    settings = dict(structure) if isinstance(structure, Mapping) else {}
    options = result.get("options") or {}
    rows = [
        Row("Structure", _pairs(settings) or str(structure), "what is tuned, and in what law"),
        Row("Method", str(result.get("method", "")), ""),
        Row("Options", _pairs(options) or "defaults", "of the method"),
        Row("Seed", f"{result.seed:.0f}", "the same seed gives the same search"),
        Row("Evaluations", f"{result.nfev:,.0f}".replace(",", "\u202f"), "of the cost"),
        Row("Free parameters", str(len(result.parameters)), ", ".join(result.parameters)),
    ]
    if "active_mask" in result:
        ends = [f"{name} ({side})" for name, side in result.at_bounds().items()]
        rows.append(Row("At a bound", ", ".join(ends) or "none", "where wider bounds may help"))
    if "elapsed" in result:
        rows.append(Row("Time", f"{readable(result.elapsed, 3)} s", "of the search"))
    return [*rows, Row("End", result.message, "")]


def _pairs(settings: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in settings.items())


@dataclass
class Page:
    """All of a page."""

    result: TuneResult
    sections: Sequence[Section]
    convergence: Figure
    law: Law
    search: list[Row]
    controller_document: str
    robustness: Robustness | None

    @property
    def cost(self) -> str:
        """Write the cost that the search found."""
        return readable(self.result.fun, 5)

    @property
    def scenarios(self) -> int:
        """Count the scenarios whose costs make that cost."""
        return len(self.result.family) if "family" in self.result else len(self.sections)

    @property
    def verdict(self) -> tuple[str, str]:
        """Give the verdict's colour, and it in words."""
        try:
            found = self.result.verdict
        except ValueError as error:  # the reference never moves
            return "", f"no verdict: {error}"
        return found.colour, found.line

    def data(self) -> dict[str, Any]:
        """Return what the page's script draws."""
        return {
            "format": "nfopidn-report",
            "version": 1,
            "figures": {
                "convergence": self.convergence,
                **({} if self.robustness is None else self.robustness.figures),
            },
            "scenarios": [
                {
                    "columns": one.columns,
                    "robot_radius": one.robot_radius,
                    "diverged_at": one.run.diverged_at,
                    "figures": one.figures,
                }
                for one in self.sections
            ],
        }


def gather(result: TuneResult) -> Page:
    """Find out all that a page says of a tuning result."""
    scenarios = scenario_list(result.scenario)
    return Page(
        result=result,
        sections=[section(one, result, scenarios[0], len(scenarios)) for one in scenarios],
        convergence=analysis_figures.convergence(result.history),
        law=law_of(result.controller),
        search=search_rows(result),
        controller_document=_document(result.controller.to_json()),
        robustness=robustness_of(result),
    )
