"""Arguments that several functions take."""

from __future__ import annotations

import math
from collections.abc import Sequence
from numbers import Integral, Real
from typing import Any, Final

import numpy as np

from nfopidn._core import Controller

POLES: Final = {"tustin": 1.0, "gl": 0.0, "al-alaoui": 1 / 7}
"""s -> scale (1 - w)/(1 + pole w), w = 1/z."""

#: Two sample times count as one up to this share of them, as in the core.
_SAME: Final = 1e-9

LONGEST_MEMORY: Final = 10_000_000
LONGEST_HORIZON: Final = 10_000_000


def number(name: str, value: Any, low: float, high: float, unit: str = "") -> float:
    """Return a finite number in the open range (low, high)."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ValueError(f"{name} is {value!r}; must be a number in ({low:g}, {high:g}){unit}")
    result = float(value)
    if not low < result < high:
        raise ValueError(f"{name} is {result:g}; must be in ({low:g}, {high:g}){unit}")
    return result


def whole(name: str, value: Any, low: int, high: int) -> int:
    """Return a whole number in [low, high]."""
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise ValueError(f"{name} is {value!r}; must be a whole number in [{low}, {high}]")
    if not low <= int(value) <= high:
        raise ValueError(f"{name} is {int(value)}; must be in [{low}, {high}]")
    return int(value)


def order(name: str, value: Any) -> float:
    """Return an order in (-2, 2)."""
    return number(name, value, -2.0, 2.0)


def sample_time(value: Any) -> float:
    """Return a sample time [s]."""
    return number("dt", value, 0.0, math.inf, " s")


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


def band(value: Sequence[float] | None, dt: float) -> tuple[float, float]:
    """Return (low, high) [rad/s]; None: the decade that ends at a tenth of Nyquist's frequency."""
    nyquist = math.pi / dt
    if value is None:
        return nyquist / 100, nyquist / 10
    try:
        pair = np.asarray(value, dtype=float).ravel()
    except (TypeError, ValueError):
        raise ValueError(f"band is {value!r}; must be low and high [rad/s]") from None
    if pair.size != 2:
        raise ValueError(f"band has {pair.size} numbers; must have 2, low and high [rad/s]")
    low, high = (float(edge) for edge in pair)
    if not 0 < low < high <= nyquist:
        raise ValueError(
            f"band is ({low:g}, {high:g}) rad/s; must rise, above 0 and up to Nyquist's frequency "
            f"{nyquist:g} rad/s"
        )
    return low, high


def frequencies(edges: tuple[float, float], count: int = 400) -> np.ndarray[Any, Any]:
    """Return `count` frequencies of a band [rad/s], evenly spaced in the logarithm."""
    grid = np.geomspace(*edges, count)
    grid[0], grid[-1] = edges
    return grid
