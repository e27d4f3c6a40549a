"""Tuning of controllers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario, simulate
from nfopidn.families.family import Family
from nfopidn.robustness.reference_limits import warn_of_reference_torques
from nfopidn.search.optimise import (
    DEFAULT_EVALUATIONS,
    FIRST_STAGE,
    LATERAL_STAGES,
    MESSAGES,
    METHODS,
    UNLIMITED,
    Array,
    Callback,
    OptimizeResult,
    Settings,
    active_mask,
    answering,
    check_settings,
    deny_success,
    ended_by,
    finish,
    nothing_found,
    problem_in,
    returned,
    run,
)
from nfopidn.tuning.objective import check_share, cost_caps, cost_function, scenarios_of
from nfopidn.tuning.parameters import (
    ControllerSearch,
    Mean,
    Search,
    controller_structure,
    make_search,
)
from nfopidn.tuning.result import TuneResult, scenario_list
from nfopidn.tuning.robust import check_robustness, diverging, hopeless, standard_family

_NO_TIME = 1e-9  # [s]
#: Up to this status a search has come to its end or its time is up; beyond, it was told to end.
OUT_OF_TIME = list(MESSAGES).index("time")


def tune(
    scenario: Scenario | Family | Sequence[Scenario] | None = None,
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
    workers: int = 1,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
    frozen: Mapping[str, float] | None = None,
    tied: Mapping[str, str] | None = None,
    start: Controller | Rival | None = None,
    worst_share: float = 1.0,
    robustness: str | None = "standard",
    cost_cap: float | str | None = "auto",
) -> TuneResult:
    """Find the parameters of least cost (eq. 41) over a scenario's variations, or as it is.

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
        Threads. The result does not depend on their number.
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
        accurate integrator. None: a nominal search, over the scenarios as they are; what it finds
        may have no margin at all.
    cost_cap
        A scenario's cost E beyond the cap c counts as c (1 + ln(E / c)), so that one run that
        diverges does not outweigh all others: a positive number; "friction", 1 or ten times what
        friction alone costs; None, no cap; "auto", "friction" in a robust search, else None.

    Returns
    -------
    TuneResult
        Ctrl-C ends the search and returns the best so far. `success` is False after that, and where
        the best controller's run diverges: the message then tells when, and what may help.
        `scenario` is what was given, `family` what a robust search was over, and `verdict` says
        whether the controller may be trusted.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.

    Warns
    -----
    UserWarning
        Of a scenario whose reference torques are beyond its torque limit, with what helps.
    """
    check_robustness(robustness)
    given = scenarios_of(scenario)
    family: Family | None = scenario if isinstance(scenario, Family) else None
    if robustness is not None:
        structure = "tracking" if structure is None else structure
        family = family or standard_family(given)
    if isinstance(cost_cap, str) and cost_cap == "auto":
        cost_cap = None if robustness is None else "friction"
    search = partial(
        _tune,
        given if family is None else list(family),
        structure=structure,
        bounds=bounds,
        method=method,
        options=options,
        rng=rng,
        maxfev=maxfev,
        maxtime=maxtime,
        stopval=stopval,
        callback=callback,
        workers=workers,
        checkpoint=checkpoint,
        progress=progress,
        frozen=frozen,
        tied=tied,
        start=start,
        worst_share=worst_share,
        cost_cap=cost_cap,
    )

    def found() -> TuneResult:
        warn_of_reference_torques("tune", given, above=3)
        result = search()
        if family is None:
            divergence = _divergence(result, worst_share, capped=cost_cap is not None)
        else:
            result.update(scenario=given[0] if len(given) == 1 else given, family=family)
            space = make_search(structure, bounds, frozen, tied, list(family))
            divergence = _family_divergence(result, family, space)
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


def _tune(
    scenario: Scenario | Sequence[Scenario] | None,
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
    workers: int = 1,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
    frozen: Mapping[str, float] | None = None,
    tied: Mapping[str, str] | None = None,
    start: Controller | Rival | None = None,
    worst_share: float = 1.0,
    cost_cap: float | str | None = None,
) -> TuneResult:
    """Search as tune() does; also a stage of such a search, which may end without a finite cost."""
    scenarios = scenarios_of(scenario)
    search = make_search(structure, bounds, frozen, tied, scenarios)
    stages = _stages(structure, search, start, {"bounds": bounds, "frozen": frozen, "tied": tied})
    settings = check_settings(
        *(method, options, rng, maxfev, maxtime, stopval, checkpoint, progress, callback),
        stages=list(stages),
    )
    check_share(worst_share, workers)
    mean = (float(worst_share), cost_caps(cost_cap, scenarios))
    _check_checkpoints(settings, scenarios, mean, stages)
    first = None if start is None else search.start(start)
    if first is not None:
        _check_start(search, start, first)
    if structure == "taps" and isinstance(search, ControllerSearch):
        shared = {
            **{"bounds": bounds, "frozen": frozen, "tied": tied, "method": method},
            **{"options": options, "callback": callback, "progress": progress},
            **{"workers": workers, "worst_share": worst_share, "cost_cap": cost_cap},
        }
        return _either_lateral(scenarios, search, settings, start, shared)
    before: TuneResult | None = None
    if start is None and isinstance(search, ControllerSearch) and search.parameters == "taps":
        limits = {"workers": workers, "worst_share": worst_share, "cost_cap": cost_cap}
        before = _first_gains(scenarios, search, structure, settings, callback, limits)
        first = before.x
        over = before.nfev >= settings.maxfev or before.elapsed >= settings.maxtime
        if before.status > OUT_OF_TIME or over:
            return _best_of([before], structure, settings)
    problem = _problem(scenarios, search, mean)
    problem["start"] = None if first is None else first.tolist()
    request = settings.request(search.low, search.high, problem)
    if before is not None:
        request["maxfev"] -= before.nfev
        request["maxtime"] = max(request["maxtime"] - before.elapsed, _NO_TIME)
    request["start"] = first
    reply, raised = run(
        lambda request: search.run(scenarios, mean, int(workers), request),
        request,
        settings,
        _counting_on(callback, 0 if before is None else before.nfev),
        "tune",
    )
    if reply["nfev"] == 0:
        if before is None or (raised is not None and not isinstance(raised, KeyboardInterrupt)):
            raise raised or nothing_found(reply)
        before.update(ended_by("time" if reply["reason"] == "time" else "interrupted"))
        return _best_of([before], structure, settings)
    result = TuneResult(
        seed=settings.seed,
        structure="paper" if structure is None else structure,
        options=settings.options,
        method=method,
        parameters=search.names,
        scenario=scenarios[0] if len(scenarios) == 1 else scenarios,
        controller=search.controller(reply["x"]),
    )
    if before is None:
        finish(result, reply, raised, (search.low, search.high))
        return result
    try:
        finish(result, reply, raised, (search.low, search.high))
    except BaseException as error:
        error.best = _best_of([before, result], structure, settings)  # type: ignore[attr-defined]
        raise
    return _best_of([before, result], structure, settings)


def _problem(scenarios: list[Scenario], search: Search, mean: Mean) -> dict[str, Any]:
    """Describe a search, but for its start, for a checkpoint."""
    worst_share, caps = mean
    return {
        "kind": "tune",
        "scenario": [json.loads(one.to_json()) for one in scenarios],
        **search.problem(),
        "source": search.source,
        "fixed": search.fixed,
        "worst_share": worst_share,
        # A checkpoint from before costs had caps is still the same.
        **({"caps": caps} if caps else {}),
    }


def _for_gains(chosen: Mapping[str, Any]) -> dict[str, Any]:
    """Give the structure of the search that a search for free taps starts with."""
    return {**chosen, "parameters": "orders-by-channel"}


def _for_taps(chosen: Mapping[str, Any], lateral: str) -> dict[str, Any]:
    return {**chosen, "lateral": lateral, "parameters": "taps"}


def _stages(
    structure: str | Mapping[str, Any] | None, search: Search, start: Any, limits: Mapping[str, Any]
) -> dict[str, Search]:
    """Give what each stage of a search looks for, by the suffix of its checkpoint."""
    if not isinstance(search, ControllerSearch) or search.parameters != "taps":
        return {"": search}
    chosen, _ = controller_structure(structure)
    stages: dict[str, Search] = {"": search}
    if structure == "taps":
        stages = {
            suffix: make_search(_for_taps(chosen, lateral), **limits)
            for lateral, suffix in LATERAL_STAGES.items()
        }
    if start is None:
        stages[FIRST_STAGE] = make_search(_for_gains(chosen), None, None, None)
    return stages


def _of_first_stage(settings: Settings) -> Settings:
    """Give the settings of the search for gains: of the default method, whatever follows."""
    return replace(settings, method=METHODS[0], options={})


def _check_checkpoints(
    settings: Settings, scenarios: list[Scenario], mean: Mean, stages: Mapping[str, Search]
) -> None:
    """Refuse checkpoints of other searches before the first stage, and not as each one's turn is.

    What a stage starts from, and the evaluations left for it, are known only then.
    """
    if len(stages) == 1 or not settings.checkpoint:
        return
    for suffix, search in stages.items():
        path = settings.checkpoint + suffix
        if not Path(path).exists():
            continue
        found = problem_in(path)
        problem = _problem(scenarios, search, mean)
        own = _of_first_stage(settings) if suffix == FIRST_STAGE else settings
        known = json.loads(own.request(search.low, search.high, problem)["problem"])
        del known["maxfev"]
        if found is None or any(key not in found or found[key] != known[key] for key in known):
            which = (
                "damaged, or no checkpoint" if found is None else "the checkpoint of another search"
            )
            raise ValueError(f"checkpoint: {path}: is {which}; give another path, or remove it")


def _check_start(search: Search, start: Any, first: Array) -> None:
    if isinstance(search, ControllerSearch) and search.parameters == "shared-orders":
        for name in ("alpha", "sigma"):
            if np.ptp(getattr(start, name)) > 0:
                raise ValueError(f"start has a {name} for each channel; the structure has one")
    for name, value, low, high in zip(search.names, first, search.low, search.high, strict=True):
        slack = 1e-9 * (high - low)
        if not low - slack <= value <= high + slack:
            raise ValueError(f"start has {name} {value:.6g}; must be in [{low:g}, {high:g}]")


def _within(search: Search, controller: Controller) -> Array:
    """Give a controller's free parameters, moved to the bounds where they are beyond."""
    return np.clip(search.start(controller), search.low, search.high)


