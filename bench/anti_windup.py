"""The anti-windup rules compared: tuned incremental gains under tight torque limits.

    python bench/anti_windup.py [--all]

Six paths, four starts beside them and five limits, of which those runs count in which a torque
reaches its limit. A table by start and one by limit: for each rule the geometric mean of the costs
E (eq. 41), how often it is the best of the three, and how many runs diverge.
--all prints every run.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from nfopidn import Controller, Scenario, Trajectory, simulate

RULES = ("none", "hold", "clamp")
PATHS = ("ranunculoid", "circle", "lemniscate", "eight", "rounded_square", "sine")
LIMITS = (3.078, 1.0, 0.5, 0.25, 0.1)  # N m
STARTS = {  # added to the path's first pose: m, m, rad
    "on the path": (0.0, 0.0, 0.0),
    "0.5 m beside, 0.5 rad": (0.5, 0.0, 0.5),
    "1 m beside, 60 degrees": (1.0, 0.0, 1.0472),
    "2.2 m beside, 143 degrees": (2.0, -1.0, 2.5),
}


class Run(NamedTuple):
    """Costs and ends of one path, start and limit under the three rules."""

    path: str
    start: str
    limit: float
    costs: tuple[float, ...]
    diverged: tuple[bool, ...]


def runs() -> list[Run]:
    """Every combination in which the rule matters."""
    found = []
    controllers = [Controller.tuned_nominal().replace(anti_windup=rule) for rule in RULES]
    for path in PATHS:
        trajectory = getattr(Trajectory, path)()
        first = Scenario(trajectory).reference[0, :3]
        for start, offset in STARTS.items():
            for limit in LIMITS:
                scenario = Scenario(
                    trajectory, initial_pose=(first + offset).tolist(), torque_limit=limit
                )
                results = [simulate(scenario, controller) for controller in controllers]
                costs = tuple(result.cost for result in results)
                if len(set(costs)) > 1:
                    found.append(
                        Run(
                            path,
                            start,
                            limit,
                            costs,
                            tuple(result.diverged_at is not None for result in results),
                        )
                    )
    return found


def show(title: str, groups: list[object], found: list[Run], key: Callable[[Run], object]) -> None:
    """Print one table, a row a group."""
    print(f"\n{title:27} runs " + "".join(f"{rule:>20}" for rule in RULES))
    for group in [*groups, None]:
        chosen = [run for run in found if group is None or key(run) == group]
        if not chosen:
            continue
        costs = np.array([run.costs for run in chosen])
        best = (costs == costs.min(axis=1, keepdims=True)).sum(axis=0)
        means = np.exp(np.log(costs).mean(axis=0))
        ends = np.array([run.diverged for run in chosen]).sum(axis=0)
        cells = "".join(
            f"{mean:>9.3f} {b:3d} b {end:2d} d"
            for mean, b, end in zip(means, best, ends, strict=True)
        )
        print(f"{group or 'all':<27} {len(chosen):4d} {cells}")


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--all", action="store_true", help="print every run")
    arguments = parser.parse_args()
    found = runs()
    if arguments.all:
        for run in found:
            cells = "".join(f"{cost:11.5f}" for cost in run.costs)
            print(f"{run.path:15} {run.start:26} {run.limit:6} {cells}")
    print("mean cost, times best (b), runs that diverge (d)")
    show("start", list(STARTS), found, lambda run: run.start)
    show("torque limit [N m]", list(LIMITS), found, lambda run: run.limit)


if __name__ == "__main__":
    main()
