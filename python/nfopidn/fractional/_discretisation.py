"""s^order as a digital filter: six methods, one object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn import _core
from nfopidn.fractional import _checks as checks

METHODS: Final = ("tustin", "gl", "al-alaoui", "tustin-cf", "al-alaoui-cf", "oustaloup")
"""Truncated power series of three rules, continued fractions of two, and Oustaloup's."""

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Discretisation:
    """A filter that stands for s^order.

    Attributes
    ----------
    order, dt, method
        what it stands for; dt [s]
    gain
        factor before the product of zeros and poles, or before the taps
    taps
        (n,) impulse response without the gain, of the truncated series; None otherwise
    zeros, poles
        in z; of a series the zeros are the roots of its taps (none beyond 1000 of them) and the
        poles are all 0
    """

    order: float
    dt: float
    method: str
    gain: float
    taps: Floats | None
    zeros: NDArray[np.complex128]
    poles: NDArray[np.complex128]

    @property
    def sections(self) -> Floats:
        """(n, 6) second-order sections b0 b1 b2 a0 a1 a2, as scipy.signal.sosfilt takes them.

        Raises
        ------
        ValueError
            For a truncated series, which has taps.
        """
        if self.taps is not None:
            raise ValueError(f"method is {self.method!r}; has taps, not sections")
        zeros = sorted(self.zeros.real, key=abs)
        poles = sorted(self.poles.real, key=abs)
        rows = []
        for first in range(0, max(len(zeros), 1), 2):
            pair = [np.atleast_1d(np.poly(roots[first : first + 2])) for roots in (zeros, poles)]
            rows.append(np.concatenate([np.pad(side, (0, 3 - len(side))) for side in pair]))
        table = np.array(rows)
        table[0, :3] *= self.gain
        return table

    def response(self, frequency: ArrayLike) -> NDArray[np.complex128]:
        """Return the frequency response.

        Parameters
        ----------
        frequency
            [rad/s], any shape

        Returns
        -------
        array
            complex, of the same shape; infinite at a pole, as 0 is of an integral

        Raises
        ------
        ValueError
            For frequencies that are no finite numbers.
        """
        omega = checks.frequency(frequency)
        z = np.exp(1j * omega * self.dt)
        if self.taps is not None:
            result = np.polynomial.polynomial.polyval(1 / z, self.taps) * self.gain
        else:
            # In pairs: products of many factors of either kind alone could overflow.
            result = np.full(z.shape, self.gain, dtype=complex)
            for zero, pole in zip(self.zeros, self.poles, strict=True):
                off = z - pole
                result *= (z - zero) / np.where(off == 0, 1, off)
            result = np.where(np.isin(z, self.poles), np.inf, result)
        return np.asarray(result, dtype=complex)

    def errors(self, band: Sequence[float] | None = None) -> tuple[float, float]:
        """Return the worst errors against (j omega)^order.

        Parameters
        ----------
        band
            (low, high) [rad/s], up to pi/dt; None: the decade that ends at a tenth of it

        Returns
        -------
        magnitude, phase
            largest |magnitude ratio - 1| [-] and largest phase difference [degree]

        Raises
        ------
        ValueError
            For a band that does not rise or ends above Nyquist's frequency.
        """
        omega = checks.frequencies(checks.band(band, self.dt))
        return worst_errors(self.response(omega) / (1j * omega) ** self.order)

    def to_dlti(self) -> Any:
        """Return it as scipy.signal.dlti (zeros, poles, gain). Needs SciPy."""
        try:
            from scipy.signal import dlti
        except ImportError as error:
            raise ImportError("to_dlti needs SciPy: pip install scipy") from error
        if self.taps is not None:
            denominator = np.zeros(len(self.taps))
            denominator[0] = 1
            return dlti(self.taps * self.gain, denominator, dt=self.dt)
        return dlti(self.zeros, self.poles, self.gain, dt=self.dt)

    def to_control(self, frequency: ArrayLike | None = None) -> Any:
        """Return it as an object of python-control. Needs control.

        Parameters
        ----------
        frequency
            [rad/s]; given: a FrequencyResponseData there, else a TransferFunction
        """
        try:
            import control
        except ImportError as error:
            raise ImportError("to_control needs python-control: pip install control") from error
        if frequency is not None:
            omega = checks.frequency(frequency)
            return control.frd(self.response(omega), omega)
        if self.taps is not None:
            denominator = np.zeros(len(self.taps))
            denominator[0] = 1
            return control.tf(self.taps * self.gain, denominator, self.dt)
        return control.zpk(self.zeros, self.poles, self.gain, dt=self.dt)


