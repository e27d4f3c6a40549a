"""A controller's cost as a function of its free parameters."""

from __future__ import annotations

import copy
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nfopidn import _core
from nfopidn._core import Controller, Scenario
from nfopidn.arguments import is_number, real_numbers, shown
from nfopidn.engines import read_threads
from nfopidn.families.family import Family
from nfopidn.search.optimise import Array
from nfopidn.tuning.engine_costs import core_costs
from nfopidn.tuning.parameters import ControllerSearch, make_search
from nfopidn.tuning.result import scenario_list


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
        worst_share: float = 1.0,
        cost_cap: float | str | None = None,
        workers: int = 1,
    ) -> None:
        """Take the arguments of tune(), of a nominal search: no variations, and no cap."""
        scenarios = scenarios_of(scenario)
        search = make_search(structure, bounds, frozen, tied, scenarios)
        if not isinstance(search, ControllerSearch):
            raise ValueError(f"structure is {structure!r}, a rival; must be one of a Controller")
        threads = read_threads(workers)
        check_share(worst_share)
        self._search = search
        #: Names of the free parameters, p of them.
        self.parameters = search.names
        #: (p, 2): low and high of each.
        self.bounds = np.column_stack([search.low, search.high])
        mean = (float(worst_share), cost_caps(cost_cap, scenarios))
        self._function = core_costs(scenarios, search, mean, threads)
        # Copies: what the caller makes of its own afterwards is not this objective's.
        self._arguments: dict[str, Any] = {
            "scenario": list(scenarios),
            "structure": _own(structure),
            "bounds": self.bounds,
            "frozen": _own(frozen),
            "tied": _own(tied),
            "worst_share": worst_share,
            "cost_cap": cost_cap,
            "workers": workers,
        }

    def __reduce__(self) -> tuple[Any, ...]:
        """Tell pickle and copy how to construct it, and what a user's subclass adds."""
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


def check_share(worst_share: float) -> None:
    """Refuse a worst share that is out of range."""
    if not is_number(worst_share) or not 0 <= worst_share <= 1:
        raise ValueError(f"worst_share is {worst_share}; must be in [0, 1]")


def cost_caps(cost_cap: float | str | None, scenarios: Sequence[Scenario]) -> list[float]:
    """Give the cap of each scenario's cost; an empty list where costs count as they are.

    Raises
    ------
    ValueError
        Neither None, nor "friction", nor a positive number.
    """
    if cost_cap is None:
        return []
    if isinstance(cost_cap, str) and cost_cap == "friction":
        return [_core.family_cap(scenario) for scenario in scenarios]
    if not is_number(cost_cap) or not 0 < float(cost_cap) < np.inf:
        raise ValueError(
            f"cost_cap is {shown(cost_cap)}; must be a positive number, 'friction' or None"
        )
    return [float(cost_cap)] * len(scenarios)


def scenarios_of(scenario: Scenario | Sequence[Scenario] | None) -> list[Scenario]:
    """Give the scenarios of tune(); without any, the published one with seed 0."""
    if scenario is None:
        return [Scenario.published(rng=0)]
    if not isinstance(scenario, Scenario | Family | list | tuple):
        raise ValueError("scenario must be a Scenario, a Family or a list of Scenarios")
    scenarios = scenario_list(scenario)
    if not scenarios or not all(isinstance(one, Scenario) for one in scenarios):
        raise ValueError("scenario must be a Scenario or a list of at least one")
    return scenarios
