"""s^order as a digital filter: six methods, one object."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn import _core
from nfopidn.arguments import suggestion
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.fractional import orders as checks
from nfopidn.fractional.errors import PowerOfS, operator_errors, warn_if_far
from nfopidn.fractional.realisation import delays, product_fault, scipy_system, series

METHODS: Final = ("tustin", "gl", "al-alaoui", "tustin-cf", "al-alaoui-cf", "oustaloup")
"""Truncated power series of three rules, continued fractions of two, and Oustaloup's."""

_FORMS: Final = ("state_space", "transfer_function")
_BLOCK: Final = 4096  # taps that a frequency response sums at a time
_LONGEST_CHAIN: Final = 1000  # delays: A has the square of their number

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Discretisation(PowerOfS):
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
        zeros, poles = np.sort(self.zeros.real), np.sort(self.poles.real)
        rows = []
        for first in range(max((len(zeros) + 1) // 2, 1)):
            # The lowest with the highest: the coefficients of two roots near 1 do not tell them.
            pair = np.unique([first, len(zeros) - 1 - first]) if len(zeros) else np.array([], int)
            sides = [np.atleast_1d(np.poly(roots[pair])) for roots in (zeros, poles)]
            rows.append(np.concatenate([np.pad(side, (0, 3 - len(side))) for side in sides]))
        table = np.array(rows)
        table[0, :3] *= self.gain
        return table

    @in_standard_arithmetic
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

    def _described(self) -> str:
        if self.taps is not None:
            return f"{self.method} with a memory of {len(self.taps) - 1}"
        return f"{self.method} with {len(self.poles)} zeros and poles"

    def to_dlti(self) -> Any:
        """Return it as scipy.signal.dlti: zeros, poles and gain, or the taps of a series.

        Of zeros and poles, `to_ss()` and what takes that way (scipy.signal.dlsim, dstep, dimpulse)
        run the sections in series. Beware of `to_tf()`: it multiplies zeros and poles out, which
        many of them do not survive, so that stable filters come out unstable. It warns where it
        gives another filter; SciPy's functions of bare numbers, as zpk2tf, do not.

        Warns
        -----
        UserWarning
            From `to_tf()` of what is returned, if that is another filter.
        """
        from scipy.signal import dlti

        if self.taps is not None:
            denominator = np.zeros(len(self.taps))
            denominator[0] = 1
            return dlti(self.taps * self.gain, denominator, dt=self.dt)
        return scipy_system(self.zeros, self.poles, self.gain, self.dt)

    def to_control(self, frequency: ArrayLike | None = None, *, form: str | None = None) -> Any:
        """Return it as an object of python-control.

        Parameters
        ----------
        frequency
            [rad/s]; given: a FrequencyResponseData there
        form
            "state_space": a StateSpace, of zeros and poles the sections in series, of taps a chain
            of delays, up to 1000. "transfer_function": a TransferFunction, of zeros and poles only
            if multiplied out they still have the same response, to 1e-6 from Nyquist's frequency /
            10,000 and the lowest zero or pole on, and no pole has left the unit circle. None:
            "state_space" for zeros and poles, "transfer_function" for taps, which are its
            coefficients as they stand

        Returns
        -------
        StateSpace, TransferFunction or FrequencyResponseData
            Whatever python-control itself turns into polynomials is lost again: its margins of a
            StateSpace are one such case. Take them of a FrequencyResponseData.

        Raises
        ------
        ImportError
            Without python-control.
        ValueError
            For a form that would be another filter, a chain of more than 1000 delays, or a form
            beside a frequency.
        """
        try:
            import control
        except ImportError as error:
            words = "to_control needs python-control: pip install 'nfopidn[control]'"
            raise ImportError(words) from error
        if form is not None and (not isinstance(form, str) or form not in _FORMS):
            hint = suggestion(form, _FORMS)
            raise ValueError(f"form is {form!r}{hint}; must be one of {', '.join(_FORMS)}")
        if frequency is not None:
            if form is not None:
                raise ValueError(
                    f"form is {form!r} beside a frequency, which has a form of its own"
                )
            omega = checks.frequency(frequency)
            return control.frd(self.response(omega), omega)
        if self.taps is not None:
            return self._control_of_taps(control, self.taps * self.gain, form)
        zeros, poles = self.zeros.real, self.poles.real
        if form != "transfer_function":
            return control.ss(*series(zeros, poles, self.gain), self.dt)
        fault = product_fault(zeros, poles)
        if fault is not None:
            raise ValueError(
                f"form is 'transfer_function'; {fault}. Take the form 'state_space', or fewer "
                "sections"
            )
        return control.zpk(self.zeros, self.poles, self.gain, dt=self.dt)

    def _control_of_taps(self, control: Any, taps: Floats, form: str | None) -> Any:
        if form == "state_space":
            if len(taps) - 1 > _LONGEST_CHAIN:
                raise ValueError(
                    f"form is 'state_space' and memory is {len(taps) - 1}; must be in "
                    f"[0, {_LONGEST_CHAIN}] for a chain of delays"
                )
            return control.ss(*delays(taps), self.dt)
        denominator = np.zeros(len(taps))
        denominator[0] = 1
        return control.tf(taps, denominator, self.dt)


def discretise(
    order: float,
    dt: float,
    method: str = "gl",
    *,
    memory: int = 100,
    sections: int = 9,
    prewarp: float | None = None,
    band: Sequence[float] | None = None,
    check_band: Sequence[float] | None = None,
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
    check_band
        (low, high) [rad/s], up to pi/dt, where it is to be s^order; None: it is not looked at, and
        `Discretisation.errors` tells

    Returns
    -------
    Discretisation

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.

    Warns
    -----
    UserWarning
        If over `check_band` the filter is not s^order: off by a fifth or by 10 degrees.
    """
    order = checks.order("order", order)
    dt = checks.sample_time(dt)
    if not isinstance(method, str) or method not in METHODS:
        hint = suggestion(method, METHODS)
        raise ValueError(f"method is {method!r}{hint}; must be one of {', '.join(METHODS)}")
    memory = checks.whole("memory", memory, 0, checks.LONGEST_MEMORY)
    sections = checks.whole("sections", sections, 1, 200)
    warp = checks.prewarp_frequency(prewarp, dt)
    if band is not None and method != "oustaloup":
        raise ValueError(f"band is {band!r}; is Oustaloup's, and does not apply to {method!r}")
    checked = None if check_band is None else checks.band(check_band, dt, "check_band")
    model = _discretised(order, dt, method, memory, sections, warp, band)
    if checked is not None:
        errors = operator_errors(model.response, order, checked)
        warn_if_far(model._described(), order, checked, errors, 2)
    return model


@in_standard_arithmetic
def _discretised(
    order: float,
    dt: float,
    method: str,
    memory: int,
    sections: int,
    warp: float,
    band: Sequence[float] | None,
) -> Discretisation:
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
    return series_sum(taps, np.exp(-1j * angle))


def series_sum(taps: Floats, w: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return sum taps_k w^k at each w, in blocks: Horner's scheme alone would take long."""
    if len(taps) <= _BLOCK:
        return np.asarray(np.polynomial.polynomial.polyval(w, taps))
    rows = np.pad(taps, (0, -len(taps) % _BLOCK)).reshape(-1, _BLOCK)
    parts = rows @ (w.ravel() ** np.arange(_BLOCK)[:, None])
    return _complex(
        np.polynomial.polynomial.polyval(w.ravel() ** _BLOCK, parts, tensor=False)
    ).reshape(w.shape)


def _complex(numbers: ArrayLike) -> NDArray[np.complex128]:
    return np.asarray(numbers, dtype=np.complex128)
