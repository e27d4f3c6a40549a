"""The paper's Figs. 12 and 13: the cost against the memory M, with its orders."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from nfopidn._core import Controller, Scenario, simulate
from nfopidn.engines import Engine, Threads, Work
from nfopidn.plot import style
from nfopidn.study.cases import MEMORIES, Cases, tuned
from nfopidn.study.files import Folder

Array = NDArray[np.float64]

_SEED_DOTS: style.Stroke = {
    "color": "0.65",
    "markersize": 3,
    "marker": "o",
    "linestyle": "none",
    "zorder": 2.0,
}
_MEDIAN = {**style.ROBOT, "marker": "o", "markersize": 5}
_PUBLISHED = {**style.RIGHT, "marker": "s", "markersize": 5}
_VALUES = ("cost", "alpha", "sigma")


def _published_costs(cases: Cases) -> Array:
    runs = [simulate(cases.scenario, Controller.published(memory=m)) for m in MEMORIES]
    return np.array([run.cost for run in runs])


class _Search:
    """A search of each memory and seed; what an engine's workers are given."""

    def __init__(self, scenario: Scenario, seeds: int) -> None:
        self.scenario = scenario
        self.which = [(memory, seed) for memory in MEMORIES for seed in range(1, seeds + 1)]

    def __call__(self, span: tuple[int, int]) -> Array:
        """Return cost, alpha and sigma of the searches of (first, count), (count, 3)."""
        first, count = span
        rows = []
        for memory, seed in self.which[first : first + count]:
            found = tuned(self.scenario, {"memory": memory}, seed)
            values = dict(zip(found.parameters, found.x, strict=True))
            rows.append((found.fun, values["alpha"], values["sigma"]))
        return np.array(rows)


def _searches(cases: Cases, seeds: int, workers: int | Engine) -> Array:
    """Return cost, alpha and sigma of each search, (8, seeds, 3)."""
    search = _Search(cases.scenario, seeds)
    table = np.empty((len(search.which), len(_VALUES)))
    with (
        Threads(workers) if isinstance(workers, int) else workers as engine,
        Work(engine, search, "the searches", "searches") as work,
        closing(work.blocks(len(table), lambda first, size: (first, size))) as blocks,
    ):
        for block in blocks:
            table[block.first : block.first + block.size] = block.answer
            for memory, _ in search.which[block.first : block.first + block.size]:
                cases.report(f"tuned anew, M = {memory}")
    return table.reshape(len(MEMORIES), seeds, len(_VALUES))


