"""Rates of Monte Carlo runs: lanes, a process pool of simulate(), numba, side by side.

Each round measures all of them in turn, and the best of each counts, so that a machine that is busy
with other things disturbs the ratios little. The scenario is the published one, 751 samples, with
mass, inertia, track and wheel radius drawn, with and without noise of 5 mm and 5 mrad.

    python bench/monte_carlo.py            # rates and ratios on all processors
    python bench/monte_carlo.py --million  # one million noisy runs as well: seconds, and memory
"""

from __future__ import annotations

import argparse
import os
import resource
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from typing import Any

import numpy as np
from nfopidn import Controller, Objective, Robot, Scenario, _core, monte_carlo, simulate
from nfopidn.montecarlo import Normal, Uniform
from nfopidn.montecarlo.draws import Draws

NOISE = (0.005, 0.005)
DRAWN = {
    "mass": Normal(11.5, 0.5),
    "inertia": Normal(0.5873, 0.05),
    "track_width": Uniform(0.43, 0.47),
    "wheel_radius": Uniform(0.074, 0.078),
}
BARS = {"calm": 1.5, "noisy": 3.0, "pool": 13.0, "numba": 8.0}


def processors() -> int:
    """Return how many there are for this process."""
    return len(os.sched_getaffinity(0))


def best(work: dict[str, Callable[[], Any]], rounds: int, clock: Callable[[], float]) -> Any:
    """Return the least time of each, the rounds alternating between them."""
    times = {name: float("inf") for name in work}
    for _ in range(rounds):
        for name, one in work.items():
            begin = clock()
            one()
            times[name] = min(times[name], clock() - begin)
    return times


def lanes(controller: Controller, structure: str, rounds: int) -> dict[str, float]:
    """Return ns a step and lane: candidates on one robot, and runs with a robot each."""
    count = 4096
    calm = Scenario.published(rng=0)
    noisy = calm.replace(pose_noise=NOISE)
    objective = Objective(calm, structure=structure)
    x = objective.parameters_of(controller)
    points = x * (1 + 0.02 * (2 * np.random.default_rng(0).random((count, len(x))) - 1))
    draws = Draws(DRAWN, n=count, seed=1, method="independent", covariance=None)
    values = draws.values(0, count)
    own = {
        name: _core.DrawnRuns(scenario, controller, draws.names)
        for name, scenario in (("calm", calm), ("noisy", noisy))
    }
    work = {
        "one robot": lambda: objective.costs(points),
        "calm": lambda: own["calm"].costs(values, 1, 1, 1),
        "noisy": lambda: own["noisy"].costs(values, 1, 1, 1),
    }
    steps = count * len(calm.trajectory.t)
    times = best(work, rounds, time.process_time)
    return {name: seconds / steps * 1e9 for name, seconds in times.items()}


def friction(controller: Controller, rounds: int) -> dict[str, float]:
    """Return ns a step and lane with Coulomb friction drawn, by integrator."""
    times = {}
    for integrator, count in (("semi-implicit-euler", 2048), ("exact", 64)):
        scenario = Scenario.published(rng=0, integrator=integrator)
        drawn = {**DRAWN, "coulomb_friction": Uniform(0, 0.1)}
        draws = Draws(drawn, n=count, seed=1, method="independent", covariance=None)
        runs, values = _core.DrawnRuns(scenario, controller, draws.names), draws.values(0, count)
        work = {integrator: lambda runs=runs, values=values: runs.costs(values, 1, 1, 1)}
        steps = count * len(scenario.trajectory.t)
        seconds = best(work, rounds, time.process_time)[integrator]
        times[integrator] = seconds / steps * 1e9
    return times


def _simulate_some(task: tuple[Scenario, Controller, np.ndarray, int]) -> list[float]:
    scenario, controller, values, seed = task
    costs = []
    for place, (mass, inertia, track, radius) in enumerate(values):
        robot = Robot(mass, inertia, track, radius)
        one = scenario.replace(robot=robot, model=scenario.robot, rng=seed + place)
        costs.append(simulate(one, controller).cost)
    return costs


def numba_loop() -> Callable[..., np.ndarray] | None:
    """Return the published loop over runs on all threads, compiled; None without numba."""
    try:
        import numba
    except ImportError:
        return None

    @numba.njit(parallel=True)
    def run(
        reference: np.ndarray, taps: np.ndarray, values: np.ndarray, start: np.ndarray, noise: float
    ) -> np.ndarray:
        count, dt, limit, pi = taps.shape[1], 0.2, 3.078, np.pi
        costs = np.empty(len(values))
        for run in numba.prange(len(values)):
            mass, inertia, track, radius = values[run]
            drive = dt / (mass * radius)
            steer = dt * track / (2 * inertia * radius)
            past = np.zeros((3, count))
            x, y, theta = start
            v = omega = total = 0.0
            for k in range(len(reference)):
                at = reference[k]
                dx, dy = at[0] - x, at[1] - y
                e = (at[2] - theta + pi) % (2 * pi) - pi
                seen_x, seen_y, seen = dx, dy, theta
                if noise > 0:
                    # numba has a generator of its own behind this name, one a thread.
                    seen_x -= noise * np.random.standard_normal()  # noqa: NPY002
                    seen_y -= noise * np.random.standard_normal()  # noqa: NPY002
                    seen += noise * np.random.standard_normal()  # noqa: NPY002
                c, s = np.cos(seen), np.sin(seen)
                for row in range(3):
                    for j in range(count - 1, 0, -1):
                        past[row, j] = past[row, j - 1]
                past[0, 0] = c * seen_x + s * seen_y
                past[1, 0] = c * seen_y - s * seen_x
                past[2, 0] = (at[2] - seen + pi) % (2 * pi) - pi
                nx = ny = nt = 0.0
                for j in range(count):
                    nx += taps[0, j] * past[0, j]
                    ny += taps[1, j] * past[1, j]
                    nt += taps[2, j] * past[2, j]
                ox, oy, ot = np.tanh(nx / 2), np.tanh(ny / 2), np.tanh(nt / 2)
                left = min(max(at[5] + oy + ot, -limit), limit)
                right = min(max(at[6] + ox + oy, -limit), limit)
                total += dx * dx + dy * dy + e * e + (at[5] - left) ** 2 + (at[6] - right) ** 2
                c, s = np.cos(theta), np.sin(theta)
                v += drive * (left + right)
                omega += steer * (left - right)
                x += dt * v * c
                y += dt * v * s
                theta += dt * omega
            costs[run] = total / len(reference)
        return costs

    return run


