"""Between continuous gains and discrete ones, and to another memory or sample time."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn import _core
from nfopidn._checks import no_rival
from nfopidn._core import Controller
from nfopidn.fractional import _checks as checks

PAPER_PREWARP = 15.0
"""The paper's w_c [rad/s] (eq. 25)."""


def _factors(
    alpha: ArrayLike, sigma: ArrayLike, generator: str, dt: Any, prewarp: float | None
) -> NDArray[np.float64]:
    """Return discrete over continuous gains, (3, 3)."""
    orders = []
    for name, value in (("alpha", alpha), ("sigma", sigma)):
        row = np.asarray(value, dtype=float)
        if row.size not in {1, 3} or row.ndim > 1:
            raise ValueError(f"{name} has {row.size} numbers; must have 1 or 3")
        for entry in row.ravel():
            checks.order(name, float(entry))
        orders.append(np.broadcast_to(row, 3))
    if generator not in {"tustin", "gl"}:
        raise ValueError(f"generator is {generator!r}; must be one of tustin, gl")
    time = checks.sample_time(dt)
    warp = checks.prewarp_frequency(None if generator == "gl" else prewarp, time)
    pairs = zip(*orders, strict=True)
    return np.array([_core.gain_factors(generator, a, s, time, warp) for a, s in pairs])


def _gains(gains: ArrayLike) -> NDArray[np.float64]:
    table = np.asarray(gains, dtype=float)
    if table.shape != (3, 3):
        raise ValueError(f"gains has shape {table.shape}; must be (3, 3)")
    if not np.isfinite(table).all():
        raise ValueError("gains has a number that is not finite")
    return table


def to_discrete(
    gains: ArrayLike,
    alpha: ArrayLike,
    sigma: ArrayLike,
    dt: float,
    *,
    prewarp: float | None = PAPER_PREWARP,
    generator: str = "tustin",
) -> NDArray[np.float64]:
    """Return the discrete gains of eq. 34 of continuous ones (eq. 25).

    kp = Kp, ki = Ki scale^-sigma, kd = Kd scale^alpha; scale is w_c/tan(w_c dt/2) with Tustin's
    rule and 1/dt with gl.

    Parameters
    ----------
    gains
        (3, 3): rows x, y, theta; columns Kp, Ki, Kd
    alpha, sigma
        orders in (-2, 2), one or three
    dt
        sample time [s]
    prewarp
        w_c [rad/s], below pi/dt; None: 0, that is scale 2/dt. Not used with gl
    generator
        "tustin" or "gl"

    Returns
    -------
    array
        (3, 3)

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    """
    return _gains(gains) * _factors(alpha, sigma, generator, dt, prewarp)


def to_continuous(
    gains: ArrayLike,
    alpha: ArrayLike,
    sigma: ArrayLike,
    dt: float,
    *,
    prewarp: float | None = PAPER_PREWARP,
    generator: str = "tustin",
) -> NDArray[np.float64]:
    """Return the continuous gains of discrete ones: the inverse of to_discrete."""
    return _gains(gains) / _factors(alpha, sigma, generator, dt, prewarp)


@dataclass(frozen=True)
class RetuneReport:
    """What retune has done.

    Attributes
    ----------
    controller
        the new one
    dt
        its sample time [s]
    band
        (low, high) [rad/s] over which the two are compared
    change
        (3,) for the channels x, y, theta: the largest |new/old - 1| of the filters' frequency
        responses over the band, in torque for an error, whatever the sample times
    """

    controller: Controller
    dt: float
    band: tuple[float, float]
    change: tuple[float, float, float]

    def __str__(self) -> str:
        low, high = self.band
        parts = [
            f"{name} {100 * change:.3g} %"
            for name, change in zip(("x", "y", "theta"), self.change, strict=True)
        ]
        return (
            f"largest change of the frequency response from {low:.3g} to {high:.3g} rad/s: "
            + ", ".join(parts)
        )


def controller_response(
    controller: Controller, dt: float, frequency: ArrayLike
) -> NDArray[np.complex128]:
    """Return the response of each channel's filter (eq. 34), (3, n), net for an error.

    With the incremental form the running sum over samples is part of it.
    """
    if isinstance(controller.memory, float):
        raise ValueError("memory is inf; must be finite for a response")
    w = np.exp(-1j * np.asarray(frequency, dtype=float) * dt)
    rows = [np.polynomial.polynomial.polyval(w, taps) for taps in controller.taps]
    response = np.array(rows)
    return response / (1 - w) if controller.form == "incremental" else response


def retune(
    controller: Controller,
    dt: float | None = None,
    *,
    new_dt: float | None = None,
    memory: float | None = None,
    prewarp: float | None = PAPER_PREWARP,
) -> RetuneReport:
    """Return a controller of the same continuous gains for another memory or sample time.

    Parameters
    ----------
    controller
        with gains and orders, not free taps
    dt
        the sample time it was made for [s]; None: its own. It must be given where the controller
        does not know its own, and must be that one where it does
    new_dt
        the one wanted [s]; None: the same. It is the result's sample_time
    memory
        the memory wanted [samples], or math.inf; None: the same
    prewarp
        w_c of both [rad/s] (eq. 25)

    Returns
    -------
    RetuneReport
        The controller, and how far its frequency response is from the old one's.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.
    """
    controller = no_rival(controller)
    if controller.gains is None or controller.alpha is None or controller.sigma is None:
        raise ValueError("controller has free taps; must have gains and orders")
    dt = checks.controller_sample_time(controller, dt)
    new = dt if new_dt is None else checks.number("new_dt", new_dt, 0.0, math.inf, " s")
    orders = (controller.alpha, controller.sigma)
    generator = controller.generator
    continuous = to_continuous(controller.gains, *orders, dt, prewarp=prewarp, generator=generator)
    gains = to_discrete(continuous, *orders, new, prewarp=prewarp, generator=generator)
    changes: dict[str, Any] = {} if memory is None else {"memory": memory}
    changes["sample_time"] = new
    result = controller.replace(gains=gains if new != dt else controller.gains, **changes)
    band = checks.band(None, max(dt, new))
    omega = checks.frequencies(band)
    before = controller_response(_finite(controller), dt, omega)
    after = controller_response(_finite(result), new, omega)
    x, y, theta = (float(change) for change in np.abs(after / before - 1).max(axis=1))
    return RetuneReport(result, new, band, (x, y, theta))


def _finite(controller: Controller) -> Controller:
    """Return it with a memory long enough to stand for an infinite one."""
    return (
        controller.replace(memory=100_000) if isinstance(controller.memory, float) else controller
    )
