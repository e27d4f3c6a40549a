"""Nanoseconds a sample of long fractional memory, beside SciPy's convolution, plain sums, fracmem.

    python bench/fractional.py

Each figure is the least of several runs. fracmem, which knows Gruenwald and Letnikov's rule alone
and fits its modes to signals, is left out where it is missing (pip install fracmem).
"""

import math
import sys
import time
from collections.abc import Callable

import numpy as np
from nfopidn import _core
from nfopidn.fractional import FractionalFilter
from scipy.signal import oaconvolve

ORDER = 0.5
SAMPLES = 200_000
PLAIN_SAMPLES = 2_000
ROUNDS = 7
# At most so many nanoseconds a sample.
BARS = {100: 20.0, 1_000_000: 60.0}


def best(function: Callable[[], object], count: int) -> float:
    """Nanoseconds a sample, the least of several runs."""
    least = math.inf
    for _ in range(ROUNDS):
        start = time.perf_counter()
        function()
        least = min(least, time.perf_counter() - start)
    return least / count * 1e9


def plain_sum(weights: np.ndarray, samples: np.ndarray) -> float:
    """A dot product a sample, NumPy's."""
    window = samples[: weights.size]
    return best(lambda: [weights @ window for _ in range(PLAIN_SAMPLES)], PLAIN_SAMPLES)


def row(memory: float, samples: np.ndarray) -> bool:
    """Print a memory's line; whether its bar is met."""
    model = FractionalFilter(ORDER, 1.0, memory, "tustin")
    length = min(int(min(memory, SAMPLES)), SAMPLES - 1) + 1
    weights = _core.series_weights(1.0, ORDER, length - 1)
    streamed = best(lambda: model.stream(samples), SAMPLES)
    convolved = best(lambda: oaconvolve(samples, weights), SAMPLES)
    plain = plain_sum(weights, samples)
    bar = BARS.get(memory, math.inf)
    bar_text = f"{bar:g}" if bar < math.inf else ""
    print(f"{memory:9g} {model.modes:6d} {streamed:9.1f} {bar_text:>5}", end=" ")
    print(f"{convolved:11.1f} {plain:10.0f}")
    return streamed <= bar


def beside_fracmem(samples: np.ndarray) -> None:
    """Print both packages' time and error for s^0.5 by Gruenwald and Letnikov's rule."""
    try:
        from fracmem import CompressedFractionalFilter
    except ImportError:
        return
    short = samples[:20_000]
    weights = _core.series_weights(0.0, ORDER, short.size - 1)
    exact = oaconvolve(short, weights)[: short.size]
    other = CompressedFractionalFilter(alpha=ORDER, h=1.0, L=32, p=16)
    other.fit([samples[k : k + 3000] for k in range(0, 24_000, 3000)], j_max=10_000)
    own = FractionalFilter(ORDER, 1.0, math.inf, "gl")
    print("\nGruenwald and Letnikov's rule, all memory   ns a sample   worst error / worst output")
    for name, run in (
        ("fracmem, 32 taps and 16 modes", lambda: np.asarray(other.predict(short))),
        (f"33 taps and {own.modes} modes", lambda: own.copy().stream(short)),
    ):
        error = np.abs(run() - exact).max() / np.abs(exact).max()
        print(f"{name:42} {best(run, short.size):12.1f}   {error:.2g}")


def main() -> int:
    """Print the tables; returns 1 if a bar is missed."""
    samples = np.random.default_rng(1).normal(size=SAMPLES)
    print("ns a sample, s^0.5 by Tustin's rule\n")
    print("   memory  modes  streamed   bar  oaconvolve  plain sum")
    memories = (100, 1_000, 10_000, 100_000, 1_000_000, math.inf)
    met = [row(memory, samples) for memory in memories]
    beside_fracmem(samples)
    return int(not all(met))


if __name__ == "__main__":
    sys.exit(main())