def rates(rounds: int, noise: tuple[float, float]) -> dict[str, float]:
    """Return runs a second on all processors, of the published controller."""
    workers = processors()
    controller = Controller.published()
    scenario = Scenario.published(pose_noise=noise, rng=0)
    few, many = 1000, 40000
    draws = Draws(DRAWN, n=many, seed=1, method="independent", covariance=None)
    values = np.ascontiguousarray(draws.values(0, many)[:, [draws.names.index(n) for n in DRAWN]])
    loop = numba_loop()
    with ProcessPoolExecutor(workers) as pool:
        shares = [
            (scenario, controller, values[first:few:workers], 1000 * first)
            for first in range(workers)
        ]
        work: dict[str, Callable[[], Any]] = {
            "lanes": lambda: monte_carlo(
                scenario, controller, many, rng=1, distributions=DRAWN, workers=workers
            ),
            "pool": lambda: list(pool.map(_simulate_some, shares)),
        }
        counts = {"lanes": many, "pool": few}
        if loop is not None:
            request = (scenario.reference, controller.taps, values, np.array([4.0, 0.0, 1.0472]))
            check = loop(*request[:2], values[:50], request[3], 0.0)
            calm = monte_carlo(
                scenario.replace(pose_noise=(0, 0)), controller, 50, rng=1, distributions=DRAWN
            )
            assert (values[:50, 0] == calm.parameters["mass"]).all()
            np.testing.assert_allclose(check, calm.costs, rtol=1e-6)  # the same loop
            work["numba"] = lambda: loop(*request, noise[0])
            counts["numba"] = many
        for one in work.values():
            one()
        times = best(work, rounds, time.perf_counter)
    return {name: counts[name] / seconds for name, seconds in times.items()}


def million() -> None:
    """Print what one million noisy runs take, and the memory besides their column."""
    scenario = Scenario.published(pose_noise=NOISE, rng=0)
    for name, controller in (
        ("published", Controller.published()),
        ("recommended", Controller.recommended()),
    ):
        monte_carlo(scenario, controller, 1000, rng=1, distributions=DRAWN)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        begin, used = time.perf_counter(), time.process_time()
        monte_carlo(scenario, controller, 10**6, rng=1, distributions=DRAWN, workers=processors())
        seconds, used = time.perf_counter() - begin, time.process_time() - used
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        print(
            f"1,000,000 noisy runs, {name}: {seconds:.2f} s on {processors()} processors "
            f"({used:.2f} s of processor time), {grown:.0f} MB more memory, column 8 MB"
        )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--million", action="store_true")
    arguments = parser.parse_args()
    print("ns a step and lane      one robot   a robot each   ratio   and noise   ratio")
    for name, controller, structure in (
        ("published", Controller.published(), "paper"),
        ("recommended", Controller.recommended(), "tracking"),
    ):
        one = lanes(controller, structure, arguments.rounds)
        calm, noisy = one["calm"] / one["one robot"], one["noisy"] / one["one robot"]
        print(
            f"{name:22} {one['one robot']:10.2f} {one['calm']:14.2f} {calm:7.2f} "
            f"{one['noisy']:11.2f} {noisy:7.2f}"
        )
    print(f"{'bar':22} {'':10} {'':14} {BARS['calm']:7.1f} {'':11} {BARS['noisy']:7.1f}")
    rubbing = friction(Controller.recommended(), arguments.rounds)
    for integrator, nanoseconds in rubbing.items():
        print(f"Coulomb friction drawn, {integrator}: {nanoseconds:.1f} ns a step and lane")
    for words, noise in (("noisy", NOISE), ("calm", (0.0, 0.0))):
        found = rates(arguments.rounds, noise)
        print(f"{words} runs a second on {processors()} processors, published controller")
        for name, rate in found.items():
            ratio = "" if name == "lanes" else f"   lanes are {found['lanes'] / rate:5.1f} x"
            bar = f"   bar {BARS[name]:g} x" if name in BARS else ""
            print(f"  {name:6} {rate:10.0f}{ratio}{bar}")
        if "numba" not in found:
            print("  numba is not installed")
    if arguments.million:
        million()


if __name__ == "__main__":
    main()
