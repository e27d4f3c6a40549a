#!/usr/bin/env bash
# Dask: a hundred noisy runs of one controller are a single run, a hundred times.
#
# One would guess: client.submit(simulate, controller), called a hundred times like the submit of Python's own
#   executors, starts a hundred simulations, each with noise of its own.
# What happens: functions count as pure. A task is named after the function and its arguments, so the hundred calls
#   have one name: one simulation runs and every future shares its result. client.map over equal arguments does the
#   same. pure=False, or a seed among the arguments, brings a hundred different results; dask.delayed is
#   not pure by default, so moving from one to the other changes the statistics.
# Why it matters: the spread over noise is exactly zero and the mean is one draw: a Monte Carlo study that
#   looks wonderfully robust, finished in a hundredth of the time.
# Seen with: dask and distributed 2026.8.0.
# Source: https://github.com/dask/distributed/blob/main/docs/source/client.rst ("Pure Functions by Default").
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check dask==2026.8.0 distributed==2026.8.0 numpy==2.4.6

"$work/venv/bin/python" - <<'PYTHON'
from concurrent.futures import ThreadPoolExecutor

import dask
import numpy as np
from dask.distributed import Client

RUNS = 100


def simulate(gain, seed=None):
    """Return the cost of a noisy run."""
    return gain + 0.1 * float(np.random.default_rng(seed).normal())


def show(name, costs):
    print(f"  {name:32s} {len(set(costs)):3d} different costs, standard deviation {np.std(costs):.3f}")
    return len(set(costs))


print(f"{RUNS} runs:")
with ThreadPoolExecutor(2) as executor:
    own = show("ThreadPoolExecutor.submit", [run.result() for run in
                                             [executor.submit(simulate, 1.0) for _ in range(RUNS)]])
with Client(processes=False, n_workers=1, threads_per_worker=2, dashboard_address=None) as client:
    submitted = show("client.submit", client.gather([client.submit(simulate, 1.0) for _ in range(RUNS)]))
    mapped = show("client.map", client.gather(client.map(simulate, [1.0] * RUNS)))
    impure = show("client.map, pure=False", client.gather(client.map(simulate, [1.0] * RUNS, pure=False)))
    seeded = show("client.map, a seed each", client.gather(client.map(simulate, [1.0] * RUNS, range(RUNS))))
    delayed = show("dask.delayed", dask.compute(*[dask.delayed(simulate)(1.0) for _ in range(RUNS)]))
assert submitted == 1 and mapped == 1, "equal calls are no longer run once"
assert own == impure == seeded == delayed == RUNS, "a way that ran every call has changed"
PYTHON