def _summary(table: Array) -> dict[str, Array]:
    """Return quartiles of the costs, and the orders of each memory's median run."""
    costs = table[:, :, 0]
    low, middle, high = np.quantile(costs, (0.25, 0.5, 0.75), axis=1)
    count = costs.shape[1]
    median_run = np.argsort(costs, axis=1, kind="stable")[:, (count - 1) // 2]
    _, alpha, sigma = table[np.arange(len(table)), median_run].T
    return {
        "median": middle,
        "lower_quartile": low,
        "upper_quartile": high,
        "best": costs.min(axis=1),
        "worst": costs.max(axis=1),
        "alpha_of_median_run": alpha,
        "sigma_of_median_run": sigma,
        "seed_of_median_run": median_run + 1,
    }


def _write(folder: Folder, published: Array, table: Array, summary: dict[str, Array]) -> None:
    controller = Controller.published()
    orders = {name: [getattr(controller, name)] * len(MEMORIES) for name in ("alpha", "sigma")}
    title = "Figs. 12 and 13: cost against memory, published gains held fixed"
    columns: dict[str, Any] = {"memory": MEMORIES, "cost": published, **orders}
    folder.table("memory_published", title, columns, {})
    seeds = table.shape[1]
    title = f"Figs. 12 and 13: cost against memory, tuned anew for each, {seeds} seeds"
    folder.table("memory_tuned", title, {"memory": MEMORIES, **summary}, {})
    each: dict[str, Any] = {
        "memory": np.repeat(MEMORIES, seeds),
        "seed": np.tile(np.arange(1, seeds + 1), len(MEMORIES)),
    }
    each |= dict(zip(_VALUES, table.reshape(-1, len(_VALUES)).T, strict=True))
    folder.table("memory_tuned_seeds", "Each of these searches", each, {})


def _finish(ax: Axes, ylabel: str, title: str) -> None:
    style.finish(ax, "memory M [samples]", ylabel)
    ax.set_xticks(list(MEMORIES))
    ax.set_xlim(MEMORIES[0] - 0.6, MEMORIES[-1] + 0.6)
    style.legend_above(ax, ncols=3)
    ax.set_title(title, loc="left", pad=18, fontsize=style.LABEL_SIZE, fontweight="bold")


def _cost_figure(published: Array, table: Array, summary: dict[str, Array]) -> Figure:
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    fixed, anew = figure.subplots(1, 2)
    fixed.plot(MEMORIES, published, label="cost", **_PUBLISHED)
    best = int(np.argmin(published))
    for k, value in enumerate(published):
        fixed.annotate(
            f"{value:.5f}",
            (MEMORIES[k], value),
            xytext=(0, 7),
            textcoords="offset points",
            ha="center",
            fontsize=style.TICK_SIZE - 1,
            fontweight="bold" if k == best else "normal",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
            zorder=4,
        )
    fixed.set_ylim(0, 1.1 * published.max())
    _finish(fixed, "cost E", "published gains held fixed")
    _dots(anew, table[:, :, 0])
    spread = np.abs(summary["median"] - [summary["lower_quartile"], summary["upper_quartile"]])
    anew.errorbar(
        MEMORIES, summary["median"], spread, capsize=3, label="median and quartiles", **_MEDIAN
    )
    _mark_beyond(anew, table[:, :, 0], float(summary["upper_quartile"].max()))
    _finish(anew, "cost E", f"tuned anew for each M, {table.shape[1]} seeds")
    return figure


def _dots(ax: Axes, values: Array) -> None:
    memories = np.repeat(MEMORIES, values.shape[1])
    ax.plot(memories, values.ravel(), label="each seed", **_SEED_DOTS)


def _mark_beyond(ax: Axes, costs: Array, upper: float) -> None:
    """End the axis at 1.2 times the largest upper quartile, and name the costs beyond."""
    top = max(1.2 * upper, float(costs.min()) * 1.01)
    for memory, row in zip(MEMORIES, costs, strict=True):
        beyond = row[row > top]
        if beyond.size:
            ax.annotate(
                "↑ " + ", ".join(f"{value:.3f}" for value in np.sort(beyond)),
                (memory, top),
                xytext=(0, -2),
                textcoords="offset points",
                ha="center",
                va="top",
                fontsize=style.TICK_SIZE - 1,
            )
    ax.set_ylim(0.97 * costs.min(), top)


def _order_figure(table: Array, summary: dict[str, Array]) -> Figure:
    controller = Controller.published()
    figure = Figure(figsize=(9.6, 3.6), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for column, (ax, name) in enumerate(zip(panels, ("alpha", "sigma"), strict=True), start=1):
        _dots(ax, table[:, :, column])
        ax.plot(MEMORIES, summary[f"{name}_of_median_run"], label="median run", **_MEDIAN)
        published = [getattr(controller, name)] * len(MEMORIES)
        ax.plot(MEMORIES, published, label="published", **{**_PUBLISHED, "marker": None})
        _finish(ax, "order [-]", rf"order $\{name}$, tuned anew for each M")
    return figure


def memory_study(cases: Cases, folder: Folder, seeds: int, workers: int | Engine = 1) -> None:
    """Draw and write the cost and the orders against the memory, of fixed and of tuned gains."""
    published = _published_costs(cases)
    table = _searches(cases, seeds, workers)
    summary = _summary(table)
    _write(folder, published, table, summary)
    title = "Fig. 12: cost against memory, published gains and tuned anew"
    folder.figure("fig12_cost_by_memory", title, _cost_figure(published, table, summary))
    title = "Fig. 13: orders against memory, tuned anew"
    folder.figure("fig13_orders_by_memory", title, _order_figure(table, summary))
