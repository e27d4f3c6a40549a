"""What each engine of workers= costs a block, and what two cores gain by it.

    python bench/engines.py [--runs N] [--engines pool loky dask mpi threads]

Blocks: 2000 points in 111 blocks of a cheap Python function, block after block, as a search asks
for costs. Runs: a Monte Carlo analysis with noise, whose costs are compared to the bit; the time by
the clock, the processor time a run of all processes together, and its share that one thread needs.
Answers: how fast the main process takes numbers in. Needs the extra `scale`, and for MPI Debian's
openmpi-bin.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import ExitStack, contextmanager
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from nfopidn import Controller, Scenario, monte_carlo
from nfopidn.engines import Work, read_workers
from nfopidn.engines.serving import worker_name
from nfopidn.families.runs import family_of
from nfopidn.montecarlo import Normal, Uniform
from nfopidn.montecarlo.draws import Draws
from nfopidn.montecarlo.runs import Analysis

BLOCKS = np.array_split(np.random.default_rng(1).uniform(-2, 2, (2000, 18)), 111)
NOISY = Scenario.published(pose_noise=(0.005, 0.005), rng=0)
DRAWN = {
    "mass": Normal(11.5, 0.5),
    "inertia": Normal(0.5873, 0.05),
    "track_width": Uniform(0.43, 0.47),
    "wheel_radius": Uniform(0.074, 0.078),
}
CORES = 2
ANSWERS = 10**6  # numbers of a block, 8 MB
#: [ms] a block at most.
BARS = {"pool": 1.6, "loky": 1.6, "dask": 15.0}


def cheap(x: np.ndarray) -> float:
    """Sum squares."""
    return float(((x - 0.3) ** 2).sum())


def numbers(span: tuple[int, int]) -> np.ndarray:
    """Give an answer as large as a million runs'."""
    return np.zeros(ANSWERS)


@contextmanager
def pool() -> Iterator[object]:
    """Python's processes."""
    with ProcessPoolExecutor(CORES) as executor:
        yield executor


@contextmanager
def threads() -> Iterator[object]:
    """Python's threads."""
    with ThreadPoolExecutor(CORES) as executor:
        yield executor


@contextmanager
def reusable() -> Iterator[object]:
    """Processes of loky."""
    import loky

    with loky.get_reusable_executor(CORES) as executor:
        yield executor


