"""Zeros and poles of the controller's filters, and the three-way verdict on them."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Controller, series_weights
from nfopidn.arguments import no_rival, real_number, whole_number
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.fractional.tracking import rational

Place = Literal["inside", "on", "outside"]

#: How near the unit circle a zero or pole counts as on it; np.roots is no better for double roots.
ON_CIRCLE = 1e-6
#: Poles that are further out decide.
STABILITY: dict[Place, str] = {
    "inside": "stable",
    "on": "critically stable",
    "outside": "unstable",
}
MOST_MEMORY = 1024


@dataclass(frozen=True)
class ZPlane:
    """Zeros and poles of a filter in z.

    Attributes
    ----------
    zeros, poles
        complex arrays, largest modulus first
    """

    zeros: NDArray[np.complex128]
    poles: NDArray[np.complex128]

    @property
    def zeros_place(self) -> Place:
        """Where the outermost zero lies: inside, on or outside the unit circle."""
        return _place(self.zeros)

    @property
    def poles_place(self) -> Place:
        """The same of the outermost pole."""
        return _place(self.poles)

    @property
    def verdict(self) -> str:
        """Stable, critically stable or unstable: poles inside, on or outside the unit circle."""
        return STABILITY[self.poles_place]

    def __str__(self) -> str:
        return (
            f"{self.verdict}: {_text('pole', self.poles, self.poles_place)}; "
            f"{_text('zero', self.zeros, self.zeros_place)}"
        )


@dataclass(frozen=True)
class ControllerStability:
    """Zeros and poles of the filters from the errors x, y, theta to the neurons' inputs.

    In incremental form the neurons' outputs are summed up: a pole at 1 that all channels share, and
    that each has here.
    """

    x: ZPlane
    y: ZPlane
    theta: ZPlane

    @property
    def channels(self) -> dict[str, ZPlane]:
        """The channels by name."""
        return {"x": self.x, "y": self.y, "theta": self.theta}

    @property
    def verdict(self) -> str:
        """The verdict of the channel whose poles are furthest out."""
        names = list(STABILITY.values())
        return max((plane.verdict for plane in self.channels.values()), key=names.index)

    def __str__(self) -> str:
        return "\n".join(f"{name}: {plane}" for name, plane in self.channels.items())


def _place(roots: NDArray[np.complex128]) -> Place:
    size = float(np.max(np.abs(roots), initial=0.0))
    if abs(size - 1) <= ON_CIRCLE:
        return "on"
    return "inside" if size < 1 else "outside"


def _text(name: str, roots: NDArray[np.complex128], place: Place) -> str:
    if not roots.size:
        return f"no {name}s"
    count = f"{len(roots)} {name}" + ("s" if len(roots) > 1 else "")
    return f"{count} {place} the unit circle, largest modulus {np.max(np.abs(roots)):.4g}"


def _filter(coefficients: NDArray[np.float64], sums: bool) -> ZPlane:
    """Return sum_j coefficients[j] z^-j, times z/(z - 1) if it sums its output up."""
    if not np.any(coefficients):
        none = np.empty(0, dtype=np.complex128)
        return ZPlane(zeros=none, poles=none)
    zeros = np.roots(coefficients).astype(np.complex128)
    poles = np.zeros(len(coefficients) - 1, dtype=np.complex128)
    if sums:
        poles = poles[1:]
        at_one = np.flatnonzero(np.abs(zeros - 1) <= ON_CIRCLE)
        if at_one.size:
            zeros = np.delete(zeros, at_one[0])
        else:
            poles = np.append(1.0, poles)
    return ZPlane(zeros=zeros[np.argsort(-np.abs(zeros), kind="stable")], poles=poles)


def _rational(
    numerator: NDArray[np.float64], denominator: NDArray[np.float64], sums: bool
) -> ZPlane:
    """Return a filter in powers of 1/z, times z/(z - 1) if it sums its output up."""
    count = max(len(numerator), len(denominator))
    plane = _filter(np.pad(numerator, (0, count - len(numerator))), sums)
    if not np.any(numerator):
        return plane
    own = np.roots(denominator).astype(np.complex128)
    # They take the place of as many at 0.
    poles = np.append(own, plane.poles[: len(plane.poles) - len(own)])
    return ZPlane(plane.zeros, poles[np.argsort(-np.abs(poles), kind="stable")])


def short_memory(controller: Controller) -> Controller:
    """Refuse a memory whose matrices would be too large."""
    if not controller.memory <= MOST_MEMORY:
        raise ValueError(
            f"controller has memory {controller.memory}; must be in [0, {MOST_MEMORY}] samples"
        )
    return controller


@in_standard_arithmetic
def controller(controller: Controller) -> ControllerStability:
    """Return zeros and poles of a controller's channels.

    A channel is sum_j taps[j] z^-j (eq. 34 with the memory's M + 2 taps), in incremental form times
    z/(z - 1) (eqs. 35-36). Without that its poles are all at 0: no gains and orders of a truncated
    operator make the controller itself unstable, and nothing is said of the loop. With the tracking
    law the speed errors are differences of the errors, as near the path, the lateral error is that
    after its schedule, and pole and integral states within their limit belong to it.

    Parameters
    ----------
    controller
        whose taps are taken

    Returns
    -------
    ControllerStability
        one `ZPlane` a channel

    Raises
    ------
    ValueError
        If the controller's memory is beyond 1024 samples.

    Examples
    --------
    >>> import nfopidn
    >>> print(nfopidn.stability.controller(nfopidn.Controller.published()).verdict)
    stable
    >>> incremental = nfopidn.Controller.published(form="incremental")
    >>> print(nfopidn.stability.controller(incremental).verdict)
    critically stable
    """
    controller = short_memory(no_rival(controller))
    sums = controller.form == "incremental"
    if controller.uses_tracking_law:
        return ControllerStability(*(_rational(*one, sums) for one in rational(controller)))
    planes = [_filter(taps, sums) for taps in controller.taps]
    return ControllerStability(*planes)


@in_standard_arithmetic
def operator(
    order: float, memory: int = 5, generator: Literal["tustin", "gl"] = "tustin"
) -> ZPlane:
    """Return zeros and poles of a truncated fractional operator, as the paper's Fig. 3 shows them.

    The operator is sum_j w_j z^-j for j up to `memory`, with the weights of
    ((1 - z^-1)/(1 + z^-1))^order (tustin, eq. 16) or of (1 - z^-1)^order (gl). A factor s^order has
    besides is a number, and moves nothing.

    Parameters
    ----------
    order
        [-2, 2]: alpha of a derivative, minus sigma of an integral
    memory
        terms M, [0, 1024]
    generator
        of the power series

    Returns
    -------
    ZPlane
        `memory` zeros, and as many poles, at 0

    Raises
    ------
    ValueError
        If an argument is out of range.

    Examples
    --------
    >>> import nfopidn
    >>> print(nfopidn.stability.operator(0.5, memory=2))
    stable: 2 poles inside the unit circle, largest modulus 0; 2 zeros inside the unit circle, \
largest modulus 0.7071
    """
    order = real_number("order", order, -2, 2)
    memory = whole_number("memory", memory, 0, MOST_MEMORY)
    if generator not in ("tustin", "gl"):
        raise ValueError(f"generator is {generator!r}; must be one of 'tustin', 'gl'")
    return _filter(series_weights(0.0 if generator == "gl" else 1.0, order, memory), sums=False)
