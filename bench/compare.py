"""The core's closed loop beside the same loop in Python, NumPy, python-control, numba and JAX.

Rounds alternate between the rivals, so that a slow moment of the machine strikes all of them; the
best of each counts. A measurement takes about 10 ms of any rival, the NumPy loop's 20 ms or more.
The core's time is that of build/bench/bench/bench_loop.
"""

import json
import os
import subprocess
import sys
import time
from importlib.util import find_spec
from pathlib import Path

import loops
import nfopidn
import numpy as np

ROOT = Path(__file__).resolve().parents[1]
BINARY = Path(os.environ.get("NFOPIDN_BENCH_LOOP", ROOT / "build/bench/bench/bench_loop"))
BATCH = BINARY.with_name("bench_batch")
ROUNDS = 7
# What the core has to reach: so many times the speed of the rival.
LANE_BARS = {"avx512": 3.0, "avx2": 6.1, "sse2": 14.0}
# Vector operations of a step at memory 5, without its loads, and doubles a vector.
STEP_OPERATIONS = 144
LANE_WIDTHS = {"avx512": 8, "avx2": 4, "sse2": 2, "generic": 2}
# Vector operations that a core starts in a cycle, at most.
LANE_STARTS = {"avx512": 2, "avx2": 3, "sse2": 3, "generic": 4}
NUMBA_BAR = 25.0  # so many times as long as the fastest lanes
BARS = {"plain Python": 60.0, "NumPy": 200.0, "numba": 1.2}


def core_seconds() -> float:
    """The best measurement of one round of the C++ loop, cost alone, M = 5: seconds a run."""
    command = [
        str(BINARY),
        "--benchmark_filter=cost_alone/5$",
        "--benchmark_format=json",
        "--benchmark_min_time=0.01",
        "--benchmark_repetitions=8",
    ]
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    runs = [run for run in report["benchmarks"] if run["run_type"] == "iteration"]
    return min(float(run["real_time"]) for run in runs) * 1e-9


def lanes() -> dict[str, float]:
    """Seconds a step and lane of 1,024 candidates at once, best of a round, by instruction set."""
    if not BATCH.exists():
        return {}
    command = [
        str(BATCH),
        "--benchmark_filter=lanes",
        "--benchmark_format=json",
        "--benchmark_min_time=0.02",
        "--benchmark_repetitions=8",
    ]
    report = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    best: dict[str, float] = {}
    for run in report["benchmarks"]:
        if run["run_type"] != "iteration" or run.get("error_occurred"):
            continue
        name = run["name"].split("/")[1]
        best[name] = min(best.get(name, float("inf")), float(run["per_step"]))
    return best


def roofline(name: str, cycle: float) -> float:
    """Seconds a step and lane could take: its arithmetic alone, with the core never waiting.

    No chain of operations waiting for each other, no loads, no spills. A vector operation is an
    addition, a product, a minimum or one on bits; there are no fused ones, by choice.
    """
    return STEP_OPERATIONS * cycle / LANE_STARTS[name] / LANE_WIDTHS[name]


def print_lanes(steps: dict[str, float], numba_step: float, cycle: float) -> bool:
    """Print the lanes' table; returns whether a bar is missed."""
    missed = False
    print("\n1,024 candidates     ns a step and lane    bar    numba takes  roofline")
    for name, step in steps.items():
        bar = LANE_BARS.get(name, float("inf"))
        ratio = numba_step / step
        missed |= step * 1e9 > bar
        least = roofline(name, cycle) * 1e9
        print(f"{name:18} {step * 1e9:20.1f} {bar:6g} {ratio:12.1f} x {least:9.1f}")
    if steps:
        missed |= numba_step / min(steps.values()) < NUMBA_BAR
    return missed


def seconds(function, *arguments, repeat: int) -> float:
    """The best measurement of one round, each the mean time of `repeat` calls."""
    best = float("inf")
    for _ in range(8):
        start = time.perf_counter()
        for _ in range(repeat):
            function(*arguments)
        best = min(best, (time.perf_counter() - start) / repeat)
    return best


def main() -> int:
    """Measure, print the table, and return 1 if a bar is missed."""
    try:
        import numba
    except ImportError:
        print("numba is missing: pip install 'nfopidn[bench]'", file=sys.stderr)
        return 2
    reference = nfopidn.Scenario.published(rng=0).reference
    taps = nfopidn.Controller.published().taps
    compiled = numba.njit(loops.compiled_loop)
    rows, lists = reference.tolist(), taps.tolist()
    rivals = {
        "plain Python": (loops.plain_python, rows, lists, 3),
        "NumPy": (loops.fused_numpy, reference, taps, 1),
        "numba": (compiled, reference, taps, 120),
    }
    if find_spec("control") is not None:
        rivals["python-control"] = (loops.python_control, reference, taps, 1)
    if (jax_loop := loops.jax_loop()) is not None:
        rivals["JAX"] = (jax_loop, reference, taps, 20)
    cost = nfopidn.simulate().cost
    for name, (function, first, second, _) in rivals.items():
        if not np.isclose(function(first, second), cost, rtol=1e-9):
            print(f"{name} computes another cost", file=sys.stderr)
            return 2
    best = dict.fromkeys(["core", *rivals], float("inf"))
    lane_steps: dict[str, float] = {}
    for _ in range(ROUNDS):
        best["core"] = min(best["core"], core_seconds())
        for name, step in lanes().items():
            lane_steps[name] = min(lane_steps.get(name, float("inf")), step)
        for name, (function, first, second, repeat) in rivals.items():
            best[name] = min(best[name], seconds(function, first, second, repeat=repeat))

    steps = len(reference)
    print(f"closed loop, published scenario, {steps} samples, M = 5, one core\n")
    print(f"{'':14} {'us a run':>10} {'ns a step':>10} {'core is':>12} {'bar':>8}")
    missed = False
    for name, time_taken in best.items():
        ratio = time_taken / best["core"]
        bar = BARS.get(name)
        missed |= bar is not None and ratio < bar
        bar_text = f"{bar:g} x" if bar else ""
        print(
            f"{name:14} {time_taken * 1e6:10.1f} {time_taken / steps * 1e9:10.1f} "
            f"{ratio:10.1f} x {bar_text:>8}"
        )
    products = numba.njit(loops.dependent_products)
    products(1.0)
    cycle = seconds(products, 1.0, repeat=20) / (loops.PRODUCTS * loops.PRODUCT_CYCLES)
    missed |= print_lanes(lane_steps, best["numba"] / steps, cycle)
    return int(missed)


if __name__ == "__main__":
    sys.exit(main())
