"""What many runs tell."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from os import PathLike, fspath
from pathlib import Path
from secrets import token_hex
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Controller, Rival, Scenario, simulate
from nfopidn.arguments import is_number, real_number, real_numbers, shown, suggestion, whole_number

if TYPE_CHECKING:
    from nfopidn.montecarlo.runs import Analysis

Array = NDArray[np.float64]
Limits = Mapping[str, float | tuple[float, float]]

_BLOCK = 2**15
_INTERVALS = {"wilson": "wilson", "clopper-pearson": "exact"}


@dataclass(frozen=True)
class Yield:
    """The share of runs within limits, and what it may be of all runs.

    Attributes
    ----------
    successes, n
        runs within the limits, and all
    low, high
        ends of the interval
    confidence
        of the interval
    interval
        "wilson" or "clopper-pearson"
    """

    successes: int
    n: int
    low: float
    high: float
    confidence: float
    interval: str

    @property
    def share(self) -> float:
        """Give successes / n."""
        return self.successes / self.n

    def __str__(self) -> str:
        return (
            f"{self.successes} of {self.n} runs within limits, {self.share:.6g}; "
            f"{self.confidence:g} {self.interval} interval [{self.low:.6g}, {self.high:.6g}]"
        )


@dataclass(frozen=True)
class Sensitivity:
    """Which parameter moves a metric: rank correlations, the strongest first.

    Attributes
    ----------
    metric
        what was correlated
    names
        of the parameters
    correlations
        (p,): Spearman's, in [-1, 1]; nan of a parameter or a metric that never changes
    standard_error
        of a correlation that is 0: 1/sqrt(n - 1)
    """

    metric: str
    names: tuple[str, ...]
    correlations: Array
    standard_error: float

    def __str__(self) -> str:
        width = max(len(name) for name in self.names)
        rows = zip(self.names, self.correlations, strict=True)
        return "\n".join(f"{name:{width}}  {value:+.3f}" for name, value in rows)


def _check_limits(limits: Any, known: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return the limits as pairs.

    Raises
    ------
    ValueError
        None, of a metric that was not kept, not finite numbers, or reversed.
    """
    if not isinstance(limits, Mapping) or not limits:
        raise ValueError(f"limits is {shown(limits)}; must be a mapping of at least one metric")
    result = {}
    for name, limit in limits.items():
        if name not in known:
            raise ValueError(
                f"limits has {name!r}{suggestion(name, known)}; known here: {', '.join(known)} "
                "(columns of monte_carlo() keep more)"
            )
        pair = (-np.inf, limit) if is_number(limit) else limit
        if not isinstance(pair, tuple | list) or len(pair) != 2 or not all(map(is_number, pair)):
            raise ValueError(
                f"limits[{name!r}] is {shown(limit)}; must be the highest value, or (low, high)"
            )
        if not pair[0] <= pair[1]:
            raise ValueError(f"limits[{name!r}] is {shown(limit)}; low must not be above high")
        result[name] = (float(pair[0]), float(pair[1]))
    return result


