"""What each part of the tracking law is worth: the law with one part taken out, searched anew.

    python bench/ablation_tracking.py [--family R G J J++] [--seeds 5] [--maxfev 10000]
                                      [--workers N] [--json FILE]
    python bench/ablation_tracking.py --quick      a few scenarios and evaluations, in a minute

Every variant has the same budget, the same method (cma) and the same seeds. A row gives the mean of
min(E, 1) over the family, the median of the seeds, and the loss against the whole law.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import nfopidn
import numpy as np
from nfopidn import Robot, Scenario, Trajectory

LAW = {
    "gains": [[0.0] * 3] * 3,
    "allocation": "decoupled",
    "net": "speed-errors",
    "lateral": "scheduled",
    "generator": "gl",
    "parameters": "tracking",
}
AMPLITUDES = ("amplitude_x", "amplitude_y", "amplitude_theta")
POLES = ("pole_x", "pole_theta")
INTEGRAL = {"integral_x": 0.0, "integral_y": 0.0, "integral_theta": 0.0}
ORDERS = ("speed_order_x", "speed_order_theta")
# By name: what of the settings is another, and what is frozen.
VARIANTS: dict[str, tuple[dict[str, Any], dict[str, float]]] = {
    "the whole law": ({}, {}),
    "errors differentiated, not speed errors": ({"net": "whole"}, {}),
    "neuron linear": ({"activation": "linear"}, dict.fromkeys(AMPLITUDES, 1.0)),
    "amplitudes all 1": ({}, dict.fromkeys(AMPLITUDES, 1.0)),
    "no integral states": (
        {},
        {**INTEGRAL, "integral_retention": 1.0, "integral_limit": 1.0},
    ),
    "lateral error by direction alone": (
        {"lateral": "direction"},
        {"lateral_speed": 0.25, "lateral_power": 1.5},
    ),
    "no pole": ({}, dict.fromkeys(POLES, 0.0)),
    "orders 1": ({}, dict.fromkeys(ORDERS, 1.0)),
}
PLANTS: dict[str, dict[str, Any]] = {
    "nominal": {},
    "substeps 4": {"substeps": 4},
    "substeps 20": {"substeps": 20},
    "mass 13.8": {"robot": Robot(mass=13.8)},
    "mass 9.2": {"robot": Robot(mass=9.2)},
    "inertia 0.294": {"robot": Robot(inertia=0.294)},
    "track 0.39": {"robot": Robot(track_width=0.39)},
    "Coulomb 0.1": {"coulomb_friction": 0.1},
    "Coulomb 0.2": {"coulomb_friction": 0.2},
    "disturbance": {"disturbance": (2.0, 0.2)},
    "noise": {"pose_noise": (0.005, 0.005)},
    "delay 1": {"delay": 1},
}
CONDITIONS = ("nominal", "Coulomb 0.1", "delay 1")
CORNERS: tuple[dict[str, Any], ...] = (
    {"delay": 1, "substeps": 4},
    {"delay": 1, "substeps": 4, "robot": Robot(inertia=0.294, track_width=0.39)},
)


def paper_runs() -> list[Scenario]:
    """P, C and F of the experiment: the published scenario, continuous, and at three times."""
    return [
        Scenario.published(rng=0),
        Scenario.published(rng=0, heading="continuous"),
        Scenario.published(rng=0, heading="continuous", period=50.0),
    ]


def paths(fast: bool) -> Iterator[Scenario]:
    """The nine paths of G, started 0.3 m to the side."""
    share = 3.0 if fast else 1.0
    for name, period, more in (
        ("ranunculoid", 150.0, {}),
        ("ranunculoid", 150.0, {"heading": "continuous"}),
        ("ranunculoid", 240.0, {"cusps": 5}),
        ("circle", 45.0, {}),
        ("lemniscate", 45.0, {}),
        ("eight", 60.0, {}),
        ("sine", 30.0, {}),
        ("rounded_square", 60.0, {}),
        ("line", 20.0, {}),
    ):
        path: Trajectory = getattr(Trajectory, name)(period=period / share, dt=0.2, **more)
        start = (path.x[0], path.y[0] + 0.3, path.theta[0])
        yield Scenario(path, initial_pose=start, rng=0)


def family(name: str) -> list[Scenario]:
    """Give the scenarios of R, G, J or J++, the published one first in those that have it."""
    robust = [run.replace(**plant) for run in paper_runs() for plant in PLANTS.values()]
    general = [
        path.replace(**PLANTS[condition])
        for fast in (False, True)
        for path in paths(fast)
        for condition in CONDITIONS
    ]
    if name == "R":
        return robust
    if name == "G":
        return general
    corners = [
        one.replace(**corner) for one in [*paper_runs(), *paths(False)] for corner in CORNERS
    ]
    return robust + general + (corners if name == "J++" else [])


def capped_mean(scenarios: list[Scenario], controller: nfopidn.Controller) -> float:
    """Mean of min(E, 1), without a word of robots that the family makes other ones of."""
    anyones = controller.replace(robot=None)
    costs = [nfopidn.simulate(scenario, anyones).cost for scenario in scenarios]
    return float(np.mean(np.minimum(costs, 1.0)))


def search(
    scenarios: list[Scenario], variant: str, seed: int, options: argparse.Namespace
) -> float:
    """Search for a variant; give its mean."""
    changes, frozen = VARIANTS[variant]
    result = nfopidn.tune(
        scenarios,
        structure=LAW | changes,
        frozen=frozen,
        method="cma",
        rng=seed,
        maxfev=options.maxfev,
        workers=options.workers,
    )
    return capped_mean(scenarios, result.controller)


def run(name: str, options: argparse.Namespace) -> dict[str, list[float]]:
    """Print a family's table; give every seed's mean by variant."""
    scenarios = family(name)[:: options.every]
    print(f"\n{name}: {len(scenarios)} scenarios, {options.maxfev} evaluations, ", end="")
    print(
        f"{options.seeds} seeds\n| variant | mean E | loss | seeds | s |\n| --- | ---: " * 1, end=""
    )
    print("| ---: | ---: | ---: |")
    found: dict[str, list[float]] = {}
    for variant in VARIANTS:
        begin = time.perf_counter()
        found[variant] = [
            search(scenarios, variant, seed, options) for seed in range(1, options.seeds + 1)
        ]
        median = float(np.median(found[variant]))
        loss = median / float(np.median(found["the whole law"])) - 1
        spread = f"{min(found[variant]):.4f} to {max(found[variant]):.4f}"
        seconds = time.perf_counter() - begin
        print(f"| {variant} | {median:.4f} | {loss:+.1%} | {spread} | {seconds:.0f} |", flush=True)
    return found


def main() -> None:
    """Search, print, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    names = ("R", "G", "J", "J++")
    parser.add_argument("--family", nargs="+", choices=names, default=list(names))
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--maxfev", type=int, default=10000)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--json", type=Path, help="write every seed's mean here")
    parser.add_argument(
        "--quick", action="store_true", help="one seed, few scenarios: whether it runs"
    )
    options = parser.parse_args()
    options.every = 1
    if options.quick:
        options.family, options.seeds, options.maxfev, options.every = ["J"], 1, 300, 9
    results = {name: run(name, options) for name in options.family}
    if options.json:
        options.json.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
