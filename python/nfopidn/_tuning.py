"""Tuning of controllers."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nfopidn import _core
from nfopidn._core import Controller, Scenario
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
    check_bounds,
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
        Path(path).write_text(
            json.dumps(document, indent=1, default=_plain) + "\n", encoding="utf-8"
        )

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
            fields["controller"] = Controller.from_json(json.dumps(fields["controller"]))
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


@dataclass
class Search:
    """A structure's parameters: which are free, within what, and what the others are."""

    base: Controller
    parameters: str
    names: list[str]  # of the free parameters
    low: Array
    high: Array
    source: list[int]
    fixed: list[float]

    def controller(self, x: Array) -> Controller:
        """Make the controller of a free vector."""
        return _core.design(self.base, self.parameters, self.source, self.fixed, x.tolist())

    def start(self, controller: Controller) -> Array:
        """Give the free parameters that a controller has."""
        if controller.gains is None and self.parameters != "taps":
            raise ValueError("start has free taps; the structure needs gains and orders")
        every = _core.parameters(self.base, self.parameters, controller)
        x = np.zeros(len(self.names))
        for value, place in reversed(list(zip(every, self.source, strict=True))):
            if place >= 0:
                x[place] = value
        return x


def _structure(structure: str | Mapping[str, Any] | None) -> tuple[dict[str, Any], str]:
    """Give the settings of Controller that a structure stands for, and its parameter set."""
    if structure is None:
        structure = "paper"
    if isinstance(structure, str):
        settings, parameters = _core.structure(structure)
        return dict(settings), parameters
    settings = dict(structure)
    return settings, settings.pop("parameters", "shared-orders")


def _box(
    structure: str | Mapping[str, Any] | None,
) -> tuple[Controller, str, dict[str, tuple[float, float]]]:
    """Give a structure's settings, its parameter set, and its parameters with their bounds."""
    settings, parameters = _structure(structure)
    base = Controller.published(**settings)
    bounds = _core.parameter_bounds(base, parameters)
    return base, parameters, {name: (low, high) for name, low, high in bounds}


def default_bounds(
    structure: str | Mapping[str, Any] | None = None,
) -> dict[str, tuple[float, float]]:
    """Give the parameters of a structure by name, with the bounds that tune() takes.

    Gains [0, 3] and orders [0.01, 1]; "extended": [0, 6] and [0.01, 2]. In the incremental form
    the integral gains end at 0.3: beyond, nearly all runs diverge.
    """
    return _box(structure)[2]


def _sources(
    names: Sequence[str],
    frozen: Mapping[str, float] | None,
    tied: Mapping[str, str] | None,
) -> tuple[list[int], list[int], list[float]]:
    """Give the free places, and for each place its free one (or -1) and its frozen value."""
    fixed = [0.0] * len(names)
    leader = list(range(len(names)))
    for name, value in dict(frozen or {}).items():
        if not np.isfinite(value):
            raise ValueError(f"frozen: {name} is {value}; must be finite")
        place = _known(name, names, "frozen")
        fixed[place] = float(value)
        leader[place] = -1
    for name, other in dict(tied or {}).items():
        place, first = _known(name, names, "tied"), _known(other, names, "tied")
        if place == first:
            raise ValueError(f"tied leads {name!r} to itself")
        if leader[place] != place:
            raise ValueError(f"tied names {name!r}, which is frozen or tied already")
        if leader[first] != first or place in leader[:place] + leader[place + 1 :]:
            raise ValueError(f"tied leads {name!r} to {other!r}, which is not free itself")
        leader[place] = first
    free = [place for place in range(len(names)) if leader[place] == place]
    if not free:
        raise ValueError("frozen leaves no parameter free")
    return free, [free.index(at) if at >= 0 else -1 for at in leader], fixed


def _known(name: str, names: Sequence[str], argument: str) -> int:
    if name not in names:
        raise ValueError(f"{argument} names {name!r}; known: {', '.join(names)}")
    return names.index(name)


