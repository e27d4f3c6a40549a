"""The families of scenarios on which laws are compared: R, G, J and J++ of docs/theory.md.

In all of them the reference torques are those of the scenario's own robot, and the integrator is
the semi-implicit Euler's.
"""

from __future__ import annotations

from typing import Any

from nfopidn._core import Robot, Scenario
from nfopidn.families.family import Family
from nfopidn.families.paths import LAPS, PUBLISHED, beside_the_start, on_path

_EDDIE = Robot.eddie()

#: What R changes of the paper's scenario, with the change in words.
_CONDITIONS: dict[str, tuple[dict[str, Any], str]] = {
    "nominal": ({}, ""),
    "substeps-4": ({"substeps": 4}, "4 integration steps a sample"),
    "substeps-20": ({"substeps": 20}, "20 integration steps a sample"),
    "mass-13.8": ({"robot": _EDDIE.replace(mass=13.8)}, "mass 13.8 kg"),
    "mass-9.2": ({"robot": _EDDIE.replace(mass=9.2)}, "mass 9.2 kg"),
    "inertia-0.294": ({"robot": _EDDIE.replace(inertia=0.294)}, "inertia 0.294 kg m^2"),
    "track-0.39": ({"robot": _EDDIE.replace(track_width=0.39)}, "track 0.39 m"),
    "coulomb-0.1": ({"coulomb_friction": 0.1}, "Coulomb friction 0.1 N m a wheel"),
    "coulomb-0.2": ({"coulomb_friction": 0.2}, "Coulomb friction 0.2 N m a wheel"),
    "disturbance": ({"disturbance": (2.0, 0.2)}, "disturbance 2 N and 0.2 N m"),
    "noise": ({"pose_noise": (0.005, 0.005)}, "pose noise 5 mm and 5 mrad"),
    "delay": ({"delay": 1}, "1 sample of delay"),
}
_GENERAL = ("nominal", "coulomb-0.1", "delay")
#: What J++ adds where delay and finer integration meet.
_CORNERS: dict[str, tuple[dict[str, Any], str]] = {
    "delay,substeps-4": (
        {"delay": 1, "substeps": 4},
        "1 sample of delay, 4 integration steps a sample",
    ),
    "delay,substeps-4,inertia-0.294,track-0.39": (
        {"delay": 1, "substeps": 4, "robot": _EDDIE.replace(inertia=0.294, track_width=0.39)},
        "1 sample of delay, 4 integration steps a sample, inertia 0.294 kg m^2, track 0.39 m",
    ),
}


def _general_paths() -> dict[str, Scenario]:
    """Give the nine paths of G at both speeds."""
    paths = {}
    for pace, suffix in ((1.0, ""), (3.0, "-fast")):
        for heading in ("forward", "continuous"):
            name = "ranunculoid" if heading == "forward" else "ranunculoid-continuous"
            paths[name + suffix] = beside_the_start("ranunculoid", 150.0 / pace, heading=heading)
        for name in LAPS:
            paths[name + suffix] = on_path(name + suffix)
    return paths


def _product(
    paths: dict[str, Scenario], conditions: dict[str, tuple[dict[str, Any], str]]
) -> Family:
    return Family.of(
        (f"{path}/{name}", scenario.replace(**change), words)
        for path, scenario in paths.items()
        for name, (change, words) in conditions.items()
    )


def _robot_family() -> Family:
    return _product({name: on_path(name) for name in PUBLISHED}, _CONDITIONS)


def _general_family() -> Family:
    return _product(_general_paths(), {name: _CONDITIONS[name] for name in _GENERAL})


def _corner_family() -> Family:
    published = {name: on_path(name) for name in PUBLISHED}
    return _product({**published, **_general_paths()}, _CORNERS)


def benchmark(name: str) -> Family:
    """Give a family on which laws are compared.

    ===== ==== ==================================================================
    name  size scenarios
    ===== ==== ==================================================================
    "R"   36   the paper's path in three ways, the robot in twelve conditions
    "G"   54   nine paths at two speeds: nominal, with Coulomb friction, with delay
    "J"   90   R and G
    "J++" 132  J, and on every path delay with finer integration, and with a wrong robot
    ===== ==== ==================================================================

    Raises
    ------
    ValueError
        Another name.
    """
    parts = {
        "R": (_robot_family,),
        "G": (_general_family,),
        "J": (_robot_family, _general_family),
        "J++": (_robot_family, _general_family, _corner_family),
    }
    if name not in parts:
        raise ValueError(f"benchmark is {name!r}; must be one of {', '.join(parts)}")
    first, *others = (make() for make in parts[name])
    for family in others:
        first += family
    return first
