"""Arguments that several functions take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any, Final

import numpy as np

from nfopidn._core import Controller
from nfopidn.arguments import is_number, real_numbers, shown
from nfopidn.arithmetic import in_standard_arithmetic

POLES: Final = {"tustin": 1.0, "gl": 0.0, "al-alaoui": 1 / 7}
"""s -> scale (1 - w)/(1 + pole w), w = 1/z."""

Floats = np.ndarray[Any, np.dtype[np.float64]]

#: Wide enough for any loop, and no gain scale^order overflows.
SAMPLE_TIMES: Final = (1e-40, 1e40)
#: Sums of ten million of them times a weight and a gain do not overflow.
LARGEST_SAMPLE: Final = 1e100
_SMALL: Final = f"must be a number in [{-LARGEST_SAMPLE:g}, {LARGEST_SAMPLE:g}]"
#: Two sample times count as one up to this share of them, as in the core.
_SAME: Final = 1e-9

LONGEST_MEMORY: Final = 10_000_000
LONGEST_CONTROLLER_MEMORY: Final = 1_000_000
LONGEST_HORIZON: Final = 10_000_000


def number(name: str, value: Any, low: float, high: float, unit: str = "") -> float:
    """Return a finite number in the open range (low, high)."""
    if not isinstance(value, Real) or isinstance(value, bool | np.bool_):
        raise ValueError(f"{name} is {value!r}; must be a number in ({low:g}, {high:g}){unit}")
    result = _as_float(value)
    if not low < result < high:
        text = shown(value) if isinstance(value, int) else f"{result:g}"
        raise ValueError(f"{name} is {text}; must be in ({low:g}, {high:g}){unit}")
    return result


def _as_float(value: Any) -> float:
    """Return a real number as a float, infinite if it is beyond every float."""
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def is_infinite(value: Any) -> bool:
    """Whether a value is a real number that says infinity."""
    return isinstance(value, Real) and not isinstance(value, int) and float(value) == math.inf


def whole(name: str, value: Any, low: int, high: int) -> int:
    """Return a whole number in [low, high]."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise ValueError(f"{name} is {value!r}; must be a whole number in [{low}, {high}]")
    if not low <= int(value) <= high:
        raise ValueError(f"{name} is {shown(int(value))}; must be in [{low}, {high}]")
    return int(value)


def sample(value: Any) -> float:
    """Return a sample of a signal."""
    # A float first: this is a loop's own sample, and the checks cost more than the filter.
    plain = type(value) is float
    result = _as_float(value) if plain or is_number(value) else math.nan
    if not abs(result) <= LARGEST_SAMPLE:
        not_finite = isinstance(value, Real) and not math.isfinite(result)
        what = "must be finite" if not_finite else _SMALL
        raise ValueError(f"sample is {shown(value)}; {what}")
    return result


def samples(value: Any) -> Floats:
    """Return a row of samples of a signal."""
    row = np.ascontiguousarray(real_numbers("samples", value))
    if np.ndim(value) != 1:
        raise ValueError(f"samples has {np.ndim(value)} dimensions; must have 1")
    bad = np.flatnonzero(~(np.abs(row) <= LARGEST_SAMPLE))
    if bad.size:
        worst = float(row[bad[0]])
        what = _SMALL if math.isfinite(worst) else "must be finite"
        raise ValueError(f"samples[{bad[0]}] is {worst:g}; {what}")
    return row


def frequency(value: Any) -> Floats:
    """Return frequencies [rad/s]."""
    omega = real_numbers("frequency", value)
    if not np.isfinite(omega).all():
        raise ValueError("frequency has a number that is not finite; must be finite [rad/s]")
    return omega


def order(name: str, value: Any) -> float:
    """Return an order in (-2, 2)."""
    return number(name, value, -2.0, 2.0)


def sample_time(value: Any) -> float:
    """Return a sample time [s]."""
    return number("dt", value, *SAMPLE_TIMES, " s")


def controller_sample_time(controller: Controller, dt: Any) -> float:
    """Return the sample time that a controller is made for [s]: dt, or for None its own."""
    own = controller.sample_time
    if dt is None:
        if own is None:
            raise ValueError("the controller does not know its sample time; give dt [s]")
        return own
    time = sample_time(dt)
    if own is not None and abs(own - time) > _SAME * time:
        raise ValueError(f"dt is {time:g} s; must be the controller's sample_time, {own:g} s")
    return time


def prewarp_frequency(value: Any, dt: float) -> float:
    """Return a frequency [rad/s] below Nyquist's, 0 for None."""
    return 0.0 if value is None else number("prewarp", value, 0.0, math.pi / dt, " rad/s")


@in_standard_arithmetic
def band(value: Sequence[float] | None, dt: float, name: str = "band") -> tuple[float, float]:
    """Return (low, high) [rad/s]; None: the decade that ends at a tenth of Nyquist's frequency."""
    nyquist = math.pi / dt
    if value is None:
        return nyquist / 100, nyquist / 10
    try:
        pair = real_numbers(name, value).ravel()
    except ValueError:
        raise ValueError(f"{name} is {shown(value)}; must be low and high [rad/s]") from None
    if pair.size != 2:
        raise ValueError(f"{name} has {pair.size} numbers; must have 2, low and high [rad/s]")
    low, high = (float(edge) for edge in pair)
    if not 0 < low < high <= nyquist:
        raise ValueError(
            f"{name} is ({low:g}, {high:g}) rad/s; must rise, above 0 and up to Nyquist's "
            f"frequency {nyquist:g} rad/s"
        )
    return low, high


def frequencies(edges: tuple[float, float], count: int = 400) -> Floats:
    """Return `count` frequencies of a band [rad/s], evenly spaced in the logarithm."""
    grid = np.geomspace(*edges, count)
    grid[0], grid[-1] = edges
    return grid