@contextmanager
def dask() -> Iterator[object]:
    """A Dask cluster of this machine."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(
            n_workers=CORES,
            threads_per_worker=1,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            silence_logs=50,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client


@contextmanager
def mpi() -> Iterator[object]:
    """Ranks of MPI: this is rank 0."""
    from mpi4py.futures import MPIPoolExecutor

    with MPIPoolExecutor() as executor:
        yield executor


@contextmanager
def serial() -> Iterator[object]:
    """Nobody: the core alone, on one thread."""
    yield 1


@contextmanager
def core() -> Iterator[object]:
    """Threads of the core, for native work alone."""
    yield CORES


ENGINES: dict[str, Callable] = {
    "serial": serial,
    "core": core,
    "threads": threads,
    "pool": pool,
    "loky": reusable,
    "dask": dask,
    "mpi": mpi,
}


def costs(points: np.ndarray) -> list[float]:
    """Do the job of a block, or of a part of it."""
    return [cheap(x) for x in points]


def do_blocks(work: Work | None) -> float:
    """Evaluate the blocks one after the other."""
    total = 0.0
    for points in BLOCKS:
        if work is None:
            total += sum(costs(points))
            continue
        for block in work.blocks(len(points), lambda at, size, own=points: own[at : at + size]):
            total += sum(block.answer)
    return total


def block_times(workers: object, rounds: int) -> tuple[float, float]:
    """Give the least ms a block by the clock, and those of the main process at work."""
    best, busy = np.inf, np.inf
    with ExitStack() as stack:
        work = None
        if not isinstance(workers, int):
            work = stack.enter_context(Work(read_workers(workers), costs, "costs"))
        for _ in range(1 + 3 * rounds):  # the first one starts the workers
            begun, used = perf_counter(), process_time()
            do_blocks(work)
            best, busy = min(best, perf_counter() - begun), min(busy, process_time() - used)
    return 1e3 * best / len(BLOCKS), 1e3 * busy / len(BLOCKS)


def run_times(workers: object, runs: int, rounds: int) -> tuple[float, str]:
    """Give the best time of a Monte Carlo analysis [s], and its costs' bits."""
    best, bits = np.inf, ""
    for count in [max(1, runs // 10), *[runs] * rounds]:
        begun = perf_counter()
        found = monte_carlo(
            NOISY, Controller.published(), count, rng=1, distributions=DRAWN, workers=workers
        )
        if count == runs:
            best = min(best, perf_counter() - begun)
            bits = found.costs.tobytes().hex()
    return best, str(hash(bits))


class Timed:
    """Runs that tell what processor time their process has used so far [s]."""

    def __init__(self, analysis: Analysis) -> None:
        """Take the analysis."""
        self.analysis = analysis

    def __call__(self, span: tuple[int, int]) -> tuple[np.ndarray, str, float]:
        """Do the runs of (first, count)."""
        return self.analysis(span), worker_name(), process_time()


def processor_time(workers: object, runs: int) -> float:
    """Give the processor time a run [us], of all processes, without their start."""
    draws = Draws(DRAWN, n=runs, seed=1, method="independent", covariance=None)
    analysis = Analysis(family_of(NOISY), Controller.published(), draws, ())
    if isinstance(workers, int):
        used = process_time()
        analysis.block(0, runs, workers)
        return 1e6 * (process_time() - used) / runs
    first: dict[str, float] = {}
    last: dict[str, float] = {}
    counted, used = 0, process_time()
    with Work(read_workers(workers), Timed(analysis), "runs", first=64) as work:
        for block in work.blocks(runs, lambda at, size: (at, size)):
            rows, name, at = block.answer
            if name in first:
                counted += len(rows)
            elif name != worker_name():
                first[name] = at
            last[name] = at
    own = process_time() - used
    if not first:  # threads of this process
        return 1e6 * own / runs
    return 1e6 * (own / runs + sum(last[name] - first[name] for name in first) / counted)


def answer_rate(workers: object) -> float:
    """Give the MB/s at which answers come in."""
    engine, blocks = read_workers(workers), 24
    with Work(engine, numbers, "numbers") as work:
        work.pace.size = lambda left, count, workers: 1  # type: ignore[method-assign]
        for _ in work.blocks(4, lambda first, size: (first, size)):
            pass
        begun = perf_counter()
        for _ in work.blocks(blocks, lambda first, size: (first, size)):
            pass
    return blocks * ANSWERS * 8e-6 / (perf_counter() - begun)


def measure(name: str, runs: int, rounds: int) -> dict[str, object]:
    """Measure one engine."""
    with ENGINES[name]() as workers:
        row: dict[str, object] = {}
        if name != "core":
            row["block"], row["main"] = block_times(workers, rounds)
        row["runs"], row["bits"] = run_times(workers, runs, rounds)
        row["processor"] = min(processor_time(workers, runs) for _ in range(rounds))
        if name not in ("serial", "core"):
            row["rate"] = answer_rate(workers)
    return row


def measured(name: str, runs: int, rounds: int) -> dict[str, object]:
    """Measure one engine in a program of its own, under MPI where it is that."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "row"
        words = [str(Path(__file__).resolve()), "--row", str(path), "--engines", name]
        words += ["--runs", str(runs), "--rounds", str(rounds)]
        before = [sys.executable]
        if name == "mpi":
            ranks = ["-n", str(CORES + 1), "--allow-run-as-root", "--oversubscribe"]
            before = ["mpiexec", *ranks, sys.executable, "-m", "mpi4py.futures"]
        quiet = {"OMPI_MCA_btl": "^tcp", "OMPI_MCA_oob_tcp_if_include": "lo", "PYTHONHASHSEED": "0"}
        subprocess.run([*before, *words], check=True, env={**os.environ, **quiet})
        return dict(json.loads(path.read_text()))


def printed(rows: dict[str, dict[str, object]], runs: int) -> bool:
    """Print the table, and tell whether the bars are met."""
    one = rows["serial"]
    met = True
    points = sum(map(len, BLOCKS))
    print(f"{points} points in {len(BLOCKS)} blocks; {runs} runs with noise; {CORES} workers")
    print(
        "          ms a block  of it main   bar  runs [s]  us a run  efficiency  answers MB/s  bits"
    )
    for name, row in rows.items():
        block = f"{row['block']:10.2f}  {row['main']:10.2f}" if "block" in row else f"{'':22}"
        bar = f"{BARS[name]:4.1f}" if name in BARS else " " * 4
        met = met and ("block" not in row or row["block"] <= BARS.get(name, np.inf))
        share = one["processor"] / row["processor"]
        rate = f"{row['rate']:12.0f}" if "rate" in row else " " * 12
        same = "same" if row["bits"] == one["bits"] else "OTHER"
        met = met and same == "same"
        times = f"{row['runs']:8.3f}  {row['processor']:8.2f}  {share:10.2f}"
        print(f"{name:8}  {block}  {bar}  {times}  {rate}  {same}")
    return met


def main() -> int:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=10**6)
    parser.add_argument("--rounds", type=int, default=3, help="of which the best counts")
    parser.add_argument("--engines", nargs="+", choices=ENGINES, default=list(ENGINES))
    parser.add_argument("--row", type=Path, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.row is not None:
        given.row.write_text(json.dumps(measure(given.engines[0], given.runs, given.rounds)))
        return 0
    names = ["serial", *(name for name in given.engines if name != "serial")]
    load = os.getloadavg()[0]
    print(f"{platform.machine()}, {os.cpu_count()} processors, load {load:.1f} before")
    rows = {name: measured(name, given.runs, given.rounds) for name in names}
    return 0 if printed(rows, given.runs) else 1


if __name__ == "__main__":
    sys.exit(main())
