"""Search over several objectives: a Pareto front by pymoo's NSGA-II on the native runs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import monotonic
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Scenario
from nfopidn.arguments import names_in, shown, suggestion, whole_number
from nfopidn.console import progress as progress_bar
from nfopidn.families.family import Family
from nfopidn.search.interrupts import heeded_signals, user_code
from nfopidn.search.optimise import (
    MESSAGES,
    Array,
    Callback,
    Settings,
    answering,
    ended_by,
)
from nfopidn.tuning.parameters import ControllerSearch, Mean, Search, Structure
from nfopidn.tuning.pareto_result import FRONT_HISTORY, ParetoResult
from nfopidn.tuning.plan import Plan
from nfopidn.tuning.result import TuneResult

#: What a search may be over: the costs as a search for one has them, and every metric of a run.
OBJECTIVES = ("cost", "worst", *(name for name in _core.metric_fields() if name != "cost"))
METHOD = "nsga2"
POPULATION = 100
MOST_OBJECTIVES = 6
#: The share of the evaluations of the search for cost alone, whose last population is a start.
START_SHARE = 0.2
#: How far beyond the worst values of the front the hypervolume's reference point is.
_BEYOND = 0.1
_SAVED = 8  # points of an interrupted search for cost that are measured
_EXACT_HYPERVOLUME = 4  # objectives; of more the exact one takes too long
_PLACES = {name: place for place, name in enumerate(_core.FIGURES)}


def check_objectives(objectives: Any, scenarios: Sequence[Scenario]) -> tuple[str, ...]:
    """Return the names of the objectives.

    Raises
    ------
    ValueError
        Fewer than two or more than six, a name that is none, with the nearest one, or twice, or
        "worst" of a single scenario.
    """
    names = names_in("objectives", objectives)
    for name in names:
        if name not in OBJECTIVES:
            hint = suggestion(name, OBJECTIVES)
            raise ValueError(f"objectives has {name!r}{hint}; known: {', '.join(OBJECTIVES)}")
        if names.count(name) > 1:
            raise ValueError(f"objectives has {name!r} twice")
    if not 2 <= len(names) <= MOST_OBJECTIVES:
        raise ValueError(
            f"objectives has {len(names)} names; must have 2 to {MOST_OBJECTIVES}: tune() without "
            "objectives searches for the least cost alone"
        )
    if "worst" in names and len(scenarios) == 1:
        raise ValueError(
            "objectives has 'worst', the cost of the worst scenario, but the search is over one "
            "scenario, whose cost it is: take 'cost', or search over several"
        )
    return tuple(names)


def check_fit(structure: Structure, settings: Settings) -> None:
    """Refuse what has no meaning in a search over several objectives.

    Raises
    ------
    ValueError
        structure="taps", which is tried with two laws, a stopval, or a checkpoint.
    """
    if isinstance(structure, str) and structure == "taps":
        raise ValueError(
            "structure 'taps' is tried with two values of lateral, which are no one front; with "
            'objectives give one: {"allocation": "decoupled", "lateral": "speed", "parameters": '
            '"taps"}'
        )
    if settings.stopval != -np.inf:
        raise ValueError("stopval is of one cost; must be None with objectives")
    if settings.checkpoint:
        raise ValueError("checkpoint is of a search for one cost; must be None with objectives")


def pymoo_parts() -> tuple[Any, ...]:
    """Give pymoo's NSGA2, Problem, StaticProblem and Evaluator, and the module moocore.

    Raises
    ------
    ImportError
        They are not installed.
    """
    try:
        import moocore
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.evaluator import Evaluator
        from pymoo.core.problem import Problem
        from pymoo.core.termination import NoTermination
        from pymoo.problems.static import StaticProblem
    except ImportError:
        raise ImportError(
            'objectives need pymoo and moocore: pip install "nfopidn[pareto]"'
        ) from None
    return NSGA2, Problem, StaticProblem, Evaluator, NoTermination, moocore


@dataclass
class Measured:
    """The objectives of candidates, and by how much their runs diverge."""

    scenarios: list[Scenario]
    search: Search
    names: tuple[str, ...]
    mean: Mean
    workers: int

    def points(self, unit: Array) -> Array:
        """Give points of the unit box as a search has them: (n, p)."""
        search = self.search
        space = search.space if isinstance(search, ControllerSearch) else None
        return np.asarray(_core.from_unit(space, search.low, search.high, unit))

    def unit(self, points: Array) -> Array:
        """Give the inverse of points()."""
        search = self.search
        space = search.space if isinstance(search, ControllerSearch) else None
        rows = [_core.to_unit(space, search.low, search.high, point) for point in points]
        return np.clip(np.array(rows).reshape(len(points), len(search.names)), 0.0, 1.0)

    def of(self, points: Array) -> tuple[Array, Array]:
        """Give objectives (n, m), and the share of samples behind a divergence (n,)."""
        controllers = [self.search.controller(x) for x in points]
        figures = _core.measure_runs(self.scenarios, controllers, self.workers, warns=False)
        ends = np.array([len(one.trajectory) * one.trajectory.dt for one in self.scenarios])
        lost = 1.0 - figures[:, :, _PLACES["diverged_at"]] / ends
        lost = np.where(np.isnan(lost), 0.0, np.maximum(lost, 1e-9)).mean(axis=1)
        columns = [self._objective(name, figures) for name in self.names]
        return np.column_stack(columns), lost

    def _objective(self, name: str, figures: Array) -> Array:
        share, caps = self.mean
        if name in ("cost", "worst"):
            costs = figures[:, :, _PLACES["cost"]]
            return np.asarray(_core.family_mean(costs, 0.0 if name == "worst" else share, caps))
        return np.asarray(_core.family_mean(figures[:, :, _PLACES[name]], share, []))


@dataclass
class Front:
    """All that was evaluated and is dominated by nothing, in the order of the first objective."""

    moocore: Any
    size: tuple[int, int]  # of points and of objectives
    x: Array = field(init=False)
    objectives: Array = field(init=False)

    def __post_init__(self) -> None:
        self.x, self.objectives = np.empty((0, self.size[0])), np.empty((0, self.size[1]))

    def add(self, x: Array, objectives: Array, lost: Array) -> None:
        """Take in candidates; those with a run that diverges are no part of a front."""
        good = (lost == 0) & np.isfinite(objectives).all(axis=1)
        rows = np.vstack([self.objectives, objectives[good]])
        points = np.vstack([self.x, x[good]])
        if len(rows) == 0:
            return
        kept = np.asarray(self.moocore.is_nondominated(rows, keep_weakly=False), dtype=bool)
        rows, points = rows[kept], points[kept]
        order = np.lexsort(rows.T[::-1])
        self.x, self.objectives = points[order], rows[order]


class FrontSearch:
    """One search: the start, the generations, the result."""

    def __init__(self, plan: Plan, names: tuple[str, ...], settings: Settings, population: int):
        self.nsga2, self.problem, self.static, self.evaluator, self.endless, moocore = pymoo_parts()
        self.moocore = moocore
        self.plan = plan
        self.settings = settings
        self.population = population
        self.measured = Measured(plan.scenarios, plan.search, names, plan.mean, plan.threads)
        self.front = Front(moocore, (len(plan.search.names), len(names)))
        self.nfev = 0
        self.rows: list[tuple[int, Array]] = []  # evaluations and front, a generation each
        self.known = np.empty((0, len(plan.search.names)))  # what the search for cost has found
        self.began = monotonic()

    def run(self, callback: Callback | None) -> ParetoResult:
        """Search; Ctrl-C gives the front so far."""
        reason = "interrupted"
        settings = self.settings
        try:
            with (
                heeded_signals() as requests,
                progress_bar("pareto", settings.maxfev, settings.progress) as report,
                _core.StopIf(requests.is_asked),
            ):
                if callback is None:
                    ends = lambda: requests.asked  # noqa: E731
                else:
                    ends = lambda: requests.asked or self._asked(callback, requests)  # noqa: E731
                reason = self._generations(self._start(), report, ends)
                if requests.asked:
                    reason = "interrupted"
        except KeyboardInterrupt:
            if not self.rows and len(self.known):  # in the search for cost, or just after it
                self._take(self.known[:_SAVED])
            if not self.rows:
                raise
        return self.result(reason)

    def _take(self, points: Array) -> tuple[Array, Array]:
        """Measure points and take them in, as a generation; gives objectives and what is lost."""
        objectives, lost = self.measured.of(points)
        self.nfev += len(points)
        self.front.add(points, objectives, lost)
        self.rows.append((self.nfev, self.front.objectives))
        return objectives, lost

    def _asked(self, callback: Callback, requests: Any) -> bool:
        """Whether the callback asks for an end."""
        try:
            with user_code(requests):
                return bool(answering(callback)(self.result("callback")))
        except StopIteration:
            return True

    def _start(self) -> Array:
        """Give the first population, in the unit box: half of it from a search for cost alone."""
        from scipy.stats import qmc

        settings, names = self.settings, self.plan.search.names
        share = replace(
            settings,
            maxfev=max(1, int(START_SHARE * settings.maxfev)),
            maxtime=START_SHARE * settings.maxtime,
            progress=False,
        )
        found: TuneResult = self.plan.run(share, None)
        self.nfev = int(found.nfev)
        rows = found.x[None, :]
        if found.population.shape[1] == len(names):
            order = np.argsort(found.population_energies, kind="stable")
            rows = np.vstack([rows, found.population[order]])
        self.known = rows[: max(1, self.population // 2)]
        known = self.measured.unit(self.known)
        rest = self.population - len(known)
        anywhere = qmc.LatinHypercube(len(names), rng=np.random.default_rng(settings.seed))
        return np.vstack([known, anywhere.random(rest)])

    def _generations(self, first: Array, report: Any, ends: Any) -> str:
        """Run generation after generation; returns why it ended."""
        count, settings = len(self.measured.names), self.settings
        problem = self.problem(n_var=first.shape[1], n_obj=count, n_ieq_constr=1, xl=0.0, xu=1.0)
        algorithm = self.nsga2(pop_size=self.population, sampling=first)
        algorithm.setup(problem, seed=settings.seed, termination=self.endless())
        while True:
            asked = algorithm.ask()
            unit = np.asarray(asked.get("X"), dtype=float)
            if self.nfev + len(unit) > settings.maxfev and self.rows:
                return "evaluations"
            objectives, lost = self._take(self.measured.points(unit))
            given = self.static(problem, F=objectives, G=lost[:, None])
            self.evaluator().eval(given, asked)
            algorithm.tell(infills=asked)
            report(self.nfev, f"{self.nfev} evaluations, {len(self.front.x)} on the front")
            if monotonic() - self.began > settings.maxtime:
                return "time"
            if ends():
                return "callback"

    def result(self, reason: str) -> ParetoResult:
        """Make the result of what is there."""
        search, settings = self.plan.search, self.settings
        rows = self.front.objectives
        history = np.zeros(len(self.rows), dtype=[(name, float) for name in FRONT_HISTORY])
        reference = np.full(rows.shape[1], np.inf)
        if len(rows):
            low, high = rows.min(axis=0), rows.max(axis=0)
            width = np.where(high > low, high - low, 1.0)
            reference = high + _BEYOND * width
            for place, (nfev, front) in enumerate(self.rows):
                volume = self._hypervolume((front - low) / (reference - low))
                history[place] = (nfev, len(front), volume)
        structure = "paper" if self.plan.structure is None else self.plan.structure
        result = ParetoResult(
            objective_names=self.measured.names,
            objectives=rows.copy(),
            controllers=[search.controller(x) for x in self.front.x],
            x=self.front.x.copy(),
            parameters=search.names,
            bounds=np.column_stack([search.low, search.high]),
            history=history,
            reference_point=reference,
            seed=settings.seed,
            structure=structure,
            options=settings.options,
            method=METHOD,
            population=self.population,
            scenario=_one_or_all(self.plan.scenarios),
            nfev=self.nfev,
            nit=len(self.rows),
            elapsed=monotonic() - self.began,
        )
        result.update(ended_by(reason))
        if len(rows) == 0:
            text = "Every controller that was tried has a run that diverges. " + MESSAGES[reason]
            result.update(success=False, message=text)
        return result

    def _hypervolume(self, front: Array) -> float:
        """Give the share of the unit box that a front dominates."""
        inside = front[(front < 1).all(axis=1)]
        if len(inside) == 0:
            return 0.0
        reference = np.ones(front.shape[1])
        if front.shape[1] <= _EXACT_HYPERVOLUME:
            return float(self.moocore.hypervolume(inside, ref=reference))
        return float(self.moocore.hv_approx(inside, ref=reference))


def _one_or_all(scenarios: list[Scenario]) -> Scenario | list[Scenario]:
    return scenarios[0] if len(scenarios) == 1 else scenarios


def search_front(
    plan: Plan,
    objectives: Any,
    settings: Settings,
    callback: Callback | None,
    population: Any,
    given: list[Scenario],
    family: Family | None,
) -> ParetoResult:
    """Search over several objectives, on the scenarios of a plan; tune() has the arguments."""
    names = check_objectives(objectives, plan.scenarios)
    check_fit(plan.structure, settings)
    whole_number("population", population, 8, 10_000)
    if settings.maxfev < 2 * population:
        raise ValueError(
            f"maxfev is {shown(settings.maxfev)}; must be at least twice the population, "
            f"{2 * population}"
        )
    result = FrontSearch(plan, names, settings, int(population)).run(callback)
    result["scenario"] = _one_or_all(given)
    if family is not None:
        result["family"] = family
    return result
