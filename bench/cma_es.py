"""CMA-ES beside pycma and bfoa+, at the same number of evaluations.

    python bench/cma_es.py                   the analytic test functions
    python bench/cma_es.py --structures      and the tuning problems of bench/optimisers.py

Exit code 1 where a bar is missed: on the functions the medians must lie within ten times pycma's,
where costs under 1e-10 count as 1e-10, and Rastrigin's function must be solved as often. pycma is
left out where it is not installed.
"""

import argparse
import sys
import time
from typing import Any

import nfopidn
import numpy as np
from optimisers import BUDGET, FUNCTIONS, ROWS, header, pycma, rival_costs, show

FLOOR = 1e-10  # lower costs are equally good
FACTOR = 10.0  # of pycma's median
SOLVED = (1.0, 2.0, 5.0)  # costs of Rastrigin's function up to which seeds are counted


def functions(seeds: int) -> bool:
    """The analytic functions of bench/optimisers.py; whether all bars are met."""
    met = True
    for name, (function, half, _) in FUNCTIONS.items():
        shift = np.random.default_rng(99).uniform(-0.3, 0.3, 11) * half
        box = np.tile([-half, half], (11, 1))

        def block(points: np.ndarray, function: Any = function, at: Any = shift) -> np.ndarray:
            return function(points - at)

        header(f"{name}, 11 dimensions, {BUDGET} evaluations, {seeds} seeds")
        own: list[float] = []
        for method in ("bfoa+", "cma"):
            start = time.perf_counter()
            own = [
                nfopidn.bfoa(
                    block, box, method=method, rng=seed, maxfev=BUDGET, vectorized=True
                ).fun
                for seed in range(1, seeds + 1)
            ]
            show(method, own, time.perf_counter() - start)
        start = time.perf_counter()
        rival = rival_costs(pycma, block, box, seeds)
        show("pycma with restarts", rival, time.perf_counter() - start)
        if not rival:
            continue
        ratio = max(np.median(own), FLOOR) / max(np.median(rival), FLOOR)
        good = ratio <= FACTOR
        print(f"median {ratio:.2g} times pycma's, bar {FACTOR:g}{'' if good else '  MISSED'}")
        if name == "Rastrigin":
            for limit in SOLVED:
                counts = [int((np.array(costs) < limit).sum()) for costs in (own, rival)]
                print(f"seeds under {limit:g}: cma {counts[0]}, pycma {counts[1]}")
            good &= bool(np.mean(own) <= np.mean(rival))
        met &= bool(good)
    return met


def structures(seeds: int) -> None:
    """The tuning problems; pycma searches the same box in proportion, as it knows no other."""
    for row, (structure, changes, bounds, _, _) in ROWS.items():
        if structure == "taps":
            continue
        header(f"{row}, {BUDGET} evaluations, {seeds} seeds")
        scenario = nfopidn.Scenario.published(rng=0, **changes)
        shared: dict[str, Any] = {"structure": structure, "bounds": bounds}
        for method in ("bfoa+", "cma"):
            start = time.perf_counter()
            costs = [
                nfopidn.tune(
                    scenario, robustness=None, method=method, rng=seed, maxfev=BUDGET, **shared
                ).fun
                for seed in range(1, seeds + 1)
            ]
            show(method, costs, time.perf_counter() - start)
        objective = nfopidn.Objective(scenario, **shared)
        start = time.perf_counter()
        costs = rival_costs(pycma, objective.costs, objective.bounds, seeds)
        show("pycma with restarts", costs, time.perf_counter() - start)


def main() -> int:
    """Run what is asked for; 1 if a bar is missed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=25)
    parser.add_argument("--structures", action="store_true")
    arguments = parser.parse_args()
    met = functions(arguments.seeds)
    if arguments.structures:
        structures(arguments.seeds)
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
