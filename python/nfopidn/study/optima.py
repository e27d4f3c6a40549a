"""The open-loop optima, beside what the published and the tuned gains reach."""

from __future__ import annotations

from matplotlib.figure import Figure

from nfopidn import plot
from nfopidn._core import Controller, Scenario, SimulationResult, simulate
from nfopidn.study.cases import RUN_DIGITS, RUN_UNITS, Cases, InterruptedSearchError
from nfopidn.study.files import Cell, Folder
from nfopidn.study.optimum import open_loop_optimum


def _scenarios() -> dict[str, Scenario]:
    return {
        "published": Scenario.published(rng=0),
        "continuous heading": Scenario.published(rng=0, heading="continuous"),
        "continuous heading, lap of 50 s": Scenario.published(
            rng=0, heading="continuous", period=50
        ),
    }


def _draw(run: SimulationResult) -> Figure:
    figure = Figure(figsize=(9.6, 4.4), layout="constrained")
    halves = figure.add_gridspec(1, 2, width_ratios=(1, 1.15))
    plot.path(run, ax=figure.add_subplot(halves[0]))
    torque, *speeds = halves[1].subgridspec(3, 1).subplots(sharex=True, squeeze=False).flat
    plot.total_torque(run, ax=torque)
    torque.set_xlabel("")
    plot.velocities(run, axes=speeds)
    return figure


def optima(cases: Cases, folder: Folder) -> None:
    """Write the open-loop optima of three scenarios; draw the published one's run."""
    rows: list[dict[str, Cell]] = []
    tries: list[dict[str, Cell]] = []
    for name, scenario in _scenarios().items():
        found = open_loop_optimum(scenario)
        if found.interrupted:
            raise InterruptedSearchError
        run = simulate(scenario, Controller.published())
        rows.append({"scenario": name, "optimum": found.cost, "published_gains": run.cost})
        for guess in found.guesses:
            status = {"guess": guess.name, "cost": guess.cost, "status": guess.status}
            tries.append({"scenario": name, **status})
        if name == "published" and found.run is not None:
            title = f"The best torques found by open_loop_optimum, E = {found.cost:.6f}"
            folder.figure("optimum", title, _draw(found.run))
            folder.table("run_optimum", title, found.run.columns, RUN_UNITS, RUN_DIGITS)
        cases.report(f"optimum, {name}")
    title = "Smallest costs found over all torques; a local solver, not proven"
    folder.table("optima", title, {key: [row[key] for row in rows] for key in rows[0]}, {})
    title = "First guesses of these searches, and what became of each"
    columns = {key: [row[key] for row in tries] for key in tries[0]}
    folder.table("optima_guesses", title, columns, {})