def _first_gains(
    scenarios: list[Scenario],
    search: ControllerSearch,
    structure: str | Mapping[str, Any] | None,
    settings: Settings,
    callback: Callback | None,
    shared: Mapping[str, Any],
) -> TuneResult:
    """Find gains and orders from which a search for free taps starts, and give them as taps."""
    chosen, _ = controller_structure(structure)
    own = _of_first_stage(settings)
    maxtime = None if np.isinf(settings.maxtime) else _core.START_SHARE * settings.maxtime
    if settings.checkpoint and any(
        Path(settings.checkpoint + stage).exists() for stage in LATERAL_STAGES.values()
    ):
        # What came after has begun where this stage had ended, by its time perhaps: no further.
        maxtime = _NO_TIME

    def as_taps(found: TuneResult) -> TuneResult:
        mean = (float(shared["worst_share"]), cost_caps(shared["cost_cap"], scenarios))
        cost = cost_function(scenarios, search, mean, 1)
        return _as_taps(found, search, structure, cost, settings.stopval)

    try:
        found = _tune(
            scenarios,
            structure=_for_gains(chosen),
            method=own.method,
            options=own.options,
            rng=own.seed,
            maxfev=_gains_share(settings),
            maxtime=maxtime,
            stopval=_stopval(settings),
            callback=callback,
            checkpoint=_stage_path(settings, FIRST_STAGE),
            progress=settings.progress,
            **shared,
        )
    except BaseException as error:
        if isinstance(getattr(error, "best", None), TuneResult):
            error.best = as_taps(error.best)  # type: ignore[attr-defined]
        raise
    return as_taps(found)