def _search(
    structure: str | Mapping[str, Any] | None,
    bounds: Any,
    frozen: Mapping[str, float] | None,
    tied: Mapping[str, str] | None,
) -> Search:
    base, parameters, box = _box(structure)
    names = list(box)
    free, source, fixed = _sources(names, frozen, tied)
    own = [names[place] for place in free]
    if isinstance(bounds, Mapping):
        for name in bounds:
            _known(name, own, "bounds")
        box.update({name: _pair(name, pair) for name, pair in bounds.items()})
    elif bounds is not None:
        rows = np.array(bounds, dtype=float)
        if rows.shape != (len(own), 2):
            raise ValueError(
                f"bounds have the shape {rows.shape}; must be ({len(own)}, 2), for {', '.join(own)}"
            )
        box.update({name: (row[0], row[1]) for name, row in zip(own, rows, strict=True)})
    table = np.array([box[name] for name in own])
    check_bounds(table[:, 0], table[:, 1], own)
    search = Search(base, parameters, own, table[:, 0].copy(), table[:, 1].copy(), source, fixed)
    for corner in (search.low, search.high):  # refuses what a controller may not have
        Controller.from_json(search.controller(corner).to_json())
    return search


def _pair(name: str, pair: Any) -> tuple[float, float]:
    try:
        low, high = pair
        return float(low), float(high)
    except (TypeError, ValueError):
        raise ValueError(f"bounds of {name} are {pair!r}; must be (low, high)") from None


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
        self._search = _search(structure, bounds, frozen, tied)
        _check_share(risk, workers)
        search = self._search
        #: Names of the free parameters, p of them.
        self.parameters = search.names
        #: (p, 2): low and high of each.
        self.bounds = np.column_stack([search.low, search.high])
        self._function = _core.CostFunction(
            _scenarios(scenario),
            search.base,
            search.parameters,
            search.source,
            search.fixed,
            len(search.names),
            float(risk),
            int(workers),
        )

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
    start: Controller | None = None,
    risk: float = 1.0,
) -> TuneResult:
    """Find the gains and orders of least cost (eq. 41) for a scenario, or for several.

    Parameters
    ----------
    scenario
        A Scenario or a list of them; None: the published one.
    structure
        "paper" (default), "decoupled", "incremental", "extended" (an order pair a channel), "taps"
        (extended, with the filters' taps themselves as parameters), or settings of Controller, to
        which `parameters` "shared-orders" (default), "orders-by-channel" or "taps" may be added.
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
        A controller to start from. Without one, "taps" spends two fifths of the evaluations on
        gains and orders first, whose checkpoint has the suffix .gains.
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
    search = _search(structure, bounds, frozen, tied)
    _check_share(risk, workers)
    if start is not None and not isinstance(start, Controller):
        raise ValueError("start must be a Controller")
    if start is not None and start.memory != search.base.memory:
        raise ValueError(f"start has memory {start.memory}; must have {search.base.memory}")
    before: TuneResult | None = None
    if start is None and search.parameters == "taps":
        before = _first_gains(
            scenarios, structure, settings, callback, {"workers": workers, "risk": risk}
        )
        start = before.controller
        if before.status >= ENDED_EARLY or before.nfev >= settings.maxfev:
            return _as_taps(before, search, structure)
    problem = {
        "kind": "tune",
        "scenario": [json.loads(one.to_json()) for one in scenarios],
        "controller": json.loads(search.base.to_json()),
        "parameters": search.parameters,
        "source": search.source,
        "fixed": search.fixed,
        "risk": float(risk),
    }
    first = None if start is None else search.start(start)
    problem["start"] = None if first is None else first.tolist()
    request = settings.request(search.low, search.high, problem)
    if before is not None:
        request["maxfev"] -= before.nfev
        request["maxtime"] = max(request["maxtime"] - before.elapsed, 1e-9)
    request["start"] = first
    reply, raised = run(
        lambda request: _core.search_controller(
            scenarios,
            search.base,
            search.parameters,
            search.source,
            search.fixed,
            float(risk),
            int(workers),
            request,
        ),
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
    chosen, _ = _structure(structure)
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


def _as_taps(found: TuneResult, search: Search, structure: Any) -> TuneResult:
    """Give a search that ended with gains and orders as one for taps."""
    x = search.start(found.controller)
    found.update(
        x=x,
        structure=structure,
        parameters=search.names,
        controller=search.controller(x),
        population=x[None, :],
        population_energies=np.array([found.fun]),
    )
    return found
