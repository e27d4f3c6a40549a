"""Tuning of controllers."""

from __future__ import annotations

import copy
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
from nfopidn._checks import is_number, real_numbers, whole_number
from nfopidn._core import Controller, Rival, Robot, Scenario
from nfopidn._files import replace_file
from nfopidn._parameters import (
    ROBOT_FIELDS,
    ControllerSearch,
    Search,
    controller_structure,
    make_search,
)
from nfopidn._search import (
    DEFAULT_EVALUATIONS,
    FIRST_STAGE,
    HISTORY,
    LATERAL_STAGES,
    MESSAGES,
    METHODS,
    MOST_WORKERS,
    UNLIMITED,
    Array,
    Callback,
    OptimizeResult,
    Settings,
    check_settings,
    finish,
    problem_in,
    run,
)

_NO_TIME = 1e-9  # [s]
TUNING_FORMAT = "nfopidn-tuning"
TUNING_VERSION = 1

#: What a document must have, besides those that from_json() reads one by one.
_FIELDS = (
    *("fun", "nfev", "nit", "parameters", "seed", "message", "success", "status", "elapsed"),
    *("structure", "options", "method"),
)

#: Up to this status a search has come to its end or its time is up; beyond, it was told to end.
OUT_OF_TIME = list(MESSAGES).index("time")


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
        document = {"format": TUNING_FORMAT, "version": TUNING_VERSION, **_plain(fields)}
        replace_file(path, json.dumps(document, indent=1, allow_nan=False) + "\n")

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
            for key in _FIELDS:
                fields[key]
            fields["fun"] = _number_in(fields, "fun")
            fields["nfev"] = int(_number_in(fields, "nfev"))
            for key in ("x", "population", "population_energies"):
                fields[key] = np.array(fields[key], dtype=float)
            check_names(fields["parameters"], fields["x"])
            shape = (len(fields["population_energies"]), len(fields["x"]))
            fields["population"] = fields["population"].reshape(shape)
            history = [tuple(row) for row in fields["history"]]
            fields["history"] = np.array(history, dtype=[(name, float) for name in HISTORY])
            kind = Rival if fields["controller"].get("format") == "nfopidn-rival" else Controller
            fields["controller"] = kind.from_json(json.dumps(fields["controller"]))
            scenarios = [Scenario.from_json(json.dumps(one)) for one in fields["scenario"]]
            if not scenarios:
                raise ValueError("scenario is empty")
            structure = fields["structure"]
            if isinstance(structure, dict) and isinstance(structure.get("robot"), dict):
                structure["robot"] = Robot(**structure["robot"])
        except (
            *(ValueError, TypeError, LookupError, AttributeError, ArithmeticError),
            RecursionError,
        ) as error:
            raise ValueError(f"{path}: not a tuning result: {error}") from None
        fields["scenario"] = scenarios[0] if len(scenarios) == 1 else scenarios
        return cls(fields)


def check_names(names: Any, x: Array) -> None:
    """Refuse parameters that are no names, or more or fewer than there are numbers."""
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ValueError("parameters must be a list of names")
    if np.shape(x) != (len(names),):
        raise ValueError(f"x must have {len(names)} numbers, one for each parameter")


def _number_in(fields: Mapping[str, Any], key: str) -> float:
    try:
        return float(fields[key])
    except (TypeError, ValueError):
        raise ValueError(f"{key} must be a number") from None


def _plain(value: Any) -> Any:
    """Give what JSON can hold: of NumPy's making plain numbers, of what is not finite its name."""
    if isinstance(value, Mapping):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, Robot):
        return {name: getattr(value, name) for name in ROBOT_FIELDS}
    if isinstance(value, float) and not np.isfinite(value):
        return str(value)
    if value is None or isinstance(value, str | bool | int | float):
        return value
    raise TypeError(f"{type(value).__name__} has no place in a file")


def _list(scenario: Scenario | Sequence[Scenario]) -> list[Scenario]:
    return [scenario] if isinstance(scenario, Scenario) else list(scenario)


class Objective:
    """A controller's cost as a function of its free parameters, for any optimiser.

    Many points at once run on wide instructions: costs(points) is the fast way.

    >>> objective = Objective(structure="decoupled")
    >>> x = objective.parameters_of(Controller.published())
    >>> bool(objective(x) == objective.costs([x])[0])
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
        scenarios = _scenarios(scenario)
        self._function = _cost_function(scenarios, search, risk, workers)
        # Copies: what the caller makes of its own afterwards is not this objective's.
        self._arguments: dict[str, Any] = {
            "scenario": list(scenarios),
            "structure": _own(structure),
            "bounds": self.bounds,
            "frozen": _own(frozen),
            "tied": _own(tied),
            "risk": risk,
            "workers": workers,
        }

    def __reduce__(self) -> tuple[Any, ...]:
        """Tell pickle and copy to make it anew; what a class of the user's adds goes along."""
        added = {key: value for key, value in vars(self).items() if key not in _OWN}
        return _made_anew, (type(self), self._arguments), added

    def __call__(self, x: ArrayLike) -> float:
        """Give the cost (eq. 41) of a point (p,)."""
        return float(self._function.costs(self._point(x)[None, :])[0])

    def costs(self, points: ArrayLike) -> Array:
        """Give the costs (n,) of points (n, p)."""
        rows = real_numbers("points", points)
        if rows.ndim != 2:
            raise ValueError(f"points have the shape {rows.shape}; must be (n, {self._size})")
        if not np.isfinite(rows).all():
            raise ValueError("points hold NaN or infinity; must be finite")
        return self._function.costs(rows)

    def gradient(self, x: ArrayLike) -> tuple[float, Array]:
        """Give the cost at x (p,) and its exact partial derivatives (p,)."""
        return self._function.gradient(self._point(x))

    def controller(self, x: ArrayLike) -> Controller:
        """Give the controller that x (p,) stands for."""
        made = self._search.controller(self._point(x))
        return Controller.from_json(made.to_json())  # refuses what a controller may not have

    @property
    def _size(self) -> int:
        return len(self.parameters)

    def _point(self, x: ArrayLike) -> Array:
        point = real_numbers("x", x)
        if point.shape != (self._size,):
            raise ValueError(f"x has the shape {point.shape}; must be ({self._size},)")
        if not np.isfinite(point).all():
            raise ValueError(f"x is {point}; must be finite")
        return point

    def parameters_of(self, controller: Controller) -> Array:
        """Give the free parameters (p,) that a controller has."""
        return self._search.start(controller)


