"""Runs of a search over several objectives: what their metrics cost beside the cost alone.

usage: python bench/pareto.py [--evaluations N]

A generation of 100 controllers of the extended structure on the published scenario, with one Euler
step a sample and with the accurate integrator: microseconds of the processor a run, on one thread,
for the cost in lanes (what a search for one cost asks for) and for every metric, one by one (what a
front asks for). Then whole searches for fronts over two objectives, and what of them is pymoo's.
"""

import argparse
import time

import nfopidn
import numpy as np
from nfopidn import _core

OBJECTIVES = ("position_rms", "torque_variation")


def microseconds(work, runs: int) -> float:
    """Give the least processor time of five, a run."""
    times = []
    for _ in range(5):
        begun = time.process_time()
        work()
        times.append(time.process_time() - begun)
    return 1e6 * min(times) / runs


def generation(scenario: nfopidn.Scenario) -> tuple[float, float]:
    """Give microseconds a run in lanes and one by one."""
    objective = nfopidn.Objective(scenario, structure="extended")
    best = nfopidn.tune(scenario, structure="extended", robustness=None, rng=1, maxfev=2000)
    rng = np.random.default_rng(0)
    low, high = objective.bounds.T
    points = np.clip(best.x * rng.uniform(0.9, 1.1, (100, len(best.x))), low, high)
    controllers = [objective.controller(x) for x in points]
    return (
        microseconds(lambda: objective.costs(points), len(points)),
        microseconds(lambda: _core.measure_runs([scenario], controllers, 1), len(points)),
    )


def search(evaluations: int, **changes) -> None:
    """Print a search's processor time, and the share of its native runs."""
    native = 0.0
    measure_runs = _core.measure_runs

    def measured(*arguments, **settings):
        nonlocal native
        begun = time.process_time()
        rows = measure_runs(*arguments, **settings)
        native += time.process_time() - begun
        return rows

    _core.measure_runs = measured
    begun = time.process_time()
    front = nfopidn.tune(objectives=OBJECTIVES, rng=1, maxfev=evaluations, **changes)
    whole = time.process_time() - begun
    _core.measure_runs = measure_runs
    scenarios = len(front.family) if "family" in front else 1
    print(
        f"{scenarios:3} scenarios, {front.nfev} evaluations: {whole:6.2f} s of the processor, "
        f"{native:6.2f} s in native runs, {len(front)} points"
    )


def main() -> None:
    """Print all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--evaluations", type=int, default=10_000)
    evaluations = parser.parse_args().evaluations
    print(f"{'':20} us a run: cost in lanes   metrics one by one")
    for integrator in ("semi-implicit-euler", "exact"):
        scenario = nfopidn.Scenario.published(rng=0, integrator=integrator)
        lanes, alone = generation(scenario)
        print(f"{integrator:20} {lanes:23.2f} {alone:20.1f}")
    search(evaluations, robustness=None, structure="extended")
    search(evaluations)


if __name__ == "__main__":
    main()
