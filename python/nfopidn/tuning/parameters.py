"""What of a controller or a rival is searched for: parameters by name, and their bounds."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario
from nfopidn.arguments import (
    check_encoding,
    check_sample_time,
    is_number,
    real_numbers,
    suggestion,
)
from nfopidn.search.optimise import Array, check_bounds

#: What a Robot is made of.
ROBOT_FIELDS = ("mass", "inertia", "track_width", "wheel_radius")

Structure = str | Mapping[str, Any] | None
#: The share of the worst scenarios whose mean is the cost, and the caps of their costs, if any.
Mean = tuple[float, list[float]]
Box = dict[str, tuple[float, float]]


@dataclass
class Search(ABC):
    """A structure's parameters: which are free, within what, and what the others are."""

    names: list[str]  # of the free parameters
    low: Array
    high: Array
    source: list[int]
    fixed: list[float]

    @abstractmethod
    def controller(self, x: Array) -> Any:
        """Make the controller of a free vector."""

    @abstractmethod
    def start(self, controller: Any) -> Array:
        """Give the free parameters that a controller has."""

    @abstractmethod
    def problem(self) -> dict[str, Any]:
        """Describe what is searched for, for a checkpoint."""


@dataclass
class ControllerSearch(Search):
    """Of the NFOPIDN controller."""

    base: Controller
    parameters: str

    @property
    def space(self) -> _core.ParameterSpace:
        """The core's own description of it."""
        return _core.ParameterSpace(
            self.base, self.parameters, self.source, self.fixed, self.low, self.high
        )

    def controller(self, x: Array) -> Controller:
        """Make the controller of a free vector."""
        return self.space.controller(x)

    def start(self, controller: Any) -> Array:
        """Give the free parameters that a controller has."""
        if not isinstance(controller, Controller):
            raise ValueError("start must be a Controller")
        if controller.memory != self.base.memory:
            raise ValueError(f"start has memory {controller.memory}; must have {self.base.memory}")
        own = self.base.sample_time
        if own is not None:
            try:
                _core.check_sample_time(controller, own)
            except ValueError as error:
                raise ValueError(f"start: {error}") from None
        if controller.gains is None and self.parameters != "taps":
            raise ValueError("start has free taps; the structure needs gains and orders")
        return self.space.parameters_of(controller)

    def problem(self) -> dict[str, Any]:
        """Describe what is searched for, for a checkpoint."""
        controller = json.loads(self.base.to_json())
        # The scenarios have it; a checkpoint from before controllers had one is still the same.
        del controller["sample_time"]
        controller.pop("robot", None)
        controller["version"] = 1
        return {"controller": controller, "parameters": self.parameters}

    def stages(
        self, either_lateral: bool, has_start: bool
    ) -> tuple[dict[str, ControllerSearch], dict[str, ControllerSearch]]:
        """Give the stages of its search by name: for gains to start from, and the alternatives.

        With `either_lateral` it is also tried what the lateral channel is fed.
        """
        gains, alternatives = _core.plan_stages(
            self.base, self.parameters, either_lateral, has_start
        )
        own = {name: replace(self, base=base) for name, base, _ in alternatives}
        if gains is None:
            return {}, own
        name, base, parameters = gains
        box = {name: (low, high) for name, low, high in _core.parameter_bounds(base, parameters)}
        return {name: ControllerSearch(*_free_box(box, None, None, None), base, parameters)}, own


@dataclass
class RivalSearch(Search):
    """Of a rival's law."""

    base: Rival

    def controller(self, x: Array) -> Rival:
        """Make the rival of a free vector."""
        every = (
            float(x[place]) if place >= 0 else value
            for place, value in zip(self.source, self.fixed, strict=True)
        )
        return self.base.replace(**dict(zip(self.base.parameters, every, strict=True)))

    def start(self, controller: Any) -> Array:
        """Give the free parameters that a rival has."""
        if not isinstance(controller, Rival) or controller.law != self.base.law:
            raise ValueError(f"start must be a Rival of the law {self.base.law!r}")
        x = np.zeros(len(self.names))
        every = list(controller.parameters.values())
        for value, place in reversed(list(zip(every, self.source, strict=True))):
            if place >= 0:
                x[place] = value
        return x

    def problem(self) -> dict[str, Any]:
        """Describe what is searched for, for a checkpoint."""
        return {"rival": json.loads(self.base.to_json())}


def is_rival(structure: Structure) -> bool:
    """Whether a structure is a rival's law: its name, or settings of Rival with `law`."""
    if isinstance(structure, Mapping):
        return "law" in structure
    return isinstance(structure, str) and structure in Rival.laws()


def controller_structure(structure: Structure) -> tuple[dict[str, Any], str]:
    """Give the settings of Controller that a structure stands for, and its parameter set."""
    if structure is None:
        structure = "paper"
    if isinstance(structure, str):
        check_encoding("structure: ", structure)
        settings, parameters = _core.structure(structure)
        return dict(settings), parameters
    if not isinstance(structure, Mapping):
        raise ValueError(f"structure is {structure!r}; must be a name or settings of Controller")
    settings = dict(structure)
    for name in settings:
        if not isinstance(name, str):
            raise ValueError(f"structure: {name!r} is no name of a setting")
        check_encoding("structure: ", name)
    parameters = settings.pop("parameters", "shared-orders")
    if not isinstance(parameters, str):
        raise ValueError(f"structure: parameters is {parameters!r}; must be a name")
    check_encoding("structure: parameters is ", parameters)
    return settings, parameters


