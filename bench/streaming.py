"""Runs of a comparison a second: one by one and kept, measured one by one, and in lanes.

usage: python bench/streaming.py [--seeds N] [--workers N]

The published scenario with noise of 5 mm and 5 mrad, one controller, N draws. The first row is
what a user writes: simulate() for each draw, its figures taken in Python, every run kept. The
others are compare(): of the Mersenne twister's noise, whose runs go one by one, and of noise by
counter, whose runs go in lanes. Seconds are of the processor, all threads added, so that other work
on the machine counts little; memory is what the process has grown by, each row in a process of its
own.
"""

import argparse
import multiprocessing
import resource
import time

import nfopidn
from nfopidn.comparison import METRICS


def scenario(source: str) -> nfopidn.Scenario:
    """Give the published scenario with noise."""
    return nfopidn.Scenario.published(pose_noise=(0.005, 0.005), noise_source=source, rng=0)


def loop(seeds: int, _: int) -> float:
    """Simulate one by one, as compare() did; keep every run."""
    controller, noisy = nfopidn.Controller.recommended(), scenario("mersenne")
    runs = [nfopidn.simulate(noisy.replace(rng=seed), controller) for seed in range(seeds)]
    columns = {name: [metric.of(run) for run in runs] for name, metric in METRICS.items()}
    return float(sum(columns["cost"]))


def compared(source: str, seeds: int, workers: int) -> float:
    """Compare with a noise source."""
    controllers = {"one": nfopidn.Controller.recommended()}
    found = nfopidn.compare(controllers, {"noisy": scenario(source)}, seeds=seeds, workers=workers)
    return float(found.values["cost"].sum())


def mersenne(seeds: int, workers: int) -> float:
    """Measure one by one."""
    return compared("mersenne", seeds, workers)


def counter(seeds: int, workers: int) -> float:
    """Measure in lanes."""
    return compared("counter", seeds, workers)


ROWS = {
    "simulate(), every run kept": loop,
    "compare(), mersenne": mersenne,
    "compare(), counter": counter,
}


def measure(name: str, seeds: int, workers: int, answers) -> None:
    """Run one row and send seconds of the processor, of the clock, and kB."""
    ROWS[name](10, workers)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    processor, clock = time.process_time(), time.perf_counter()
    ROWS[name](seeds, workers)
    processor, clock = time.process_time() - processor, time.perf_counter() - clock
    answers.put((processor, clock, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before))


def main() -> None:
    """Print a row a way."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=4000)
    parser.add_argument("--workers", type=int, default=1)
    arguments = parser.parse_args()
    spawn = multiprocessing.get_context("spawn")
    print(f"{'':28} us a run, processor  runs a second  MB grown")
    for name in ROWS:
        answers = spawn.Queue()
        process = spawn.Process(
            target=measure, args=(name, arguments.seeds, arguments.workers, answers)
        )
        process.start()
        processor, clock, grown = answers.get()
        process.join()
        rate = arguments.seeds / clock
        each = 1e6 * processor / arguments.seeds
        print(f"{name:28} {each:19.1f} {rate:14.0f} {grown / 1e3:9.1f}")


if __name__ == "__main__":
    main()
