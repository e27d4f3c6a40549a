"""Sobol indices: which share of a metric's variance each parameter makes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Controller, Rival, Scenario
from nfopidn.arguments import shown, whole_number
from nfopidn.engines import read_threads
from nfopidn.families.runs import family_of
from nfopidn.montecarlo.distributions import Distribution
from nfopidn.montecarlo.draws import Draws
from nfopidn.montecarlo.runs import Analysis, check_columns, seed_of

Array = NDArray[np.float64]


@dataclass(frozen=True)
class SobolIndices:
    """Shares of a metric's variance.

    Attributes
    ----------
    names
        (p,): of the parameters
    first_order
        (p,): the share that each makes alone
    total_order
        (p,): the share that goes with it, its interactions included
    runs
        how many were made
    """

    names: tuple[str, ...]
    first_order: Array
    total_order: Array
    runs: int

    def __str__(self) -> str:
        width = max(len(name) for name in self.names)
        rows = zip(self.names, self.first_order, self.total_order, strict=True)
        lines = [f"{name:{width}}  {alone:6.3f}  {total:6.3f}" for name, alone, total in rows]
        return "\n".join([f"{'':{width}}  {'alone':>6}  {'total':>6}", *lines])


def sobol_indices(
    scenario: Scenario,
    controller: Controller | Rival,
    n: int = 1024,
    *,
    rng: Any = None,
    distributions: Mapping[str, Distribution],
    metric: str = "cost",
    workers: int = 1,
) -> SobolIndices:
    """Give the Sobol indices of a metric, by runs of their own: n (p + 2) of them.

    scipy.stats.sobol_indices does it, by Saltelli's method. All runs have the same noise, so that
    the indices are of the parameters alone.

    Parameters
    ----------
    scenario, controller, distributions
        as in monte_carlo()
    n
        a power of 2
    rng
        a seed, a numpy.random.Generator, or None
    metric
        a name of SimulationResult.metrics
    workers
        threads; -1: as many as there are processors

    Raises
    ------
    ValueError
        Names the argument, its value and what it must be.
    """
    whole_number("n", n, 2)
    draws = Draws(distributions, n=n, seed=seed_of(rng), method="sobol", covariance=None)
    if not isinstance(scenario, Scenario):
        raise ValueError(f"scenario is {shown(scenario)}; must be a Scenario")
    if not isinstance(controller, Controller | Rival):
        raise ValueError(f"controller is {shown(controller)}; must be a Controller or a Rival")
    kept = check_columns([metric])
    analysis = Analysis(family_of(scenario), controller, draws, kept)
    threads = read_threads(workers)
    made = 0

    def measure(points: Array) -> Array:
        nonlocal made
        made += points.shape[1]
        values = np.ascontiguousarray(points.T)
        draws.check(values)
        return np.asarray(analysis.measure(values, draws.first_seed, 0, threads)[:, -1])

    from scipy import stats

    found = stats.sobol_indices(
        func=measure,
        n=n,
        dists=[_Frozen(draws.distributions[name]) for name in draws.names],
        rng=np.random.default_rng(draws.seed),
    )
    return SobolIndices(
        tuple(draws.names),
        np.asarray(found.first_order, dtype=float).ravel(),
        np.asarray(found.total_order, dtype=float).ravel(),
        made,
    )


class _Frozen:
    """A distribution as scipy.stats.sobol_indices asks for it."""

    def __init__(self, one: Distribution) -> None:
        self._one = one

    def ppf(self, q: Array) -> Array:
        """Give the quantiles of shares, of which SciPy's points hold 0 too."""
        return np.asarray(self._one.ppf(np.clip(q, 2.0**-54, 1 - 2.0**-53)))
