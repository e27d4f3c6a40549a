"""The paths that families and comparisons run on, by name, and families over paths."""

from __future__ import annotations

from collections.abc import Mapping
from math import cos, sin
from typing import Any

from nfopidn._core import Scenario, Trajectory
from nfopidn.families.family import Family

#: Times of a lap [s]: slow ones peak at about 0.3 m/s, as the paper's robot does; fast ones are
#: a third of them.
LAPS: dict[str, tuple[str, dict[str, Any], float]] = {
    "five-cusps": ("ranunculoid", {"cusps": 5}, 240.0),
    "circle": ("circle", {}, 45.0),
    "lemniscate": ("lemniscate", {}, 45.0),
    "eight": ("eight", {}, 60.0),
    "sine": ("sine", {}, 30.0),
    "rounded-square": ("rounded_square", {}, 60.0),
    "line": ("line", {}, 20.0),
}

#: Those of the paper's path, which starts where the paper's does.
PUBLISHED: dict[str, dict[str, Any]] = {
    "published": {},
    "continuous": {"heading": "continuous"},
    "continuous-fast": {"heading": "continuous", "period": 50.0},
}

#: How far beside the start of the other paths [m] the robot starts, at rest.
_START = 0.3


def beside_the_start(curve: str, period: float, **arguments: Any) -> Scenario:
    """Make a scenario on a named path at dt 0.2 s, whose robot rests 0.3 m beside the start."""
    trajectory = getattr(Trajectory, curve)(period=period, dt=0.2, **arguments)
    start = trajectory.x[0], trajectory.y[0] + _START, trajectory.theta[0]
    return Scenario(trajectory, initial_pose=start, rng=0)


def on_path(name: str) -> Scenario:
    """Make the scenario of a name in PUBLISHED, or of one in LAPS with or without "-fast"."""
    if name in PUBLISHED:
        return Scenario.published(rng=0, **PUBLISHED[name])
    curve, arguments, lap = LAPS[name.removesuffix("-fast")]
    return beside_the_start(curve, lap / 3 if name.endswith("-fast") else lap, **arguments)


def over_paths(scenario: Scenario, paths: Mapping[str, Trajectory]) -> Family:
    """Give a family of a scenario's robot on other paths.

    The robot starts as far from each path's start, and turned as far from it, as on the scenario's.

    Parameters
    ----------
    scenario
        Everything but the path.
    paths
        By name.

    Raises
    ------
    ValueError
        No path, one that is no Trajectory, or a disturbance given sample by sample.
    """
    if not isinstance(paths, Mapping):
        raise ValueError(f"paths is {paths!r}; must be Trajectories by name")
    if not isinstance(scenario.disturbance, tuple):
        raise ValueError("disturbance is one pair a sample of the scenario's path; must be one")
    members = []
    for name, path in paths.items():
        if not isinstance(path, Trajectory):
            raise ValueError(f"paths[{name!r}] is {path!r}; must be a Trajectory")
        pose = _as_far(scenario, path)
        lap = f"{path.name}, {len(path)} samples of {path.dt:g} s, up to {path.peak_speed:.3g} m/s"
        members.append((name, scenario.replace(trajectory=path, initial_pose=pose), lap))
    return Family.of(members)


def _as_far(scenario: Scenario, path: Trajectory) -> tuple[float, float, float] | None:
    if scenario.initial_pose is None:
        return None
    own = scenario.trajectory
    x, y, theta = scenario.initial_pose
    turn = path.theta[0] - own.theta[0]
    ahead, beside = x - own.x[0], y - own.y[0]
    return (
        float(path.x[0] + cos(turn) * ahead - sin(turn) * beside),
        float(path.y[0] + sin(turn) * ahead + cos(turn) * beside),
        float(theta + turn),
    )
