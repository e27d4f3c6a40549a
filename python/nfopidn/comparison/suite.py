"""The scenarios of a comparison, by name: PATH, or PATH/CONDITION."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from nfopidn._core import Robot, Scenario
from nfopidn.arguments import names_in, suggestion
from nfopidn.families.paths import LAPS, PUBLISHED, on_path
from nfopidn.tuning.parameters import ROBOT_FIELDS

#: What is changed of a scenario: a real robot is never the model.
CONDITIONS: dict[str, Callable[[Scenario], dict[str, Any]]] = {
    "mass+20%": lambda s: {"robot": _robot(s, mass=1.2)},
    "mass-20%": lambda s: {"robot": _robot(s, mass=0.8)},
    "track-0.39": lambda s: {"robot": _robot(s, track_width=0.39 / s.robot.track_width)},
    "inertia-0.294": lambda s: {"robot": _robot(s, inertia=0.294 / s.robot.inertia)},
    "coulomb": lambda _: {"coulomb_friction": 0.1},
    "disturbance": lambda _: {"disturbance": (1.0, 0.1)},
    "noise": lambda _: {"pose_noise": (0.005, 0.005)},
    "delay": lambda _: {"delay": 1},
}


def _robot(scenario: Scenario, **factors: float) -> Robot:
    own = scenario.robot
    return Robot(**{name: getattr(own, name) * factors.get(name, 1.0) for name in ROBOT_FIELDS})


def path_names() -> list[str]:
    """Name the paths of the suite."""
    return [*PUBLISHED, *(f"{name}{pace}" for name in LAPS for pace in ("", "-fast"))]


def suite_names() -> list[str]:
    """Name every scenario of the suite: all paths, and the published one in all conditions."""
    return [*path_names(), *(f"published/{name}" for name in CONDITIONS)]


def scenario_suite(names: Sequence[str] | None = None) -> dict[str, Scenario]:
    """Give scenarios of the suite by name; None: all of suite_names().

    A name is one of path_names(), or one with /CONDITION behind it: "eight-fast/noise". The
    published scenario starts where the paper's does; on the other paths the robot starts at rest,
    0.3 m beside the reference. A controller is given the reference's torques for the true robot in
    every condition: what is wrong is its own tuning, and a rival's model.

    Raises
    ------
    ValueError
        A name that is not known.
    """
    chosen: dict[str, Scenario] = {}
    for name in suite_names() if names is None else names_in("scenarios", names):
        path, _, condition = name.partition("/")
        if path not in path_names():
            hint = suggestion(path, path_names())
            known = ", ".join(path_names())
            raise ValueError(f"scenario {name!r}: unknown path{hint}; known: {known}")
        if condition and condition not in CONDITIONS:
            hint = suggestion(condition, CONDITIONS)
            known = ", ".join(CONDITIONS)
            raise ValueError(f"scenario {name!r}: unknown condition{hint}; known: {known}")
        scenario = on_path(path)
        chosen[name] = (
            scenario.replace(**CONDITIONS[condition](scenario)) if condition else scenario
        )
    return chosen
