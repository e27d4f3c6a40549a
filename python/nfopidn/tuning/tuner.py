"""Tuning of controllers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import Any, overload

from numpy.typing import ArrayLike

from nfopidn._core import Controller, Rival, Scenario, simulate
from nfopidn.arguments import shown
from nfopidn.engines import read_workers
from nfopidn.families.family import Family
from nfopidn.robustness.reference_limits import warn_of_reference_torques
from nfopidn.search.optimise import Callback, check_settings, deny_success, returned
from nfopidn.tuning.constrained import check_fit, search_constrained
from nfopidn.tuning.constraints import check_constraints
from nfopidn.tuning.objective import check_share, cost_caps, scenarios_of
from nfopidn.tuning.parameters import Search, make_search
from nfopidn.tuning.pareto import POPULATION, search_front
from nfopidn.tuning.pareto_result import ParetoResult
from nfopidn.tuning.plan import Plan
from nfopidn.tuning.result import TuneResult, scenario_list
from nfopidn.tuning.robust import check_robustness, diverging, hopeless, standard_family

Scenarios = Scenario | Family | Sequence[Scenario] | None


@overload
def tune(
    scenario: Scenarios = None, *, objectives: Sequence[str], **settings: Any
) -> ParetoResult: ...
@overload
def tune(scenario: Scenarios = None, *, objectives: None = None, **settings: Any) -> TuneResult: ...
def tune(  # type: ignore[misc]  # the overloads leave the other arguments to this
    scenario: Scenarios = None,
    *,
    structure: str | Mapping[str, Any] | None = None,
    bounds: Mapping[str, tuple[float, float]] | ArrayLike | None = None,
    method: str = "bfoa+",
    options: Mapping[str, Any] | None = None,
    rng: Any = None,
    maxfev: int | None = None,
    maxtime: float | None = None,
    stopval: float | None = None,
    callback: Callback | None = None,
    workers: Any = 1,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
    frozen: Mapping[str, float] | None = None,
    tied: Mapping[str, str] | None = None,
    start: Controller | Rival | None = None,
    worst_share: float = 1.0,
    robustness: str | None = "standard",
    cost_cap: float | str | None = "auto",
    objectives: Sequence[str] | None = None,
    population: int = POPULATION,
    constraints: Mapping[str, tuple[float | None, float | None]] | None = None,
) -> TuneResult | ParetoResult:
    """Find the parameters of least cost (eq. 41) over a scenario's variations, or as it is.

    With `objectives` it finds a Pareto front: controllers of which none is better than another in
    every objective.

    Parameters
    ----------
    scenario
        A Scenario, a list of them, or a Family, which is searched as it is; None: the published
        one.
    structure
        "tracking" (default; of a nominal search "paper"), "decoupled", "incremental", "extended"
        (an order pair a channel), "taps" (decoupled, with the filters' taps themselves as
        parameters; the lateral channel is tried with `lateral` "speed" and with "direction", and
        the better one is the result), or settings of Controller, to which `parameters`
        "shared-orders" (default), "orders-by-channel" or "taps" may be added.
        Or a rival: one of Rival.laws(), or {"law": ..., "speeds": ...}, settings of Rival; its
        model of the robot is that of the first scenario. `controller` is a Rival then.
    bounds
        By name, such as {"ki_x": (0, 0.3)}, the others by default_bounds(); or (p, 2) for all
        free parameters.
    method, options, rng, maxfev, maxtime, stopval, callback, checkpoint, progress
        As for bfoa(). A gradient counts as 1 + p evaluations. With `rng=None` a seed is drawn, and
        `TuneResult.seed` records it; the commands draw none, they use 0.
    workers
        Threads, -1 for as many as there are processors; or an Executor as of concurrent.futures, a
        dask.distributed.Client or a function like map, whose workers give the candidates' costs.
        The result is the same with each; docs/scaling.md tells when which is of use.
    frozen
        Parameters that keep a value, by name.
    tied
        Parameters that equal another one: {"kp_y": "kp_x"}.
    start
        A controller to start from, within the bounds: its gains and orders, or its taps; other
        settings are the structure's. Without one, a search for free taps spends
        three tenths of the evaluations and of the time on gains and orders first. Stages before the
        last have checkpoints of their own, with the suffixes .gains and .speed; a callback is told
        the evaluations of all, the point and the cost of the present one.
    worst_share
        With several scenarios, the cost is the mean over the worst share of them: 1 is the mean
        over all scenarios, 0 is the worst one.
    robustness
        "standard": over the standard variations of each scenario (Scenario.variations()), with the
        accurate integrator, and four of them with the scenario's own where that is another. None:
        a nominal search, over the scenarios as they are; what it finds may have no margin at all.
    cost_cap
        A scenario's cost E beyond the cap c counts as c (1 + ln(E / c)), so that one run that
        diverges does not outweigh all others: a positive number; "friction", 1 or ten times what
        friction alone costs; None, no cap; "auto", "friction" in a robust search, else None.
    objectives
        2 to 6 of "cost", "worst" (the cost of the worst scenario) and the names of
        SimulationResult.metrics, each to be least. Over several scenarios a metric is the mean over
        the worst share of them, as the cost is. pymoo's NSGA-II searches, with its default
        operators, in the box as the other searches see it; a controller of which a run diverges is
        worse than every other. A fifth of the evaluations and of the time goes into a search for
        the cost by `method` and `options`, from `start` if there is one, whose cells are half of
        the first population; the rest of it is a Latin hypercube. Of all that was evaluated the
        front is what nothing dominates. Needs the extra `pareto`; stopval, checkpoint and
        structure="taps" are refused.
    population
        Points of a generation of a search over objectives, [8, 1e4]; maxfev must be twice as many.
    constraints
        By name (low, high), either of which may be None: metrics of SimulationResult.metrics and
        "settling_time", on each of the scenarios that were given; "diverged", the number of
        scenarios searched on which the run diverges; and as the verdict has them "gain_margin"
        [dB], "phase_margin" [rad], "delay_margin" and "delay_bearable" [samples]. Half of the
        evaluations and of the time are a search without them. The other half goes on from what it
        has found, by the same method without gradients, in Deb's order: what keeps to all
        constraints comes first, by its cost, then what breaks margins or delay, then what breaks
        metrics, each by how far it is beyond, as a share of the limit. Margins and delay are
        analysed only of candidates that keep to the metrics and cost less than the best so far: no
        other can be the answer. `constraints` of the result has the value and the limits of each;
        `success` is False where one is not met. checkpoint must be None.

    Returns
    -------
    TuneResult
        With `objectives` a ParetoResult. Ctrl-C ends the search and returns the best so far.
        `success` is False after that, and where the best controller's run diverges: the message
        then tells when, and what may help.
        `scenario` is what was given, `family` what a robust search was over, and `verdict` says
        whether the controller may be trusted.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    ImportError
        `objectives` without pymoo.
    EngineError
        The workers keep dying, or were closed meanwhile; its attribute `best`
        is the result so far, and a checkpoint has the same.

    Warns
    -----
    UserWarning
        Of a scenario whose reference torques are beyond its torque limit, with what helps.
    """

    def found() -> TuneResult | ParetoResult:
        check_robustness(robustness)
        given = scenarios_of(scenario)
        family = scenario if isinstance(scenario, Family) else None
        searched, cap = structure, cost_cap
        if robustness is not None:
            searched = "tracking" if structure is None else structure
            family = family or standard_family(given)
        if isinstance(cap, str) and cap == "auto":
            cap = None if robustness is None else "friction"
        scenarios = given if family is None else list(family)
        search = make_search(searched, bounds, frozen, tied, scenarios)
        plan = Plan.of(search, searched, start, scenarios)
        settings = check_settings(
            *(method, options, rng, maxfev, maxtime, stopval, checkpoint, progress, callback),
            stages=plan.suffixes(),
        )
        crew = read_workers(workers)
        check_share(worst_share)
        plan.mean = (float(worst_share), cost_caps(cap, scenarios))
        plan.workers = crew
        if not isinstance(crew, int) and not (objectives is None and constraints is None):
            raise ValueError(
                f"workers is {shown(workers)}; with objectives or constraints must be a number of "
                "threads, as those are searched for in this process"
            )
        plan.check_checkpoints(settings)
        plan.check_start()
        warn_of_reference_torques("tune", given, above=3)
        if objectives is not None:
            if constraints is not None:
                raise ValueError("constraints is of one cost; must be None with objectives")
            return search_front(
                *(plan, objectives, settings, callback, population, given, family),
            )
        if constraints is None:
            result = plan.run(settings, callback)
        else:
            limits = check_constraints(constraints)
            check_fit(settings)
            result = search_constrained(plan, limits, settings, callback, given)
        if family is None:
            divergence = _divergence(result, worst_share, capped=cap is not None)
        else:
            result.update(scenario=given[0] if len(given) == 1 else given, family=family)
            divergence = _family_divergence(result, family, search)
        if divergence is not None:
            deny_success(result, "diverged", divergence)
        return result

    return returned(found)


def _family_divergence(result: TuneResult, family: Family, search: Search) -> str | None:
    """Name the members of a family whose run under the best controller diverges."""
    lost = diverging(family, result.controller)
    if not lost:
        return None
    first, at = next(iter(lost.items()))
    text = f" on {first!r} at {at:.6g} s."
    if len(lost) > 1:
        text = f" on {len(lost)} of {len(family)} scenarios, on {first!r} at {at:.6g} s."
    if result.population.shape[1] == len(search.names):  # else the stage was for other parameters
        everywhere = hopeless(family, list(lost), search, result.population)
        if everywhere:
            names = ", ".join(map(repr, everywhere))
            text += f" Every controller of the last population diverges on {names}."
    return text + _start_advice(family[first])


def _divergence(result: TuneResult, worst_share: float, *, capped: bool) -> str | None:
    """Tell when the best controller's run diverges, and what may be why; None if it does not."""
    scenarios = scenario_list(result.scenario)
    most = result.fun * max(worst_share * len(scenarios), 1.0)  # that one scenario may cost
    for place, scenario in enumerate(scenarios):
        path = scenario.trajectory
        # A sample that is missing counts as a position error of the distance of divergence.
        missing = scenario.cost_weights[0] * scenario.divergence_distance**2
        if not capped and most * len(path) < 0.99 * missing:
            continue
        at = simulate(scenario, result.controller).diverged_at
        if at is None:
            continue
        where = f" on scenario {place}" if len(scenarios) > 1 else ""
        return f"{where} at {at:.6g} s." + _start_advice(scenario)
    return None


def _start_advice(scenario: Scenario) -> str:
    """Tell what may be why a run diverges: a start from rest where the reference moves."""
    path = scenario.trajectory
    rests = scenario.initial_velocity == (0.0, 0.0)
    if not rests or (path.v[0] == 0 and path.omega[0] == 0):
        return ""
    return (
        f" The robot starts from rest where the reference moves at {path.v[0]:.3g} m/s and "
        f'{path.omega[0]:.3g} rad/s: initial_velocity="reference" starts it with these.'
    )
