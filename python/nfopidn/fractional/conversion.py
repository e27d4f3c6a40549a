"""Between continuous gains and discrete ones, and to another memory or sample time."""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn import _core
from nfopidn._core import Controller
from nfopidn.arguments import no_rival, real_numbers
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.fractional import orders as checks
from nfopidn.fractional import tracking
from nfopidn.fractional.discretisation import rule_power

PAPER_PREWARP = 15.0
"""The paper's w_c [rad/s] (eq. 25)."""

_LARGE_CHANGE: Final = 0.2  # of a frequency response, beyond which retune warns


def _factors(
    alpha: ArrayLike, sigma: ArrayLike, generator: str, dt: Any, prewarp: float | None
) -> NDArray[np.float64]:
    """Return discrete over continuous gains, (3, 3)."""
    orders = []
    for name, value in (("alpha", alpha), ("sigma", sigma)):
        row = real_numbers(name, value)
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
    table = real_numbers("gains", gains)
    if table.shape != (3, 3):
        raise ValueError(f"gains has shape {table.shape}; must be (3, 3)")
    if not np.isfinite(table).all():
        raise ValueError("gains has a number that is not finite")
    return table


@in_standard_arithmetic
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


@in_standard_arithmetic
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
        responses over the band, in torque for an error, whatever the sample times; 0 for a
        channel whose gains are all 0
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


@in_standard_arithmetic
def controller_response(
    controller: Controller, dt: float, frequency: ArrayLike
) -> NDArray[np.complex128]:
    """Return the response of each channel's filter (eq. 34), (3, n), net for an error.

    With the incremental form the running sum over samples is part of it, and with the tracking law
    the pole and the integral states are. An infinite memory has the operators' closed form.
    """
    omega = np.asarray(frequency, dtype=float)
    w = np.exp(-1j * omega * dt)
    if controller.uses_tracking_law:
        rows = list(tracking.response(controller, w))
    elif isinstance(controller.memory, float):
        assert controller.gains is not None  # free taps have an end
        rule, orders = controller.generator, _orders(controller)
        below = 1 + checks.POLES[rule] * w
        rows = [
            (1 - w) * (kp + kd * rule_power(rule, alpha, omega * dt))
            + ki * below * rule_power(rule, 1 - sigma, omega * dt)
            for (kp, ki, kd), alpha, sigma in zip(controller.gains, *orders, strict=True)
        ]
    else:
        rows = [np.polynomial.polynomial.polyval(w, taps) for taps in controller.taps]
    response = np.array(rows)
    return response / (1 - w) if controller.form == "incremental" else response


def _orders(controller: Controller) -> list[NDArray[np.float64]]:
    pair = (controller.alpha, controller.sigma)
    return [np.broadcast_to(np.asarray(order, dtype=float), 3) for order in pair]


@in_standard_arithmetic
def retune(
    controller: Controller,
    dt: float | None = None,
    *,
    new_dt: float | None = None,
    memory: float | None = None,
    prewarp: float | None = None,
) -> RetuneReport:
    """Return a controller of the same frequency response for another memory or sample time.

    The continuous gains (eq. 25) stay. In the positional form the torque is what the textbook PID
    adds in one sample, which is in proportion to the sample time: there all gains are multiplied by
    dt / new_dt besides. Of the tracking law speed gains, poles with their gains and amplitudes, and
    the integral states' gains and retention are converted too (docs/theory.md).

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
        the memory wanted [samples], or math.inf; None: the same number of samples, which is
        another time where the sample time changes
    prewarp
        w_c of both [rad/s] (eq. 25), below pi/dt of both. None: 0, which keeps the response at
        frequencies far below Nyquist's. The paper's 15 rad/s keeps it at 15 rad/s alone.

    Returns
    -------
    RetuneReport
        The controller, and how far its frequency response is from the old one's.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.

    Warns
    -----
    UserWarning
        If the frequency response of a channel changes by more than a fifth, or a pole of the
        tracking law cannot lead by as much time.
    """
    controller = no_rival(controller)
    if controller.gains is None or controller.alpha is None or controller.sigma is None:
        raise ValueError("controller has free taps; must have gains and orders")
    dt = checks.controller_sample_time(controller, dt)
    new = dt if new_dt is None else checks.number("new_dt", new_dt, *checks.SAMPLE_TIMES, " s")
    orders = (controller.alpha, controller.sigma)
    generator = controller.generator
    gains = controller.gains
    if new != dt:
        continuous = to_continuous(gains, *orders, dt, prewarp=prewarp, generator=generator)
        gains = to_discrete(continuous, *orders, new, prewarp=prewarp, generator=generator)
        if controller.form == "positional" and not controller.uses_tracking_law:
            gains = gains * (dt / new)
    changes: dict[str, Any] = {"sample_time": new}
    if memory is not None:
        longest = checks.LONGEST_CONTROLLER_MEMORY
        changes["memory"] = (
            math.inf if checks.is_infinite(memory) else checks.whole("memory", memory, 0, longest)
        )
    if controller.uses_tracking_law and new != dt:
        length = changes.get("memory", controller.memory)
        changes |= tracking.changes(controller, dt, new, gains, length)
        gains = changes.pop("gains")
    result = controller.replace(gains=gains, **changes)
    band = checks.band(None, max(dt, new))
    omega = checks.frequencies(band)
    before = controller_response(controller, dt, omega)
    after = controller_response(result, new, omega)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = np.where((before == 0) & (after == 0), 1.0, after / before)
    x, y, theta = (float(change) for change in np.abs(ratios - 1).max(axis=1))
    report = RetuneReport(result, new, band, (x, y, theta))
    if max(report.change) > _LARGE_CHANGE:
        warnings.warn(f"retune: {report}", stacklevel=3)
    return report
