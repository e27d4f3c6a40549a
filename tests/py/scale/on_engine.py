"""A program that gives work to an engine, kills a worker if asked to, and prints the result's bits.

usage: on_engine.py ENGINE WORK,WORK FOLDER [kill-self | kill-from-outside | wait | interrupt]

Under MPI it is `mpiexec -n 3 python -m mpi4py.futures on_engine.py mpi ...`.
"""

import hashlib
import json
import os
import signal
import sys
import threading
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from nfopidn import Controller, Scenario, bfoa, compare, monte_carlo, stability, tune
from nfopidn.engines import pace
from nfopidn.montecarlo import Normal, Uniform, runs

NOISY = Scenario.published(pose_noise=(0.005, 0.005), rng=0)
DRAWN = {"mass": Normal(11.5, 0.5), "track_width": Uniform(0.43, 0.47)}
BOX = [(-2.0, 2.0)] * 6
RUNS = 100_000


def wait_until(condition, seconds=60.0):
    """Wait for what another process does."""
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, f"nothing came within {seconds} s"
        threading.Event().wait(0.01)


class Bowl:
    """A cost that notes which processes computed it, and may kill or detain one of them."""

    def __init__(self, folder, way=""):
        self.folder, self.way = folder, way

    def __call__(self, x):
        (self.folder / f"pid {os.getpid()}").touch()
        if self.way and self._calls() > 100:
            if self.way == "wait":
                (self.folder / "waiting").touch()
                wait_until((self.folder / "released").exists)
            if self.way == "kill-self" and not (self.folder / "killed").exists():
                (self.folder / "killed").touch()
                os.kill(os.getpid(), signal.SIGKILL)
        return float(((x - 0.3) ** 2).sum())

    def _calls(self):
        with (self.folder / "calls").open("a") as calls:
            calls.write("x")
            return calls.tell()


@contextmanager
def pool():
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(2) as executor:
        yield executor, lambda: list(executor._processes)


@contextmanager
def reusable():
    import loky

    with loky.get_reusable_executor(2) as executor:
        yield executor, lambda: list(executor._processes)


@contextmanager
def dask():
    from distributed import Client, LocalCluster

    with (
        LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            host="127.0.0.1",
            dashboard_address="127.0.0.1:0",
            silence_logs=50,
        ) as cluster,
        Client(cluster) as client,
    ):
        yield client, lambda: list(client.run(os.getpid).values())


@contextmanager
def mpi():
    from mpi4py.futures import MPIPoolExecutor

    with MPIPoolExecutor() as executor:
        yield executor, lambda: [executor.submit(os.getpid).result()]


@contextmanager
def one():
    yield 1, list


ENGINES = {"pool": pool, "loky": reusable, "dask": dask, "mpi": mpi, "one": one}


def digest(*columns):
    """Give a number of all bits of some arrays."""
    found = hashlib.sha256()
    for column in columns:
        found.update(np.ascontiguousarray(column, dtype=float).tobytes())
    return found.hexdigest()


def of_search(result):
    history = [result.history[name] for name in result.history.dtype.names]
    return digest(result.x, result.fun, result.nfev, result.population, *history)


def search(workers, folder, way):
    found = bfoa(Bowl(folder, way), BOX, rng=1, maxfev=1500, workers=workers)
    told = {name: found[name] for name in ("message", "fun", "nfev")}
    return {"bits": of_search(found), **told, "own": Bowl(folder)(found.x)}


def tuning(workers, folder, way):
    return {"bits": of_search(tune(rng=1, maxfev=400, workers=workers))}


def runs_of(count, **settings):
    """Make the first runs of the analysis."""
    controller = Controller.published()
    return monte_carlo(NOISY, controller, count, rng=1, distributions=DRAWN, **settings)


def drawn(workers, folder, way):
    try:
        found = runs_of(RUNS, workers=workers, checkpoint=folder / "runs")
    except KeyboardInterrupt as interrupt:
        return {"bits": digest(interrupt.best.costs), "count": len(interrupt.best)}
    return {"bits": digest(found.costs), "count": len(found)}


def compared(workers, folder, way):
    controllers = [Controller.published(), Controller.recommended()]
    found = compare(
        controllers,
        {"calm": NOISY.replace(pose_noise=(0, 0)), "noisy": NOISY},
        seeds=3,
        workers=workers,
    )
    return {"bits": digest(*found.values.values(), found.draws)}


def attraction(workers, folder, way):
    axis = np.linspace(-1, 1, 9)
    found = stability.basin(x=3 + axis, y=axis, workers=workers)
    return {"bits": digest(found.position_error, found.heading_error)}


WORKS = {
    "bfoa": search,
    "tune": tuning,
    "monte_carlo": drawn,
    "compare": compared,
    "basin": attraction,
}


def after_blocks(count, action):
    """Have something done once monte_carlo has taken in so many blocks, short ones."""
    pace.LONGEST = 0.02
    taken, acted, add = [], [], runs._Kept.add

    def adding(self, first, rows):
        add(self, first, rows)
        taken.append(first)
        if len(taken) >= count and self.done > 0 and not acted:
            acted.append(True)
            self.save()
            action()

    runs._Kept.add = adding


def kill(process, ends_all):
    """Kill a worker, with which MPI ends this process too."""
    os.kill(process, signal.SIGKILL)
    if ends_all:
        wait_until(lambda: False)


def main(engine, works, folder, way=""):
    folder = Path(folder)
    with ENGINES[engine]() as (workers, pids):
        (folder / "main").write_text(str(os.getpid()))
        if way in ("kill-from-outside", "interrupt"):
            runs_of(RUNS // 10, workers=workers)  # every worker has loaded what it needs
        if way == "kill-from-outside":
            after_blocks(4, lambda: kill(pids()[0], ends_all=engine == "mpi"))
        if way == "interrupt":
            after_blocks(4, lambda: os.kill(os.getpid(), signal.SIGINT))
        for work in works.split(","):
            found = WORKS[work](workers, folder, way)
            (folder / f"{work}.json").write_text(json.dumps(found))


if __name__ == "__main__":
    main(*sys.argv[1:])
