"""Search for one cost within constraints."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nfopidn import _core
from nfopidn._core import Scenario
from nfopidn.search.bfoa import bfoa
from nfopidn.search.optimise import (
    CALLED_OFF,
    Array,
    Callback,
    OptimizeResult,
    Settings,
    active_mask,
    answering,
    deny_success,
)
from nfopidn.tuning.constraints import Judge, Limit
from nfopidn.tuning.parameters import ControllerSearch, Search
from nfopidn.tuning.plan import Plan
from nfopidn.tuning.result import TuneResult

#: The share of the evaluations, and of the time, of the first stage, which knows no constraints.
FIRST_SHARE = 0.5
#: What the search within constraints is told of a candidate that breaks some: this and the
#: violation, twice this if they are those of the runs. Costs stay below it.
BROKEN = 1000.0
_MOST_PLAIN = 500.0


def check_fit(settings: Settings) -> None:
    """Refuse a checkpoint, which holds the answers of one stage alone.

    Raises
    ------
    ValueError
        There is one.
    """
    if settings.checkpoint:
        raise ValueError("checkpoint must be None with constraints: the second stage has none")


def told(cost: Array) -> Array:
    """Give costs as the search is told them: above 500 squeezed under 1000, in their order."""
    above = np.maximum(cost, _MOST_PLAIN)
    return np.where(cost <= _MOST_PLAIN, cost, BROKEN - _MOST_PLAIN**2 / above)


class Ordered:
    """Deb's order of candidates as one number each, and the best that keeps to all constraints.

    What breaks no constraint is ordered by its cost, before all that does, which is ordered by its
    violation. The constraints of the loop take an analysis: only a candidate whose runs keep to
    theirs, and whose cost is under that of the best so far, is analysed. No other can be the
    answer.
    """

    def __init__(self, plan: Plan, search: Search, judge: Judge) -> None:
        self.search, self.judge = search, judge
        self.plan = plan
        self.best = np.inf
        self.point: Array | None = None
        self._space = search.space if isinstance(search, ControllerSearch) else None
        self._costs: _core.CostFunction | None = None
        if isinstance(search, ControllerSearch):
            self._costs = _core.CostFunction(plan.scenarios, search.space, *plan.mean, plan.threads)

    def points(self, unit: Array) -> Array:
        """Give points of the unit box as a search has them: (n, p)."""
        return np.asarray(_core.from_unit(self._space, self.search.low, self.search.high, unit))

    def unit(self, point: Array) -> Array:
        """Give the inverse of one point."""
        found = _core.to_unit(self._space, self.search.low, self.search.high, point)
        return np.clip(found, 0.0, 1.0)

    def costs(self, points: Array) -> Array:
        """Give the costs (n,) as the search without constraints has them."""
        if self._costs is not None:
            return self._costs.costs(points)
        rivals = [self.search.controller(x) for x in points]
        figures = _core.measure_runs(self.plan.scenarios, rivals, self.plan.threads, warns=False)
        share, caps = self.plan.mean
        every = np.ascontiguousarray(figures[:, :, _core.FIGURES.index("cost")])
        return _core.family_mean(every, share, caps)

    def __call__(self, columns: Array) -> Array:
        """Give the numbers (n,) of points (p, n) of the unit box."""
        points = self.points(np.ascontiguousarray(columns.T))
        costs = self.costs(points)
        controllers = [self.search.controller(x) for x in points]
        broken = self.judge.run_violation(controllers)
        result = np.where(broken > 0, 2 * BROKEN + broken, told(costs))
        for place in np.flatnonzero((broken == 0) & np.isfinite(costs)):
            if costs[place] >= self.best:
                continue
            violation = self.judge.loop_violation(controllers[place])
            if violation > 0:
                result[place] = BROKEN + violation
            else:
                self.best, self.point = float(costs[place]), points[place].copy()
        return result


def search_constrained(
    plan: Plan,
    limits: list[Limit],
    settings: Settings,
    callback: Callback | None,
    given: list[Scenario],
) -> TuneResult:
    """Search in two stages; tune() has the arguments and the rule."""
    judge = Judge(limits, given, plan.scenarios, plan.threads)
    first = replace(
        settings,
        maxfev=max(1, int(FIRST_SHARE * settings.maxfev)),
        maxtime=FIRST_SHARE * settings.maxtime,
        stopval=-np.inf,
    )
    result = plan.run(first, callback)
    search = plan.chosen or plan.search
    rest = settings.maxfev - int(result.nfev)
    if rest > 0 and result.success:
        ordered = Ordered(plan, search, judge)
        start = ordered.unit(result.x)
        left = settings.maxtime - result.elapsed
        found = bfoa(
            ordered,
            np.tile([0.0, 1.0], (len(start), 1)),
            method=settings.method,
            options=settings.options,
            rng=settings.seed,
            maxfev=rest,
            maxtime=None if np.isinf(left) else max(left, 1e-3),
            stopval=None if np.isinf(settings.stopval) else settings.stopval,
            callback=None if callback is None else _in_user_units(callback, ordered, result),
            x0=start,
            vectorized=True,
            progress=settings.progress,
        )
        _join(result, found, ordered, search)
    table = judge.table(result.controller)
    result["constraints"] = table
    complaint = judge.complaint(table)
    if complaint:
        deny_success(result, "constraints", f": {complaint}.")
    return result


def _in_user_units(callback: Callback, ordered: Ordered, before: TuneResult) -> Callback:
    """Make a callback that is told points and evaluations as those of the first stage are."""
    ask = answering(callback)

    def told_of(intermediate_result: OptimizeResult) -> object:
        seen = OptimizeResult(intermediate_result)
        seen["x"] = ordered.points(seen["x"][None, :])[0]
        seen["population"] = ordered.points(seen["population"])
        seen["nfev"] += before["nfev"]
        return ask(seen)

    return told_of


def _join(result: TuneResult, found: OptimizeResult, ordered: Ordered, search: Search) -> None:
    """Put what the second stage has found behind the first one's, in its place."""
    x = ordered.points(found.x[None, :])[0] if ordered.point is None else ordered.point
    history = found.history.copy()
    history["nfev"] += result.nfev
    result.update(
        x=x,
        fun=float(ordered.costs(x[None, :])[0]),
        controller=search.controller(x),
        population=ordered.points(found.population),
        population_energies=found.population_energies,
        active_mask=active_mask(x, search.low, search.high),
        history=np.concatenate([result.history, history]),
        nfev=int(result.nfev + found.nfev),
        nit=len(result.history) + len(history),
        elapsed=result.elapsed + found.elapsed,
        status=found.status,
        message=found.message,
        success=bool(found.status <= CALLED_OFF),
    )