def _either_lateral(
    scenarios: list[Scenario],
    search: ControllerSearch,
    settings: Settings,
    start: Controller | Rival | None,
    shared: dict[str, Any],
) -> TuneResult:
    """Search for free taps with each of what the lateral channel may be fed; keep the better."""
    chosen, _ = controller_structure("taps")
    stages: list[TuneResult] = []
    left, seconds = settings.maxfev, settings.maxtime
    callback = shared.pop("callback")
    # Of what a stage could not use, because its time was up, no other has more: a search that goes
    # on from its checkpoints has the same stages.
    rest = left - _gains_share(settings) if start is None else left

    def add(stage: Callable[[], TuneResult]) -> bool:
        """Run a stage; give whether the search goes on."""
        nonlocal left, seconds
        try:
            stages.append(stage())
        except BaseException as error:
            if isinstance(getattr(error, "best", None), TuneResult):
                stages.append(error.best)  # type: ignore[attr-defined]
                error.best = _best_of(stages, "taps", settings)  # type: ignore[attr-defined]
            raise
        last = stages[-1]
        left -= last.nfev if left < UNLIMITED else 0
        seconds -= last.elapsed
        return left > 0 and seconds > 0 and last.status <= OUT_OF_TIME

    if start is None:
        limits = {key: shared[key] for key in ("workers", "worst_share", "cost_cap")}

        gains = partial(_first_gains, scenarios, search, "taps", settings, callback, limits)
        if not add(gains):
            return _best_of(stages, "taps", settings)
        if stages[0].status != OUT_OF_TIME:
            rest = left
        start = stages[0].controller
    laterals = _core.FREE_TAP_LATERALS
    for lateral in laterals:
        last = lateral == laterals[-1]
        share = rest // 2 if last else -(-rest // 2)
        if share < 1:
            break
        stage = partial(
            _tune,
            scenarios,
            structure=_for_taps(chosen, lateral),
            start=start,
            rng=settings.seed,
            maxfev=None if settings.maxfev == UNLIMITED else share,
            maxtime=None if np.isinf(seconds) else (seconds if last else seconds / 2),
            stopval=_stopval(settings),
            checkpoint=_stage_path(settings, LATERAL_STAGES[lateral]),
            callback=_counting_on(callback, sum(stage.nfev for stage in stages)),
            **shared,
        )
        if not add(stage):
            break
    return _best_of(stages, "taps", settings)


