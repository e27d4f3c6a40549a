"""Controllers against scenarios."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator, Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import dataclass, field, replace
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import (
    Controller,
    Rival,
    Scenario,
    SimulationResult,
    StopIf,
    metric_fields,
    simulate,
)
from nfopidn.arguments import check_sample_time, suggestion, whole_number
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.comparison import tables
from nfopidn.comparison.contenders import AnyController
from nfopidn.comparison.ranking import Ranking, rank
from nfopidn.comparison.suite import scenario_suite
from nfopidn.console import progress as progress_bar
from nfopidn.engines import Work, read_workers
from nfopidn.families.family import Family

#: A run has settled when its position error stays within this [m].
SETTLED_WITHIN = _core.SETTLED_WITHIN
#: Runs that are measured between two looks at Ctrl-C, and kept as rows meanwhile.
_BLOCK = 2**13

Array = NDArray[np.float64]
#: What compare() takes for one name: a controller, or one for each run.
Entry = AnyController | Sequence[AnyController]


def settling_time(run: SimulationResult) -> float:
    """Give the last time [s] at which the position error exceeds 0.05 m.

    0 if it never does; inf if the run diverges, or exceeds it at its last sample: it never settles.
    """
    return _core.settling_time(run)


def torque_deviation(run: SimulationResult) -> float:
    """Give the root mean square of the torques' distance from the reference's [N m].

    nan of a run that diverges at once, which has no samples.
    """
    return _core.torque_deviation(run)


@dataclass(frozen=True)
class Metric:
    """One figure of a run."""

    unit: str
    text: str
    of: Callable[[SimulationResult], float]


def _metric(name: str) -> Metric:
    """Take one of the core's."""
    unit, text = metric_fields()[name]
    return Metric(unit, text, lambda run: float(run.metrics[name]))


METRICS: dict[str, Metric] = {
    **{name: _metric(name) for name in ("cost", "position_rms", "position_max", "heading_rms")},
    "settling_time": Metric(
        "s", "last time at which the position error exceeds 0.05 m", settling_time
    ),
    "torque_deviation": Metric(
        "N m", "root mean square of torque less reference", torque_deviation
    ),
    **{name: _metric(name) for name in ("torque_variation", "torque_peak", "share_at_limit")},
    "diverged": Metric(
        "", "share of runs that diverged", lambda run: float(run.diverged_at is not None)
    ),
}


@dataclass(frozen=True)
class Comparison:
    """What compare() returns.

    Attributes
    ----------
    controllers, scenarios
        their names
    values
        by metric: (controllers, scenarios, runs)
    draws
        (controllers, scenarios, runs), int: runs of a pair with the same number are one and the
        same run, counted several times
    first_runs
        by the names of controller and scenario: the first run of the pair, a SimulationResult
    optima
        by the name of a scenario: the best open-loop cost known, or None where none was found
    """

    controllers: tuple[str, ...]
    scenarios: tuple[str, ...]
    values: dict[str, Array]
    draws: NDArray[np.int64]  # as values: which runs of a pair are one and the same
    first_runs: dict[tuple[str, str], SimulationResult]
    #: The best open-loop cost known of a scenario; None: none was found.
    optima: dict[str, float | None] = field(default_factory=dict)

    def median(self, metric: str = "cost") -> Array:
        """Give a metric's medians over the runs, (controllers, scenarios)."""
        if metric not in self.values:
            hint = suggestion(metric, self.values)
            known = ", ".join(self.values)
            raise ValueError(f"metric is {metric!r}{hint}; must be one of {known}")
        return np.median(self.values[metric], axis=2)

    def join(self, others: Sequence[Comparison]) -> Comparison:
        """Put the scenarios of others, with the same controllers and runs, behind one's own."""
        parts = [self, *others]
        return Comparison(
            self.controllers,
            tuple(name for part in parts for name in part.scenarios),
            {
                metric: np.concatenate([part.values[metric] for part in parts], axis=1)
                for metric in METRICS
            },
            np.concatenate([part.draws for part in parts], axis=1),
            {pair: run for part in parts for pair, run in part.first_runs.items()},
            {name: cost for part in parts for name, cost in part.optima.items()},
        )

    def unit(self, metric: str) -> str:
        """Give the unit of a metric, or an empty string where it has none."""
        return METRICS[metric].unit

    def ranking(self, scenario: str) -> Ranking:
        """Rank the controllers on a scenario by their costs."""
        if scenario not in self.scenarios:
            hint = suggestion(scenario, self.scenarios)
            known = ", ".join(self.scenarios)
            raise ValueError(f"scenario is {scenario!r}{hint}; must be one of {known}")
        place = self.scenarios.index(scenario)
        costs, draws = self.values["cost"][:, place], self.draws[:, place]
        return rank(list(self.controllers), costs, draws)

    def with_optima(self, optima: Mapping[str, float | None]) -> Comparison:
        """Give the same with costs of study.open_loop_optimum(); tables then tell multiples.

        Raises
        ------
        ValueError
            A scenario that is not compared on, a cost that is not positive.
        """
        for name, cost in optima.items():
            if name not in self.scenarios:
                hint = suggestion(name, self.scenarios)
                known = ", ".join(self.scenarios)
                raise ValueError(f"optima names {name!r}{hint}; must be one of {known}")
            if cost is not None and not (np.isfinite(cost) and cost > 0):
                raise ValueError(f"optima[{name!r}] is {cost}; must be greater than 0, or None")
        return replace(self, optima={**self.optima, **optima})

    def to_markdown(self, metric: str = "cost") -> str:
        """Give a table of medians, a row a controller and a column a scenario."""
        return tables.markdown(self, metric)

    def details(self, scenario: str) -> str:
        """Give a Markdown table of every metric on one scenario, in the order of the ranking."""
        return tables.details(self, scenario)

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write every figure: a row a controller, scenario and run."""
        tables.write_csv(self, path)

    def print(self, metric: str = "cost") -> None:
        """Print the table: by rich in a terminal, else as Markdown."""
        tables.print_table(self, metric)

    def plot(self, metric: str = "cost", ax: Any = None) -> Any:
        """Draw a metric's medians as bars; returns the Axes."""
        from nfopidn import plot

        return plot.comparison(self, metric, ax=ax)