def _controller_box(
    structure: Structure, scenario: Scenario | None = None
) -> tuple[Controller, str, Box]:
    """Give a structure's settings, its parameter set, and its parameters with their bounds."""
    settings, parameters = controller_structure(structure)
    base = Controller.published(**settings)
    bounds = _core.parameter_bounds(base, parameters, scenario)
    return base, parameters, {name: (low, high) for name, low, high in bounds}


def _rival_box(structure: str | Mapping[str, Any]) -> tuple[Rival, Box]:
    """Give the law of a structure, and its parameters with their bounds."""
    if isinstance(structure, Mapping) and not isinstance(structure["law"], str):
        raise ValueError(f"structure: law is {structure['law']!r}; must be a name")
    rival = Rival(structure) if isinstance(structure, str) else Rival(**structure)
    return rival, {
        name: (low, high) for name, _, low, high, _ in Rival.describe(rival.law, rival.integral)
    }


def default_bounds(
    structure: str | Mapping[str, Any] | None = None, scenario: Scenario | None = None
) -> dict[str, tuple[float, float]]:
    """Give the parameters of a structure by name, with the bounds that tune() takes.

    Gains [0, 3] and orders [0.01, 1]; "extended": [0, 6] and [0.01, 2]. In the incremental form
    the integral gains end at 0.3: beyond, nearly all runs diverge. A rival's: Rival.describe().
    Those of "tracking" scale with the scenario's robot, sample time, torque limit and peak speed
    (docs/theory.md); without a scenario they are the published one's. tune() takes its first
    scenario.
    """
    if structure is not None and is_rival(structure):
        return _rival_box(structure)[1]
    return _controller_box(structure, scenario)[2]


def _sources(
    names: Sequence[str],
    frozen: Mapping[str, float] | None,
    tied: Mapping[str, str] | None,
) -> tuple[list[int], list[int], list[float]]:
    """Give the free places, and for each place its free one (or -1) and its frozen value."""
    fixed = [0.0] * len(names)
    leader = list(range(len(names)))
    for argument, given in (("frozen", frozen), ("tied", tied)):
        if given is not None and not isinstance(given, Mapping):
            raise ValueError(f"{argument} is {given!r}; must be a mapping by name")
    for name, value in dict(frozen or {}).items():
        if not is_number(value) or not np.isfinite(float(value)):
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
        hint = suggestion(name, names)
        raise ValueError(f"{argument} names {name!r}{hint}; known: {', '.join(names)}")
    return names.index(name)


def _of_sample_time(base: Controller, scenarios: Sequence[Scenario]) -> Controller:
    """Give it the scenarios' sample time; where they have several, it is made for none of them."""
    for scenario in scenarios:
        try:
            check_sample_time(base, scenario)
        except ValueError as error:
            raise ValueError(f"structure: {error}") from None
    times = {scenario.trajectory.dt for scenario in scenarios}
    return base.replace(sample_time=times.pop()) if len(times) == 1 else base


def make_search(
    structure: Structure,
    bounds: Any,
    frozen: Mapping[str, float] | None,
    tied: Mapping[str, str] | None,
    scenarios: Sequence[Scenario] = (),
) -> Search:
    """Check what tune() is given of a structure's parameters.

    The scenarios give a rival its model of the robot, and a controller its sample time.
    """
    if structure is not None and is_rival(structure):
        rival, box = _rival_box(structure)
        if scenarios and "robot" not in structure:
            rival = rival.replace(robot=scenarios[0].model or scenarios[0].robot)
        rivals = RivalSearch(*_free_box(box, bounds, frozen, tied), rival)
        for corner in (rivals.low, rivals.high):  # refuses what a rival may not have
            rivals.controller(corner)
        return rivals
    base, parameters, box = _controller_box(structure, scenarios[0] if scenarios else None)
    base = _of_sample_time(base, scenarios)
    if parameters == "tracking" and scenarios:
        base = base.replace(robot=scenarios[0].robot)
    search = ControllerSearch(*_free_box(box, bounds, frozen, tied), base, parameters)
    for corner in (search.low, search.high):  # refuses what a controller may not have
        Controller.from_json(search.controller(corner).to_json())
    return search


def _free_box(
    box: Box, bounds: Any, frozen: Mapping[str, float] | None, tied: Mapping[str, str] | None
) -> tuple[list[str], Array, Array, list[int], list[float]]:
    """Give the fields of a Search."""
    names = list(box)
    free, source, fixed = _sources(names, frozen, tied)
    own = [names[place] for place in free]
    if isinstance(bounds, Mapping):
        for name in bounds:
            _known(name, own, "bounds")
        box.update({name: _pair(name, pair) for name, pair in bounds.items()})
    elif bounds is not None:
        try:
            rows = real_numbers("bounds", bounds)
        except ValueError:
            raise ValueError(f"bounds are {bounds!r}; must be numbers ({len(own)}, 2)") from None
        if rows.shape != (len(own), 2):
            raise ValueError(
                f"bounds have the shape {rows.shape}; must be ({len(own)}, 2), for {', '.join(own)}"
            )
        box.update({name: (row[0], row[1]) for name, row in zip(own, rows, strict=True)})
    table = np.array([box[name] for name in own])
    check_bounds(table[:, 0], table[:, 1], own)
    return own, table[:, 0].copy(), table[:, 1].copy(), source, fixed


def _pair(name: str, pair: Any) -> tuple[float, float]:
    try:
        low, high = pair
        if not (is_number(low) or np.isnan(low)) or not (is_number(high) or np.isnan(high)):
            raise TypeError
        return float(low), float(high)
    except (TypeError, ValueError):
        raise ValueError(f"bounds of {name} are {pair!r}; must be (low, high)") from None