class MonteCarloResult:
    """n runs of one controller; what was drawn is made again from the seed when asked for.

    Attributes
    ----------
    costs
        (n,): E of eq. 41, of diverged runs included as it is
    metrics
        (n,) each: those asked for in `columns`, "cost" among them. Where a run diverges all but the
        cost are infinite: there is no whole run to measure.
    parameters
        (n,) each: what was drawn, by name; of a family "member" too, the scenario's place
    seed
        of all draws
    """

    def __init__(self, analysis: Analysis, rows: Array) -> None:
        self._analysis = analysis
        self._rows = rows

    @property
    def costs(self) -> Array:
        """(n,): E of eq. 41."""
        return self._rows[:, 0]

    @property
    def metrics(self) -> dict[str, Array]:
        """(n,) each: the cost, and what `columns` asked for."""
        names = ("cost", *self._analysis.columns)
        return {name: self._rows[:, place] for place, name in enumerate(names)}

    @property
    def parameters(self) -> dict[str, Array]:
        """(n,) each: what was drawn, made again."""
        names = self._analysis.draws.names
        result: dict[str, Array] = {name: np.empty(len(self)) for name in names}
        for first, values in self._blocks():
            for place, name in enumerate(names):
                result[name][first : first + len(values)] = values[:, place]
        if len(self._analysis.family) > 1:
            result["member"] = self._members(0, len(self))
        return result

    @property
    def seed(self) -> int:
        """The seed of all draws."""
        return self._analysis.draws.seed

    @property
    def controller(self) -> Controller | Rival:
        """The controller that ran."""
        return self._analysis.controller

    def __len__(self) -> int:
        """Give the number of runs."""
        return len(self._rows)

    def _blocks(self) -> Iterator[tuple[int, Array]]:
        for first in range(0, len(self), _BLOCK):
            yield first, self._analysis.draws.values(first, min(_BLOCK, len(self) - first))

    def _members(self, first: int, last: int) -> Array:
        runs = np.arange(first, last) % len(self._analysis.family)
        return runs.astype(np.float64)

    def replay(self, run: int) -> Scenario:
        """Give the scenario of a run.

        simulate(replay(i), controller).cost is costs[i], to the last bit: a scenario whose
        noise_source is "counter" runs in the arithmetic that the analysis has.

        Raises
        ------
        ValueError
            A number that no run has.
        """
        return self._analysis.scenario(whole_number("run", run, 0, len(self) - 1))

    def quantiles(self, shares: Any = (0.05, 0.5, 0.95), metric: str = "cost") -> Array:
        """Give what shares of the runs are at most at: (k,), as numpy.quantile.

        Raises
        ------
        ValueError
            A share out of [0, 1], or a metric that was not kept.
        """
        given = real_numbers("shares", shares)
        if not ((given >= 0) & (given <= 1)).all():
            raise ValueError(f"shares is {shown(shares)}; must be in [0, 1]")
        return np.asarray(np.quantile(self._metric(metric), given))

    def _metric(self, name: str) -> Array:
        metrics = self.metrics
        if name not in metrics:
            raise ValueError(
                f"metric is {shown(name)}{suggestion(name, metrics)}; known here: "
                f"{', '.join(metrics)} (columns of monte_carlo() keep more)"
            )
        return metrics[name]

    def within(self, limits: Limits) -> NDArray[np.bool_]:
        """Tell which runs are within limits, (n,).

        Parameters
        ----------
        limits
            by metric: the highest value, or (low, high)

        Raises
        ------
        ValueError
            Names the metric and what is wrong with its limit.
        """
        pairs = _check_limits(limits, tuple(self.metrics))
        good = np.ones(len(self), dtype=bool)
        for name, (low, high) in pairs.items():
            column = self._metric(name)
            good &= (column >= low) & (column <= high)
        return good

    def yield_(
        self, limits: Limits, *, confidence: float = 0.95, interval: str = "wilson"
    ) -> Yield:
        """Give the share of runs within limits, with its interval.

        The interval is that of independent draws; of Latin hypercube's and Sobol's points, which
        fill the space more evenly, it is on the safe side.

        Parameters
        ----------
        limits
            by metric: the highest value, or (low, high)
        confidence
            of the interval, in [0.5, 0.999999]
        interval
            "wilson", or "clopper-pearson", which is never too narrow

        Raises
        ------
        ValueError
            Names the argument, its value and what it must be.
        """
        from scipy.stats import binomtest

        real_number("confidence", confidence, 0.5, 0.999999)
        check_interval(interval)
        successes = int(self.within(limits).sum())
        ends = binomtest(successes, len(self)).proportion_ci(confidence, _INTERVALS[interval])
        return Yield(successes, len(self), float(ends.low), float(ends.high), confidence, interval)

    def worst(self, k: int = 10, metric: str = "cost") -> NDArray[np.intp]:
        """Give the numbers of the k runs with the highest metric, the worst first.

        Raises
        ------
        ValueError
            More than there are runs, or a metric that was not kept.
        """
        whole_number("k", k, 1, len(self))
        column = self._metric(metric)
        return np.argsort(-column, kind="stable")[:k]

    def sensitivity(self, metric: str = "cost", limits: Limits | None = None) -> Sensitivity:
        """Give the rank correlation of each parameter with a metric, or with failing limits.

        A parameter whose low and high values are both bad has a correlation near 0: the Sobol
        indices of nfopidn.montecarlo.sobol_indices() see it.

        Raises
        ------
        ValueError
            Nothing was drawn, or a metric that was not kept.
        """
        from scipy.stats import rankdata

        parameters = self.parameters
        if not parameters:
            raise ValueError("nothing was drawn; must have distributions")
        column = self._metric(metric) if limits is None else 1.0 - self.within(limits)
        ranks = rankdata(column)
        found = {name: _correlation(rankdata(one), ranks) for name, one in parameters.items()}
        order = sorted(found, key=lambda name: -abs(np.nan_to_num(found[name])))
        return Sensitivity(
            metric if limits is None else "failure",
            tuple(order),
            np.array([found[name] for name in order]),
            1 / np.sqrt(max(1, len(self) - 1)),
        )

    def position_errors(self, runs: int = 200) -> tuple[Array, Array]:
        """Replay the first runs: times (N,) [s], and distances from the reference (runs, N) [m].

        From where a run has diverged its distance is inf. nfopidn.plot.quantile_bands() draws
        them. Of fewer runs than asked for, all are replayed.

        Raises
        ------
        ValueError
            No such number, or a family whose paths have different samples.
        """
        whole_number("runs", runs, 1)
        times = [one.trajectory.t for one in self._analysis.family.scenarios]
        if any(not np.array_equal(t, times[0]) for t in times):
            raise ValueError("the family's paths have different samples; have no bands together")
        rows = np.full((min(runs, len(self)), len(times[0])), np.inf)
        for run, row in enumerate(rows):
            columns = simulate(self.replay(run), self.controller).columns
            row[: len(columns["e_x"])] = np.hypot(columns["e_x"], columns["e_y"])
        return np.array(times[0]), rows

    def to_columns(self) -> dict[str, Array]:
        """Give parameters and metrics by name, (n,) each."""
        return {**self.parameters, **self.metrics}

    def to_arrow(self) -> Any:
        """Give parameters and metrics as a pyarrow.Table. Needs pyarrow.

        Raises
        ------
        ImportError
            pyarrow is not installed.
        """
        return pyarrow_module().table(self.to_columns())

    def to_parquet(self, path: str | PathLike[str]) -> None:
        """Write parameters and metrics as a Parquet file, block by block. Needs pyarrow.

        Raises
        ------
        ImportError
            pyarrow is not installed.
        """
        arrow = pyarrow_module()
        from pyarrow import parquet

        members = len(self._analysis.family)
        names = self._analysis.draws.names
        draft = Path(f"{fspath(path)}.{token_hex(4)}.part")
        writer = None
        try:
            for first, values in self._blocks():
                last = first + len(values)
                columns: dict[str, Array] = {
                    name: values[:, place] for place, name in enumerate(names)
                }
                if members > 1:
                    columns["member"] = self._members(first, last)
                for name, column in self.metrics.items():
                    columns[name] = column[first:last]
                table = arrow.table(columns)
                writer = writer or parquet.ParquetWriter(draft, table.schema)
                writer.write_table(table)
            if writer is not None:
                writer.close()
            draft.replace(path)
        finally:
            draft.unlink(missing_ok=True)

    def __str__(self) -> str:
        shares = (0.05, 0.5, 0.95, 1.0)
        low, middle, high, most = self.quantiles(shares)
        drawn = ", ".join(self._analysis.draws.names) or "noise alone"
        return (
            f"{len(self)} runs, seed {self.seed}, drawn: {drawn}\n"
            f"cost: 5 % {low:.6g}, median {middle:.6g}, 95 % {high:.6g}, worst {most:.6g} "
            f"(run {self.worst(1)[0]})"
        )


def _correlation(a: Array, b: Array) -> float:
    a = a - a.mean()
    b = b - b.mean()
    scale = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / scale if scale > 0 else float("nan")


def check_interval(interval: str) -> None:
    """Refuse an interval of another name than those of yield_()."""
    if interval not in _INTERVALS:
        raise ValueError(
            f"interval is {shown(interval)}{suggestion(interval, _INTERVALS)}; must be one of "
            + ", ".join(_INTERVALS)
        )


def pyarrow_module() -> Any:
    """Give the module pyarrow.

    Raises
    ------
    ImportError
        It is not installed.
    """
    try:
        import pyarrow
    except ImportError:
        raise ImportError(
            "Arrow and Parquet need pyarrow: pip install nfopidn[arrow]; to_columns() needs nothing"
        ) from None
    return pyarrow
