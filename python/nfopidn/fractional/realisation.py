"""Zeros and poles as systems of SciPy and of python-control.

Multiplied out, they are lost: the coefficients of a product of many factors near z = 1 do not tell
its roots any more, so that poles leave the unit circle and the response at low frequencies is
another. In series they stay.
"""

from __future__ import annotations

import functools
import math
import warnings
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Matrices = tuple[Floats, Floats, Floats, Floats]

#: Of a polynomial form's response over the grid, relative, beyond which it is not the filter.
_AGREEMENT: Final = 1e-6
#: Of Nyquist's frequency, where the grid begins unless a zero or pole lies lower.
_LOWEST: Final = 1e-4
_RESOLVED: Final = 1e-9  # from 1: a zero or pole that is nearer counts as on it
_GRID: Final = 400


def _in_order(zeros: Floats, poles: Floats) -> tuple[Floats, Floats]:
    """Return zeros and poles in the order of the sections.

    The whole part of an order comes first: it takes the low frequencies away, or brings them,
    before anything is rounded. The others are paired by rank, so that each section is nearly 1.
    """
    zeros, poles = np.sort(zeros), np.sort(poles)
    whole = zeros[-1:].tolist() == [1.0], poles[-1:].tolist() == [1.0]
    if whole == (True, False):
        zeros = np.roll(zeros, 1)
    elif whole == (False, True):
        poles = np.roll(poles, 1)
    first = 1 if any(whole) else 0
    if zeros[first:].sum() < poles[first:].sum():
        zeros[first:] = zeros[first:][::-1].copy()
        poles[first:] = poles[first:][::-1].copy()
    return zeros, poles


def series(zeros: Floats, poles: Floats, gain: float) -> Matrices:
    """Return A, B, C, D of gain prod (z - zeros_i)/(z - poles_i), one section after the other.

    All are real. Section i is x <- p x + u, y = (p - z) x + u, whose y is the next one's u.
    """
    zeros, poles = _in_order(zeros, poles)
    count = len(poles)
    residues = poles - zeros
    a = np.diag(poles) + np.tril(np.tile(residues, (count, 1)), -1)
    return a, np.ones((count, 1)), gain * residues[None, :], np.array([[gain]])


def delays(taps: Floats) -> Matrices:
    """Return A, B, C, D of a filter with these taps: a chain of delays."""
    count = len(taps) - 1
    b = np.zeros((count, 1))
    b[:1] = 1
    return np.eye(count, k=-1), b, taps[None, 1:].copy(), taps[None, :1].copy()


def product_fault(zeros: Floats, poles: Floats) -> str | None:
    """Return what is wrong with zeros and poles as two polynomials; None if nothing is."""
    above, below = np.poly(zeros), np.poly(poles)
    off_one = np.abs(1 - np.concatenate([zeros, poles]))
    lowest = min([_LOWEST * math.pi, *off_one[off_one > _RESOLVED]])
    angle = np.geomspace(lowest, math.pi, _GRID + 1)[:-1]  # at pi a pole may lie
    z = np.exp(1j * angle)
    with np.errstate(all="ignore"):
        ratio = np.polyval(above, z) / np.polyval(below, z)
        for zero, pole in zip(zeros, poles, strict=True):
            ratio *= (z - pole) / (z - zero)
        error = np.abs(ratio - 1)
    error[~np.isfinite(error)] = np.inf
    faults = []
    if error.max() > _AGREEMENT:
        worst = angle[error.argmax()] / math.pi
        faults.append(
            f"its response is off by {error.max():.2g} at {worst:.2g} of Nyquist's frequency"
        )
    largest = float(np.abs(poles).max(initial=0.0))
    found = float(np.abs(np.roots(below)).max(initial=0.0))
    if found > 1 and largest < 1:
        faults.append(f"its largest pole is {found:.5g} for {largest:.5g}")
    if not faults:
        return None
    return (
        f"multiplied out, {len(zeros)} zeros and {len(poles)} poles are another filter: "
        + ", ".join(faults)
    )


@functools.cache
def _system_class() -> Any:
    from scipy.signal import StateSpace, dlti

    base = type(dlti([], [], 1.0, dt=1.0))

    class SeriesSystem(base):  # type: ignore[misc, valid-type]
        """SciPy's zeros, poles and gain, whose other forms are right or warned about."""

        def to_ss(self) -> Any:
            """Return the sections in series, which SciPy would multiply out."""
            return StateSpace(*series(*_real(self)), dt=self.dt)

        def to_tf(self) -> Any:
            """Return numerator and denominator; warns where they are another filter."""
            fault = product_fault(*_real(self)[:2])
            if fault is not None:
                warnings.warn(f"to_tf: {fault}; to_ss() keeps them", stacklevel=2)
            return super().to_tf()

        def __reduce__(self) -> Any:
            return scipy_system, (self.zeros, self.poles, self.gain, self.dt)

    return SeriesSystem


def _real(system: Any) -> tuple[Floats, Floats, float]:
    return np.real(system.zeros), np.real(system.poles), float(np.real(system.gain))


def scipy_system(zeros: Any, poles: Any, gain: float, dt: float) -> Any:
    """Return a scipy.signal.dlti of zeros and poles, all of them real."""
    return _system_class()(zeros, poles, gain, dt=dt)
