"""Tuning of controllers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario
from nfopidn._files import replace_file
from nfopidn._parameters import ControllerSearch, controller_structure, make_search
from nfopidn._search import (
    DEFAULT_EVALUATIONS,
    FIRST_STAGE,
    HISTORY,
    MESSAGES,
    UNLIMITED,
    Array,
    Callback,
    OptimizeResult,
    Settings,
    check_settings,
    finish,
    run,
)

TUNING_FORMAT = "nfopidn-tuning"
TUNING_VERSION = 1

#: From this status on a search has been told to end, or its time is up.
ENDED_EARLY = list(MESSAGES).index("time")


class TuneResult(OptimizeResult):
    """The result of tune(): also controller, scenario, structure, parameters, method, options.

    x holds the free parameters, which `parameters` names; controller has them all.
    """

    def to_json(self, path: str | PathLike[str]) -> None:
        """Write the result; `controller` in it is a controller document of its own."""
        fields = {
            key: value.tolist() if isinstance(value, np.ndarray) else value
            for key, value in self.items()
        }
        fields["history"] = [list(row) for row in fields["history"]]
        fields["controller"] = json.loads(self["controller"].to_json())
        fields["scenario"] = [json.loads(scenario.to_json()) for scenario in _list(self.scenario)]
        document = {"format": TUNING_FORMAT, "version": TUNING_VERSION, **fields}
        replace_file(path, json.dumps(document, indent=1, default=_plain) + "\n")

    @classmethod
    def from_json(cls, path: str | PathLike[str]) -> TuneResult:
        """Read what to_json() has written.

        Raises
        ------
        ValueError
            Names the file, and what in it is not as it must be.
        """
        try:
            fields = json.loads(Path(path).read_text(encoding="utf-8"))
            if fields.pop("format") != TUNING_FORMAT or fields.pop("version") != TUNING_VERSION:
                raise ValueError(
                    f"must be a document {TUNING_FORMAT!r} of version {TUNING_VERSION}"
                )
            for key in ("fun", "nfev", "parameters", "seed", "message"):
                fields[key]
            for key in ("x", "population", "population_energies"):
                fields[key] = np.array(fields[key], dtype=float)
            shape = (len(fields["population_energies"]), len(fields["x"]))
            fields["population"] = fields["population"].reshape(shape)
            history = [tuple(row) for row in fields["history"]]
            fields["history"] = np.array(history, dtype=[(name, float) for name in HISTORY])
            kind = Rival if fields["controller"].get("format") == "nfopidn-rival" else Controller
            fields["controller"] = kind.from_json(json.dumps(fields["controller"]))
            scenarios = [Scenario.from_json(json.dumps(one)) for one in fields["scenario"]]
            if not scenarios:
                raise ValueError("scenario is empty")
        except (ValueError, TypeError, KeyError, AttributeError) as error:
            raise ValueError(f"{path}: not a tuning result: {error}") from None
        fields["scenario"] = scenarios[0] if len(scenarios) == 1 else scenarios
        return cls(fields)


def _plain(value: Any) -> Any:
    """Give what JSON can hold for what NumPy has made."""
    if hasattr(value, "tolist"):
        return value.tolist()
    raise TypeError(f"{type(value).__name__} has no place in a file")


def _list(scenario: Scenario | Sequence[Scenario]) -> list[Scenario]:
    return [scenario] if isinstance(scenario, Scenario) else list(scenario)


class Objective:
    """A controller's cost as a function of its free parameters, for any optimiser.

    Many points at once run on wide instructions: costs(points) is the fast way.

    >>> objective = Objective(structure="decoupled")
    >>> x = objective.parameters_of(Controller.published())
    >>> objective(x) == objective.costs([x])[0]
    True
    """

    def __init__(
        self,
        scenario: Scenario | Sequence[Scenario] | None = None,
        *,
        structure: str | Mapping[str, Any] | None = None,
        bounds: Mapping[str, tuple[float, float]] | ArrayLike | None = None,
        frozen: Mapping[str, float] | None = None,
        tied: Mapping[str, str] | None = None,
        risk: float = 1.0,
        workers: int = 1,
    ) -> None:
        """Take the arguments of tune()."""
        search = make_search(structure, bounds, frozen, tied)
        if not isinstance(search, ControllerSearch):
            raise ValueError(f"structure is {structure!r}, a rival; must be one of a Controller")
        _check_share(risk, workers)
        self._search = search
        #: Names of the free parameters, p of them.
        self.parameters = search.names
        #: (p, 2): low and high of each.
        self.bounds = np.column_stack([search.low, search.high])
        self._function = _cost_function(_scenarios(scenario), search, risk, workers)

    def __call__(self, x: ArrayLike) -> float:
        """Give the cost (eq. 41) of a point (p,)."""
        return float(self._function.costs(np.array(x, dtype=float)[None, :])[0])

    def costs(self, points: ArrayLike) -> Array:
        """Give the costs (n,) of points (n, p)."""
        return self._function.costs(np.array(points, dtype=float))

    def gradient(self, x: ArrayLike) -> tuple[float, Array]:
        """Give the cost at x (p,) and its exact partial derivatives (p,)."""
        return self._function.gradient(np.array(x, dtype=float))

    def controller(self, x: ArrayLike) -> Controller:
        """Give the controller that x (p,) stands for."""
        return self._search.controller(np.array(x, dtype=float))

    def parameters_of(self, controller: Controller) -> Array:
        """Give the free parameters (p,) that a controller has."""
        return self._search.start(controller)


def _cost_function(
    scenarios: list[Scenario], search: ControllerSearch, risk: float, workers: int
) -> _core.CostFunction:
    return _core.CostFunction(
        scenarios,
        search.base,
        search.parameters,
        search.source,
        search.fixed,
        len(search.names),
        float(risk),
        int(workers),
    )


def _check_share(risk: float, workers: int) -> None:
    if isinstance(workers, bool) or int(workers) != workers or workers < 1:
        raise ValueError(f"workers is {workers}; must be a whole number of at least 1")
    if not 0 <= risk <= 1:
        raise ValueError(f"risk is {risk}; must be in [0, 1]")


def tune(
    scenario: Scenario | Sequence[Scenario] | None = None,
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
    risk: float = 1.0,
) -> TuneResult:
    """Find the gains and orders of least cost (eq. 41) for a scenario, or for several.

    Parameters
    ----------
    scenario
        A Scenario or a list of them; None: the published one.
    structure
        "paper" (default), "decoupled", "incremental", "extended" (an order pair a channel), "taps"
        (decoupled, with the filters' taps themselves as parameters; the lateral channel is tried
        with `lateral` "speed" and with "direction", and the better one is the result), or settings
        of Controller, to which `parameters` "shared-orders" (default), "orders-by-channel" or
        "taps" may be added.
        Or a rival: one of Rival.laws(), or {"law": ..., "speeds": ...}, settings of Rival; its
        model of the robot is that of the first scenario. `controller` is a Rival then.
    bounds
        By name, such as {"ki_x": (0, 0.3)}, the others by default_bounds(); or (p, 2) for all
        free parameters.
    method, options, rng, maxfev, maxtime, stopval, callback, checkpoint, progress
        As for bfoa(). A gradient counts as 1 + p evaluations.
    workers
        Threads. The result does not depend on their number.
    frozen
        Parameters that keep a value, by name.
    tied
        Parameters that equal another one: {"kp_y": "kp_x"}.
    start
        A controller to start from. Without one, a search for free taps spends three tenths of the
        evaluations on gains and orders first. Stages before the last have checkpoints of their
        own, with the suffixes .gains and .speed.
    risk
        With several scenarios: the cost is the mean of the worst `risk` share of them; 1 is the
        mean of all, 0 the worst case.

    Returns
    -------
    TuneResult
        Ctrl-C ends the search and returns the best so far.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    """
    settings = check_settings(method, options, rng, maxfev, maxtime, stopval, checkpoint, progress)
    scenarios = _scenarios(scenario)
    search = make_search(structure, bounds, frozen, tied, scenarios[0].robot)
    _check_share(risk, workers)
    first = None if start is None else search.start(start)
    if structure == "taps" and isinstance(search, ControllerSearch):
        shared = {
            **{"bounds": bounds, "frozen": frozen, "tied": tied, "method": method},
            **{"options": options, "callback": callback, "progress": progress},
            **{"workers": workers, "risk": risk},
        }
        return _either_lateral(scenarios, search, settings, start, shared)
    before: TuneResult | None = None
    if start is None and isinstance(search, ControllerSearch) and search.parameters == "taps":
        before = _first_gains(
            scenarios, structure, settings, callback, {"workers": workers, "risk": risk}
        )
        first = search.start(before.controller)
        if before.status >= ENDED_EARLY or before.nfev >= settings.maxfev:
            return _as_taps(before, search, structure, _cost_function(scenarios, search, risk, 1))
    problem = {
        "kind": "tune",
        "scenario": [json.loads(one.to_json()) for one in scenarios],
        **search.problem(),
        "source": search.source,
        "fixed": search.fixed,
        "risk": float(risk),
    }
    problem["start"] = None if first is None else first.tolist()
    request = settings.request(search.low, search.high, problem)
    if before is not None:
        request["maxfev"] -= before.nfev
        request["maxtime"] = max(request["maxtime"] - before.elapsed, 1e-9)
    request["start"] = first
    reply, raised = run(
        lambda request: search.run(scenarios, float(risk), int(workers), request),
        request,
        settings,
        callback,
        "tune",
    )
    result = TuneResult(
        seed=settings.seed,
        structure="paper" if structure is None else structure,
        options=settings.options,
        method=method,
        parameters=search.names,
        scenario=scenarios[0] if len(scenarios) == 1 else scenarios,
        controller=search.controller(reply["x"]),
    )
    if before is not None:
        reply["nfev"] += before.nfev
        reply["elapsed"] += before.elapsed
        reply["history"][:, HISTORY.index("nfev")] += before.nfev
        reply["history"] = np.vstack([_rows(before.history), reply["history"]])
    finish(result, reply, raised)
    return result


def _rows(history: Any) -> Array:
    return np.column_stack([history[name] for name in HISTORY])


def _scenarios(scenario: Scenario | Sequence[Scenario] | None) -> list[Scenario]:
    if scenario is None:
        return [Scenario.published(rng=0)]
    if not isinstance(scenario, Scenario | list | tuple):
        raise ValueError("scenario must be a Scenario or a list of them")
    scenarios = _list(scenario)
    if not scenarios or not all(isinstance(one, Scenario) for one in scenarios):
        raise ValueError("scenario must be a Scenario or a list of at least one")
    return scenarios


def _first_gains(
    scenarios: list[Scenario],
    structure: str | Mapping[str, Any] | None,
    settings: Settings,
    callback: Callback | None,
    shared: Mapping[str, Any],
) -> TuneResult:
    """Find gains and orders from which a search for free taps starts."""
    chosen, _ = controller_structure(structure)
    budget = DEFAULT_EVALUATIONS if settings.maxfev == UNLIMITED else settings.maxfev
    return tune(
        scenarios,
        structure={**chosen, "parameters": "orders-by-channel"},
        rng=settings.seed,
        maxfev=max(1, int(_core.START_SHARE * budget)),
        maxtime=None if np.isinf(settings.maxtime) else settings.maxtime,
        stopval=None if np.isinf(settings.stopval) else settings.stopval,
        callback=callback,
        checkpoint=settings.checkpoint + FIRST_STAGE if settings.checkpoint else None,
        progress=settings.progress,
        **shared,
    )


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

    def add(stage: Callable[[], TuneResult]) -> bool:
        """Run a stage; give whether the search goes on."""
        nonlocal left, seconds
        try:
            stages.append(stage())
        except BaseException as error:
            if isinstance(getattr(error, "best", None), TuneResult):
                stages.append(error.best)  # type: ignore[attr-defined]
                error.best = _best_of(stages)  # type: ignore[attr-defined]
            raise
        last = stages[-1]
        left -= last.nfev if left < UNLIMITED else 0
        seconds -= last.elapsed
        return left > 0 and seconds > 0 and last.status <= ENDED_EARLY

    if start is None:
        limits = {"workers": shared["workers"], "risk": shared["risk"]}

        def gains() -> TuneResult:
            found = _first_gains(scenarios, "taps", settings, shared["callback"], limits)
            cost = _cost_function(scenarios, search, shared["risk"], 1)
            return _as_taps(found, search, "taps", cost)

        if not add(gains):
            return _best_of(stages)
        start = stages[0].controller
    laterals = _core.FREE_TAP_LATERALS
    for lateral in laterals:
        last = lateral == laterals[-1]
        part = 1 if last else 2  # of what is left
        suffix = "" if last else f".{lateral}"
        stage = partial(
            tune,
            scenarios,
            structure={**chosen, "lateral": lateral, "parameters": "taps"},
            start=start,
            rng=settings.seed,
            maxfev=None if left == UNLIMITED else -(-left // part),
            maxtime=None if np.isinf(seconds) else seconds / part,
            stopval=None if np.isinf(settings.stopval) else settings.stopval,
            checkpoint=settings.checkpoint + suffix if settings.checkpoint else None,
            **shared,
        )
        if not add(stage):
            break
    return _best_of(stages)


def _cost(stage: TuneResult) -> float:
    return float(stage["fun"])


def _best_of(stages: list[TuneResult]) -> TuneResult:
    """Join stages of one search: the best one's answer, the history of all."""
    best: TuneResult = min(stages, key=_cost)
    result = TuneResult(best)
    spent = np.cumsum([0] + [stage.nfev for stage in stages])
    history = np.concatenate([stage.history for stage in stages])
    history["nfev"] += np.repeat(spent[:-1], [len(stage.history) for stage in stages])
    history["best"] = np.minimum.accumulate(history["best"])
    last = stages[-1]
    result.update(
        structure="taps",
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
    found: TuneResult, search: ControllerSearch, structure: Any, cost: _core.CostFunction
) -> TuneResult:
    """Give a search that ended with gains and orders as one for taps.

    Its cost is that of the free taps: they may be frozen or tied, and not make what was found.
    """
    x = search.start(found.controller)
    fun = float(cost.costs(x[None, :])[0])
    found.update(
        x=x,
        fun=fun,
        structure=structure,
        parameters=search.names,
        controller=search.controller(x),
        population=x[None, :],
        population_energies=np.array([fun]),
    )
    return found
