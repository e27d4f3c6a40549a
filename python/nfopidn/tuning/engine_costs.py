"""Costs of candidates from an engine's workers, each of which has the core's cost function."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Scenario
from nfopidn.engines import Engine, Work
from nfopidn.search.interrupts import heeded_signals, user_code
from nfopidn.search.optimise import Array
from nfopidn.tuning.parameters import ControllerSearch, Mean, RivalSearch, Search

#: Points and their bounds (n,), or None: beyond its bound any cost of a point will do.
Candidates = tuple[Array, Array | None]


def core_costs(
    scenarios: list[Scenario], search: Search, mean: Mean, threads: int
) -> _core.CostFunction:
    """Make the core's cost function of a search's free parameters over scenarios."""
    if isinstance(search, ControllerSearch):
        return _core.CostFunction(scenarios, search.space, *mean, threads)
    assert isinstance(search, RivalSearch)
    dimension = len(search.names)
    return _core.CostFunction.of_rival(
        scenarios, search.base, search.source, search.fixed, dimension, *mean, threads
    )


class CandidateCosts:
    """What an engine's workers are given: it is pickled as what it is made of."""

    def __init__(self, scenarios: list[Scenario], search: Search, mean: Mean) -> None:
        self._made_of = scenarios, search, mean
        self._function: _core.CostFunction | None = None

    def __call__(self, candidates: Candidates) -> Array:
        """Give the costs (n,) of points (n, p)."""
        if self._function is None:
            self._function = core_costs(*self._made_of, threads=1)
        return self._function.costs(*candidates)

    def __reduce__(self) -> tuple[Any, ...]:
        return CandidateCosts, self._made_of


def on_engine(
    engine: Engine, costs: Callable[[str], CandidateCosts], stack: ExitStack
) -> Callable[[str, Array, Array | None], Array]:
    """Make the function that the core asks for costs of a stage, of its points and their bounds.

    Ctrl-C is heard at once in it: what the workers are at is of no use then.
    """
    stages: dict[str, Work] = {}

    def work_of(stage: str) -> Work:
        if stage not in stages:
            work = Work(engine, costs(stage), "the scenarios", "candidates")
            stages[stage] = stack.enter_context(work)
        return stages[stage]

    def evaluate(stage: str, points: Array, bounds: Array | None) -> Array:
        def cut(first: int, count: int) -> Candidates:
            own = slice(first, first + count)
            return points[own], None if bounds is None else bounds[own]

        result = np.full(len(points), np.nan)
        with heeded_signals() as requests, user_code(requests):
            for block in work_of(stage).blocks(len(points), cut):
                result[block.first : block.first + block.size] = block.answer
        return result

    return evaluate
