#!/usr/bin/env bash
# Dask: a function that is mapped over a hundred arguments is unpickled a hundred times.
#
# One would guess: client.map(objective, points) sends the objective, a callable object that takes half a second to
#   load, to each worker once: the scheduler knows that all tasks have one function. If not, client.scatter(objective,
#   broadcast=True), which is there for large things, makes a copy a worker.
# What happens: map and submit carry the pickled function in every task, and the worker unpickles it for every task: a
#   hundred calls are a hundred unpicklings. Scattered, with a plain function that calls it, there is one for each worker,
#   and one more where it was scattered from.
# Why it matters: the time of every call grows by that of loading the object, which no profile of the function shows. A
#   cost function that parses its scenario takes 0.5 ms to load and 0.05 ms to evaluate.
# Seen with: dask and distributed 2026.8.0.
# Source: https://distributed.dask.org/en/stable/locality.html ("scatter"), which speaks of data; of functions the
#   documentation says nothing.
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check dask==2026.8.0 distributed==2026.8.0

cat > objective.py <<'PYTHON'
import os


class Objective:
    """Counts in each process how often one is unpickled."""

    unpickled = 0

    def __setstate__(self, state):
        Objective.unpickled += 1
        self.__dict__.update(state)

    def __call__(self, x):
        return os.getpid(), Objective.unpickled


def call(objective, x):
    return objective(x)
PYTHON
cat > count.py <<'PYTHON'
from dask.distributed import Client, LocalCluster
from objective import Objective, call

CALLS = 100


def unpickled(name, work):
    """Count in workers that are new."""
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None) as cluster,
        Client(cluster) as client,
    ):
        counts = {}
        for process, count in client.gather(work(client)):
            counts[process] = max(count, counts.get(process, 0))
    print(f"  {name:32s} {sum(counts.values()):3d} in {len(counts)} workers")
    return sum(counts.values()), len(counts)


def objective():
    made = Objective()
    made.table = list(range(1000))
    return made


def mapped(client):
    return client.map(objective(), range(CALLS), pure=False)


def submitted(client):
    one = objective()
    return [client.submit(one, x, pure=False) for x in range(CALLS)]


def scattered(client):
    one = client.scatter(objective(), broadcast=True)
    return [client.submit(call, one, x, pure=False) for x in range(CALLS)]


if __name__ == "__main__":
    print(f"unpicklings for {CALLS} calls:")
    assert unpickled("map", mapped)[0] >= CALLS, "map no longer unpickles for every task"
    assert unpickled("submit", submitted)[0] >= CALLS, "submit no longer unpickles for every task"
    count, workers = unpickled("scatter, and submit", scattered)
    assert count <= 2 * workers, "scattered, it is no longer unpickled once a worker"
PYTHON
"$work/venv/bin/python" count.py