def _named(controllers: Mapping[str, Entry] | Sequence[AnyController]) -> dict[str, list[Any]]:
    if not isinstance(controllers, Mapping):
        if isinstance(controllers, Controller | Rival):
            controllers = [controllers]
        controllers = {_name(one, place): one for place, one in enumerate(controllers)}
    named: dict[str, list[Any]] = {}
    for name, entry in controllers.items():
        members: list[Any] = list(entry) if isinstance(entry, Iterable) else [entry]
        if not members or not all(isinstance(one, Controller | Rival) for one in members):
            raise ValueError(
                f"controllers: {name!r} must be a Controller, a Rival or a list of them"
            )
        named[name] = members
    if not named:
        raise ValueError("controllers is empty")
    lengths = {len(members) for members in named.values()} - {1}
    if len(lengths) > 1:
        raise ValueError(
            f"controllers have lists of {sorted(lengths)} members; must be of one length"
        )
    return named


def _name(controller: Any, place: int) -> str:
    own = controller.law if isinstance(controller, Rival) else "NFOPIDN"
    return f"{place + 1} {own}"


def _check_sample_times(named: dict[str, list[Any]], scenarios: dict[str, Scenario]) -> None:
    """Refuse before the first run what none of the runs could be."""
    for name, members in named.items():
        for place, scenario in scenarios.items():
            try:
                for member in members:
                    check_sample_time(member, scenario)
            except ValueError as error:
                raise ValueError(f"{name!r} on {place!r}: {error}") from None


@in_standard_arithmetic
def compare(
    controllers: Mapping[str, Entry] | Sequence[AnyController],
    scenarios: Family | Mapping[str, Scenario] | Sequence[str] | None = None,
    *,
    seeds: int = 1,
    workers: Any = 1,
    progress: bool = False,
) -> Comparison:
    """Run controllers on scenarios and compare what they do.

    Parameters
    ----------
    controllers
        By name, or a list: a Controller or a Rival each, or a list of them, such as of searches
        with different seeds. Lists must be of one length; the member at a place is paired with the
        others' there.
    scenarios
        By name, a Family, or names of scenario_suite(); None: all of the suite.
    seeds
        Draws of the noise for each member, in scenarios that have noise: seeds 0, 1, 2 and so on.
        Of each run the metrics are kept alone, of each pair its first run too. With
        `noise_source="counter"` the runs of a Controller go in lanes.
    workers
        Pairs of a controller and a scenario at a time, on threads, or where these are fewer the
        runs of a pair; -1 for as many as there are processors; or an Executor as of
        concurrent.futures, a dask.distributed.Client or a function like map, whose workers run the
        pairs. The result is the same with each.
    progress
        Whether to show a bar.

    Returns
    -------
    Comparison
        Ctrl-C ends the runs and raises KeyboardInterrupt.

    Raises
    ------
    ValueError
        Unknown scenario, lists of different lengths, nothing to compare.
    EngineError
        The workers keep dying, or were closed meanwhile.
    """
    whole_number("seeds", seeds, 1)
    crew = read_workers(workers)
    named = _named(controllers)
    if isinstance(scenarios, Family):
        chosen = dict(scenarios.items())
    else:
        chosen = dict(scenarios) if isinstance(scenarios, Mapping) else scenario_suite(scenarios)
    if not chosen or not all(isinstance(one, Scenario) for one in chosen.values()):
        raise ValueError("scenarios must be Scenarios by name, at least one")
    _check_sample_times(named, chosen)
    count = max(len(members) for members in named.values()) * seeds
    pairs = [(name, place) for name in named for place in chosen]
    values = {metric: np.empty((len(named), len(chosen), count)) for metric in METRICS}
    draws = np.empty((len(named), len(chosen), count), dtype=np.int64)
    first: dict[tuple[str, str], SimulationResult] = {}

    with progress_bar("comparing", len(pairs), progress) as report:
        measured = _on_threads if isinstance(crew, int) else _on_engine
        every = _Pairs([(named[name], chosen[place]) for name, place in pairs], seeds)
        with closing(measured(every, crew)) as finished:
            for done, (at, found) in enumerate(finished):
                i, j = divmod(at, len(chosen))
                first[pairs[at]] = found.first_run
                own = draws[i, j] = found.places(count, seeds)
                for name, column in found.columns.items():
                    values[name][i, j] = column[own]
                report(done + 1, " on ".join(pairs[at]))
    first = {pair: first[pair] for pair in pairs}
    return Comparison(tuple(named), tuple(chosen), values, draws, first)


