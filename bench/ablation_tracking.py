"""What each part of the tracking law is worth: the law with one part taken out, and searched again.

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
from pathlib import Path
from typing import Any

import nfopidn
import numpy as np
from nfopidn.families import Family, benchmark, simulate_many

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


def capped_mean(family: Family, controller: nfopidn.Controller) -> float:
    """Mean of min(E, 1). The family has other robots on purpose, which are not warned about."""
    return simulate_many(family, controller.replace(robot=None)).mean_cost


def search(family: Family, variant: str, seed: int, options: argparse.Namespace) -> float:
    """Search for a variant; give its mean."""
    changes, frozen = VARIANTS[variant]
    result = nfopidn.tune(
        family,
        robustness=None,
        structure=LAW | changes,
        frozen=frozen,
        method="cma",
        rng=seed,
        maxfev=options.maxfev,
        workers=options.workers,
    )
    return capped_mean(family, result.controller)


def run(name: str, options: argparse.Namespace) -> dict[str, list[float]]:
    """Print a family's table; give every seed's mean by variant."""
    family = benchmark(name)[:: options.every]
    print(f"\n{name}: {len(family)} scenarios, {options.maxfev} evaluations, ", end="")
    print(
        f"{options.seeds} seeds\n| variant | mean E | loss | seeds | s |\n| --- | ---: " * 1, end=""
    )
    print("| ---: | ---: | ---: |")
    found: dict[str, list[float]] = {}
    for variant in VARIANTS:
        begin = time.perf_counter()
        found[variant] = [
            search(family, variant, seed, options) for seed in range(1, options.seeds + 1)
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