def _stage_path(settings: Settings, suffix: str) -> str | None:
    return settings.checkpoint + suffix if settings.checkpoint else None


def _stopval(settings: Settings) -> float | None:
    return None if settings.stopval == -np.inf else settings.stopval


def _gains_share(settings: Settings) -> int:
    """Give the evaluations for gains and orders before a search for free taps."""
    budget = DEFAULT_EVALUATIONS if settings.maxfev == UNLIMITED else settings.maxfev
    return max(1, int(_core.START_SHARE * budget))


def _counting_on(callback: Callback | None, spent: int) -> Callback | None:
    """Give a callback for a later stage, which is told the evaluations of all."""
    if callback is None or spent == 0:
        return callback

    answer = answering(callback)

    def told(result: OptimizeResult) -> object:
        return answer(OptimizeResult(result, nfev=result.nfev + spent))

    return told


def _cost(stage: TuneResult) -> float:
    return float(stage["fun"])


def _best_of(stages: list[TuneResult], structure: Any, settings: Settings) -> TuneResult:
    """Join stages of one search: the best one's answer, the history of all."""
    best: TuneResult = min(reversed(stages), key=_cost)
    result = TuneResult(best)
    spent = np.cumsum([0] + [stage.nfev for stage in stages])
    history = np.concatenate([stage.history for stage in stages])
    history["nfev"] += np.repeat(spent[:-1], [len(stage.history) for stage in stages])
    history["best"] = np.minimum.accumulate(history["best"])
    last = stages[-1]
    result.update(
        structure=structure,
        method=settings.method,
        options=settings.options,
        nfev=int(spent[-1]),
        nit=len(history),
        history=history,
        elapsed=sum(stage.elapsed for stage in stages),
        success=last.success,
        status=last.status,
        message=last.message,
    )
    return result


def _as_taps(
    found: TuneResult,
    search: ControllerSearch,
    structure: Any,
    cost: _core.CostFunction,
    stopval: float,
) -> TuneResult:
    """Give a search that ended with gains and orders as one for taps.

    Its costs are those of the free taps: they may be frozen or tied, and not make what was found.
    """
    x = _within(search, found.controller)
    fun = float(cost.costs(x[None, :])[0])
    found.update(
        x=x,
        active_mask=active_mask(x, search.low, search.high),
        fun=fun,
        structure=structure,
        parameters=search.names,
        controller=search.controller(x),
        population=x[None, :],
        population_energies=np.array([fun]),
    )
    found.history["best"] = np.maximum(found.history["best"], fun)
    if found.status == list(MESSAGES).index("target") and fun > stopval:
        found.update(status=list(MESSAGES).index("evaluations"), message=MESSAGES["evaluations"])
    return found