class _Pairs:
    """Controllers with scenarios, pair by pair; what an engine's workers are given."""

    def __init__(self, pairs: list[tuple[list[Any], Scenario]], seeds: int) -> None:
        self.pairs, self.seeds = pairs, seeds

    def measure(self, place: int, threads: int = 1) -> _Measured:
        """Run a pair."""
        members, scenario = self.pairs[place]
        return _measure(members, scenario, self.seeds, threads)

    @in_standard_arithmetic
    def __call__(self, span: tuple[int, int]) -> list[_Measured]:
        """Run the pairs of (first, count)."""
        first, count = span
        return [self.measure(place) for place in range(first, first + count)]


def _on_threads(pairs: _Pairs, threads: Any) -> Generator[tuple[int, _Measured], None, None]:
    """Run the pairs on threads of this process, in order; an exception, as by Ctrl-C, ends them."""
    ended = threading.Event()
    each = max(1, threads // len(pairs.pairs))

    def work(place: int) -> _Measured:
        with StopIf(ended.is_set):
            return pairs.measure(place, each)

    with ThreadPoolExecutor(threads) as pool:
        try:
            yield from enumerate(pool.map(work, range(len(pairs.pairs))))
        except BaseException:
            ended.set()  # the pool waits for what it has begun
            raise


def _on_engine(pairs: _Pairs, engine: Any) -> Generator[tuple[int, _Measured], None, None]:
    """Have an engine's workers run the pairs; they come in any order."""
    with (
        engine,
        Work(engine, pairs, "controllers", "pairs") as work,
        closing(work.blocks(len(pairs.pairs), lambda first, size: (first, size))) as blocks,
    ):
        for block in blocks:
            yield from enumerate(block.answer, block.first)


@dataclass(frozen=True)
class _Measured:
    """The runs of a pair that differ: for each member all draws of the noise, if there is any."""

    first_run: SimulationResult
    columns: dict[str, Array]  # by metric: (members * draws,)
    members: int
    draws: int

    def places(self, count: int, seeds: int) -> NDArray[np.int64]:
        """Give (count,): which of them each run of the comparison is."""
        run = np.arange(count)
        return run // seeds % self.members * self.draws + run % seeds % self.draws


def _measure(members: list[Any], scenario: Scenario, seeds: int, threads: int) -> _Measured:
    """Run a pair; only the figures of the runs are kept, and the first run itself."""
    noisy = any(value > 0 for value in scenario.pose_noise)
    draws = seeds if noisy else 1
    first_run = simulate(scenario.replace(rng=0) if noisy else scenario, members[0])
    columns = {name: np.empty(len(members) * draws) for name in METRICS}
    for name, metric in METRICS.items():
        columns[name][0] = metric.of(first_run)
    for place, member in enumerate(members):
        for begin in range(0 if place else 1, draws, _BLOCK):
            end = min(begin + _BLOCK, draws)
            rows = _core.measure_draws(scenario, member, range(begin, end), threads)
            at = slice(place * draws + begin, place * draws + end)
            for name, column in columns.items():
                column[at] = _column(rows, name)
    return _Measured(first_run, columns, len(members), draws)


def _column(rows: Array, metric: str) -> Array:
    """Give one metric of what the core measures."""
    if metric == "diverged":
        return np.isfinite(rows[:, _core.FIGURES.index("diverged_at")]).astype(float)
    return rows[:, _core.FIGURES.index(metric)]
