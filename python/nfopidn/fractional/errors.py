"""How far an operator is from the power of s that it is named after."""

from __future__ import annotations

import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.fractional import orders as checks

Complex = NDArray[np.complex128]

_CLOSE: Final = (0.01, 1.0)  # |magnitude ratio - 1| and degrees
_FAR: Final = (0.2, 10.0)


def worst_errors(ratio: Complex) -> tuple[float, float]:
    """Return the largest |magnitude - 1| [-] and phase [degree] of ratios that should be 1."""
    return float(np.abs(np.abs(ratio) - 1).max()), float(np.abs(np.angle(ratio, deg=True)).max())


@in_standard_arithmetic
def operator_errors(
    response: Callable[[Any], Complex], order: float, edges: tuple[float, float]
) -> tuple[float, float]:
    """Return the worst errors of a frequency response against (j omega)^order over a band."""
    omega = checks.frequencies(edges)
    return worst_errors(response(omega) / (1j * omega) ** order)


def verdict(errors: tuple[float, float]) -> str:
    """Return in words what errors of that size make of an operator."""
    if _within(errors, _CLOSE):
        return "a fractional operator"
    if _within(errors, _FAR):
        return "roughly a fractional operator"
    return "not the fractional operator it is named after"


def _within(errors: tuple[float, float], limits: tuple[float, float]) -> bool:
    return errors[0] < limits[0] and errors[1] < limits[1]


def worded(errors: tuple[float, float]) -> str:
    """Return errors in words."""
    magnitude, phase = errors
    return f"magnitude off by up to {100 * magnitude:.3g} %, phase by {phase:.3g} degrees"


def warn_if_far(
    what: str, order: float, edges: tuple[float, float], errors: tuple[float, float], level: int
) -> None:
    """Warn of an operator that is off by a fifth or by 10 degrees; `level` as for the caller."""
    if not _within(errors, _FAR):
        low, high = edges
        warnings.warn(
            f"{what} is not s^{order:g} from {low:.3g} to {high:.3g} rad/s: {worded(errors)}",
            stacklevel=level + 1,
        )


class PowerOfS(ABC):
    """What stands for (j omega)^order and has a frequency response to compare with it."""

    if TYPE_CHECKING:

        @property
        def order(self) -> float:
            """The power."""

        @property
        def dt(self) -> float:
            """Sample time [s]."""

    @abstractmethod
    def response(self, frequency: ArrayLike) -> Complex:
        """Return the frequency response."""

    @abstractmethod
    def _described(self) -> str:
        """Say in words what it is."""

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

        Warns
        -----
        UserWarning
            If over a band that is given the filter is not s^order: off by a fifth or by 10 degrees.
        """
        edges = checks.band(band, self.dt)
        found = operator_errors(self.response, self.order, edges)
        if band is not None:
            warn_if_far(self._described(), self.order, edges, found, 2)
        return found
