"""Who is ahead, and whether that is more than chance."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nfopidn.arithmetic import in_standard_arithmetic

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

    def is_tested(self) -> bool:
        """Whether there were runs enough to test anybody."""
        return any(p is not None for p in self.p)

    def level(self) -> list[str]:
        """Name the first and those that are not significantly behind."""
        return [
            name
            for name, p in zip(self.names, self.p, strict=True)
            if name == self.names[0] or p is None or p >= SIGNIFICANCE
        ]


def _holm(p: list[float]) -> list[float]:
    """Correct for the number of tests: the smallest counts most. SciPy does not have it."""
    found = np.array(p)
    order = np.argsort(found)
    found[order] = np.maximum.accumulate(found[order] * np.arange(len(p), 0, -1))
    return [float(value) for value in np.minimum(found, 1.0)]


def fewest_runs(controllers: int) -> int:
    """Give the runs with which the corrected test can reach SIGNIFICANCE at all."""
    runs = 1
    while 2.0 ** (1 - runs) * (controllers - 1) >= SIGNIFICANCE:
        runs += 1
    return runs


def _paired(
    costs: NDArray[np.float64], draws: NDArray[np.int64], pair: list[int]
) -> NDArray[np.float64]:
    """Give the two rows' costs, (2, runs): the same two runs count once, not as two draws."""
    _, first = np.unique(draws[pair], axis=1, return_index=True)
    return costs[pair][:, np.sort(first)]


@in_standard_arithmetic
def rank(
    names: list[str], costs: NDArray[np.float64], draws: NDArray[np.int64] | None = None
) -> Ranking:
    """Rank by the median of costs (controllers, runs); run i of all is one pair.

    `draws` has the shape of `costs` and tells which runs of a row are the same; None: none.
    """
    medians = np.median(costs, axis=1)
    order = [int(i) for i in np.argsort(medians, kind="stable")]
    ordered = tuple(names[i] for i in order)
    values = tuple(float(medians[i]) for i in order)
    if draws is None:
        draws = np.tile(np.arange(costs.shape[1]), (len(costs), 1))
    rest = {i: _paired(costs, draws, [i, order[0]]) for i in order[1:]}
    fewest = fewest_runs(len(names))
    tested = [i for i in rest if rest[i].shape[1] >= fewest]
    p: dict[int, float] = dict(zip(tested, _holm([_p_value(rest[i]) for i in tested]), strict=True))
    if not rest:
        reason = "nobody to compare with"
    elif len(tested) < len(rest):
        least = min(pair.shape[1] for pair in rest.values())
        reason = f"no test: {least} runs of a pair, at least {fewest} are needed"
    elif max(p.values()) < SIGNIFICANCE:
        reason = ""
    else:
        reason = "the first is not ahead of all others with p < 0.05"
    winner = None if reason else ordered[0]
    return Ranking(ordered, values, tuple(p.get(i) for i in order), winner, reason)


def _p_value(pair: NDArray[np.float64]) -> float:
    from scipy.stats import wilcoxon

    return 1.0 if np.array_equal(pair[0], pair[1]) else float(wilcoxon(pair[0], pair[1]).pvalue)