def discretise(
    order: float,
    dt: float,
    method: str = "gl",
    *,
    memory: int = 100,
    sections: int = 9,
    prewarp: float | None = None,
    band: Sequence[float] | None = None,
) -> Discretisation:
    """Discretise s^order.

    Whole orders come out exactly, as the method's rule s -> scale (z - 1)/(z + pole): Tustin's has
    pole 1 and scale 2/dt, gl (Gruenwald and Letnikov) 0 and 1/dt, Al-Alaoui's 1/7 and 8/(7 dt).

    Parameters
    ----------
    order
        in (-2, 2)
    dt
        sample time [s]
    method
        "gl", "al-alaoui", "tustin" (the paper's): power series cut after `memory`, Tustin's the
        worst of them (docs/fractional.md); "tustin-cf", "al-alaoui-cf": continued fractions with
        `sections` zeros and poles; "oustaloup": as many, evenly spaced over `band` in the
        logarithm, taken to z by Tustin's rule
    memory
        last power of 1/z in a series, 0 to 10,000,000
    sections
        zeros and poles of the other methods, 1 to 200. An order beyond 1 in size has one more,
        which is its whole part
    prewarp
        frequency [rad/s] at which the rule's magnitude is exact; None: at 0
    band
        (low, high) [rad/s] of Oustaloup's, and of no other's; None: three decades that end at
        Nyquist's frequency

    Returns
    -------
    Discretisation

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    """
    order = checks.order("order", order)
    dt = checks.sample_time(dt)
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method is {method!r}; must be one of {', '.join(METHODS)}")
    memory = checks.whole("memory", memory, 0, checks.LONGEST_MEMORY)
    sections = checks.whole("sections", sections, 1, 200)
    warp = checks.prewarp_frequency(prewarp, dt)
    if band is not None and method != "oustaloup":
        raise ValueError(f"band is {band!r}; is Oustaloup's, and does not apply to {method!r}")
    pole = checks.POLES.get(method.removesuffix("-cf"), 1.0)
    if method in checks.POLES and order not in {-1.0, 0.0, 1.0}:
        taps = _core.series_weights(pole, order, memory)
        zeros = _complex(np.roots(taps) if memory <= 1000 else [])
        gain = _core.rule_scale(pole, dt, warp) ** order
        return Discretisation(order, dt, method, gain, taps, zeros, _complex(np.zeros(memory)))
    if method == "oustaloup":
        low, high = (np.pi / dt / 1000, np.pi / dt) if band is None else checks.band(band, dt)
        found = _core.oustaloup(order, dt, warp, sections, low, high)
    else:
        found = _core.continued_fraction(order, pole, dt, warp, sections)
    roots, ends, gain = found
    return Discretisation(order, dt, method, gain, None, _complex(roots), _complex(ends))


def rule_power(method: str, order: float, angle: Floats) -> NDArray[np.complex128]:
    """Return ((1 - w)/(1 + pole w))^order at w = exp(-j angle), which no memory truncates."""
    w = np.exp(-1j * angle)
    return np.asarray(((1 - w) / (1 + checks.POLES[method] * w)) ** order)


def truncated_power(
    method: str, order: float, angle: Floats, memory: int
) -> NDArray[np.complex128]:
    """Return the power series of that up to w^memory, cut for whole orders as for others."""
    taps = _core.series_weights(checks.POLES[method], order, memory)
    return np.asarray(np.polynomial.polynomial.polyval(np.exp(-1j * angle), taps))


def worst_errors(ratio: NDArray[np.complex128]) -> tuple[float, float]:
    """Return the largest |magnitude - 1| [-] and phase [degree] of ratios that should be 1."""
    return float(np.abs(np.abs(ratio) - 1).max()), float(np.abs(np.angle(ratio, deg=True)).max())


def _complex(numbers: ArrayLike) -> NDArray[np.complex128]:
    return np.asarray(numbers, dtype=np.complex128)
