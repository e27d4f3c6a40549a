"""Who is ahead, and whether that is more than chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

#: A difference counts when chance alone gives one as large less often than this.
SIGNIFICANCE = 0.05


@dataclass(frozen=True)
class Ranking:
    """An order by median cost, best first, and what is known of it.

    p holds for each the probability, corrected by Holm's method, that chance alone would set it as
    far behind the first: Wilcoxon's signed-rank test of the paired runs; None without a test. The
    first is the winner if all others are behind with p < 0.05; else there is none.
    """

    names: tuple[str, ...]
    medians: tuple[float, ...]
    p: tuple[float | None, ...]
    winner: str | None
    reason: str

    def level(self) -> list[str]:
        """Name the first and those that are not significantly behind."""
        return [
            name
            for name, p in zip(self.names, self.p, strict=True)
            if name == self.names[0] or p is None or p >= SIGNIFICANCE
        ]


def _holm(p: list[float]) -> list[float]:
    """Correct for the number of tests: the smallest counts most."""
    order = np.argsort(p)
    corrected = np.empty(len(p))
    worst = 0.0
    for place, index in enumerate(order):
        worst = max(worst, min(1.0, p[index] * (len(p) - place)))
        corrected[index] = worst
    return [float(value) for value in corrected]


def fewest_runs(controllers: int) -> int:
    """Give the runs with which the corrected test can reach SIGNIFICANCE at all."""
    runs = 1
    while 2.0 ** (1 - runs) * (controllers - 1) >= SIGNIFICANCE:
        runs += 1
    return runs


def rank(names: list[str], costs: NDArray[np.float64]) -> Ranking:
    """Rank by the median of costs (controllers, runs); run i of all is one pair.

    Raises
    ------
    ImportError
        If SciPy is not installed and there are runs enough for a test.
    """
    medians = np.median(costs, axis=1)
    order = [int(i) for i in np.argsort(medians, kind="stable")]
    ordered = tuple(names[i] for i in order)
    values = tuple(float(medians[i]) for i in order)
    none: tuple[float | None, ...] = (None,) * len(names)
    if len(names) == 1:
        return Ranking(ordered, values, none, None, "nobody to compare with")
    if costs.shape[1] < fewest_runs(len(names)):
        reason = f"no test: {costs.shape[1]} runs, at least {fewest_runs(len(names))} are needed"
        return Ranking(ordered, values, none, None, reason)
    try:
        from scipy.stats import wilcoxon
    except ImportError:
        raise ImportError("ranking needs SciPy: pip install 'nfopidn[compare]'") from None
    best = costs[order[0]]
    raw = []
    for i in order[1:]:
        same = np.array_equal(costs[i], best)
        raw.append(1.0 if same else float(wilcoxon(costs[i], best).pvalue))
    p = (None, *_holm(raw))
    won = max(value for value in p[1:] if value is not None) < SIGNIFICANCE
    reason = "" if won else "the first is not ahead of all others with p < 0.05"
    return Ranking(ordered, values, p, ordered[0] if won else None, reason)