#: What Objective() itself gives an objective.
_OWN = ("_arguments", "_function", "_search", "bounds", "parameters")


def _made_anew(kind: type[Objective], arguments: dict[str, Any]) -> Objective:
    made = kind.__new__(kind)
    Objective.__init__(made, **arguments)  # a class of the user's may take others
    return made


def _own(given: Any) -> Any:
    """Copy a mapping into a dict, and leave all else as it is."""
    return copy.deepcopy(dict(given)) if isinstance(given, Mapping) else given


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
    whole_number("workers", workers, 1, MOST_WORKERS)
    if not is_number(risk) or not 0 <= risk <= 1:
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
        A controller to start from, within the bounds: its gains and orders, or its taps; other
        settings are the structure's. Without one, a search for free taps spends
        three tenths of the evaluations and of the time on gains and orders first. Stages before the
        last have checkpoints of their own, with the suffixes .gains and .speed; a callback is told
        the evaluations of all, the point and the cost of the present one.
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
    scenarios = _scenarios(scenario)
    search = make_search(structure, bounds, frozen, tied, scenarios[0].robot)
    stages = _stages(structure, search, start, {"bounds": bounds, "frozen": frozen, "tied": tied})
    settings = check_settings(
        *(method, options, rng, maxfev, maxtime, stopval, checkpoint, progress, callback),
        stages=list(stages),
    )
    _check_share(risk, workers)
    _check_checkpoints(settings, scenarios, risk, stages)
    first = None if start is None else search.start(start)
    if first is not None:
        _check_start(search, start, first)
    if structure == "taps" and isinstance(search, ControllerSearch):
        shared = {
            **{"bounds": bounds, "frozen": frozen, "tied": tied, "method": method},
            **{"options": options, "callback": callback, "progress": progress},
            **{"workers": workers, "risk": risk},
        }
        return _either_lateral(scenarios, search, settings, start, shared)
    before: TuneResult | None = None
    if start is None and isinstance(search, ControllerSearch) and search.parameters == "taps":
        limits = {"workers": workers, "risk": risk}
        before = _first_gains(scenarios, search, structure, settings, callback, limits)
        first = before.x
        over = before.nfev >= settings.maxfev or before.elapsed >= settings.maxtime
        if before.status > OUT_OF_TIME or over:
            return _best_of([before], structure, settings)
    problem = _problem(scenarios, search, risk)
    problem["start"] = None if first is None else first.tolist()
    request = settings.request(search.low, search.high, problem)
    if before is not None:
        request["maxfev"] -= before.nfev
        request["maxtime"] = max(request["maxtime"] - before.elapsed, _NO_TIME)
    request["start"] = first
    reply, raised = run(
        lambda request: search.run(scenarios, float(risk), int(workers), request),
        request,
        settings,
        _counting_on(callback, 0 if before is None else before.nfev),
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
    if before is None:
        finish(result, reply, raised)
        return result
    try:
        finish(result, reply, raised)
    except BaseException as error:
        error.best = _best_of([before, result], structure, settings)  # type: ignore[attr-defined]
        raise
    return _best_of([before, result], structure, settings)


def _problem(scenarios: list[Scenario], search: Search, risk: float) -> dict[str, Any]:
    """Describe a search, but for its start, for a checkpoint."""
    return {
        "kind": "tune",
        "scenario": [json.loads(one.to_json()) for one in scenarios],
        **search.problem(),
        "source": search.source,
        "fixed": search.fixed,
        "risk": float(risk),
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
    settings: Settings, scenarios: list[Scenario], risk: float, stages: Mapping[str, Search]
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
        problem = _problem(scenarios, search, risk)
        own = _of_first_stage(settings) if suffix == FIRST_STAGE else settings
        known = json.loads(own.request(search.low, search.high, problem)["problem"])
        del known["maxfev"]
        if found is None or any(key not in found or found[key] != known[key] for key in known):
            which = "no checkpoint" if found is None else "the checkpoint of another search"
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
        cost = _cost_function(scenarios, search, shared["risk"], 1)
        return _as_taps(found, search, structure, cost, settings.stopval)

    try:
        found = tune(
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
        limits = {"workers": shared["workers"], "risk": shared["risk"]}

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
            tune,
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

    def told(result: OptimizeResult) -> object:
        return callback(OptimizeResult(result, nfev=result.nfev + spent))

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
