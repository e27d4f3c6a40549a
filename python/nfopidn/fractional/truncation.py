"""How far a controller's truncated operators are from the fractional ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from nfopidn._core import Controller
from nfopidn.arguments import no_rival, no_tracking_law
from nfopidn.arithmetic import in_standard_arithmetic
from nfopidn.fractional import orders as checks
from nfopidn.fractional.discretisation import rule_power, truncated_power
from nfopidn.fractional.errors import verdict, warn_if_far, worded, worst_errors


@dataclass(frozen=True)
class OperatorError:
    """The worst errors of one operator over the band.

    Attributes
    ----------
    channel
        "x", "y", "theta", or "all"
    operator
        "s^alpha" or "s^-sigma"
    order
        alpha or -sigma
    magnitude
        largest |magnitude ratio - 1| [-]
    phase
        largest phase difference [degree]
    """

    channel: str
    operator: str
    order: float
    magnitude: float
    phase: float


@dataclass(frozen=True)
class TruncationReport:
    """The operators of a controller against s^alpha and s^-sigma.

    Attributes
    ----------
    memory, generator, dt
        of the controller; dt [s]
    band
        (low, high) [rad/s]
    errors
        an entry for each operator
    """

    memory: float
    generator: str
    dt: float
    band: tuple[float, float]
    errors: tuple[OperatorError, ...]

    def __str__(self) -> str:
        low, high = self.band
        lines = [
            f"{self.generator}, memory {self.memory:g}, {self.dt:g} s, "
            f"{low:.3g} to {high:.3g} rad/s ({_samples(self)}):"
        ]
        for error in self.errors:
            sizes = (error.magnitude, error.phase)
            channel = "" if error.channel == "all" else f"channel {error.channel}, "
            lines.append(
                f"  {channel}{error.operator} ({error.order:+.4g}): {worded(sizes)}; "
                f"{verdict(sizes)}"
            )
        return "\n".join(lines)


def _samples(report: TruncationReport) -> str:
    turns = 2 * math.pi / report.dt / np.array(report.band[::-1])
    return f"{turns[0]:.3g} to {turns[1]:.3g} samples a period"


@in_standard_arithmetic
def truncation_report(
    controller: Controller, dt: float | None = None, band: Sequence[float] | None = None
) -> TruncationReport:
    """Return how far a controller's operators are from s^alpha and s^-sigma.

    The integral of eq. 34 is the series of s^(1 - sigma), cut after the memory, times the rule's
    1/s, which is exact. Whole orders are truncated like any other: with Tustin's rule s^1 is no
    differentiator, as its weights never decay. An infinite memory is not truncated.

    Parameters
    ----------
    controller
        with gains and orders, not free taps
    dt
        sample time [s]; None: the controller's own, which it must be where the controller has one
    band
        (low, high) [rad/s], up to pi/dt; None: the decade that ends at a tenth of it

    Returns
    -------
    TruncationReport
        print() shows it in words and numbers.

    Raises
    ------
    ValueError
        Names the argument, its value and what is allowed.

    Warns
    -----
    UserWarning
        If over a band that is given an operator is off by a fifth or by 10 degrees.
    """
    controller = no_rival(controller)
    no_tracking_law(controller)
    if controller.alpha is None or controller.sigma is None:
        raise ValueError("controller has free taps; must have gains and orders")
    dt = checks.controller_sample_time(controller, dt)
    edges = checks.band(band, dt)
    alphas, sigmas = (
        np.broadcast_to(np.asarray(o, dtype=float), 3) for o in (controller.alpha, controller.sigma)
    )
    pairs = list(zip(("x", "y", "theta"), alphas.tolist(), sigmas.tolist(), strict=True))
    if len({pair[1:] for pair in pairs}) == 1:
        pairs = [("all", *pairs[0][1:])]
    memory, rule = controller.memory, controller.generator
    entries = []
    omega = checks.frequencies(edges)
    scale = (1 + checks.POLES[rule]) / dt
    integrator = 1 / (scale * rule_power(rule, 1.0, omega * dt))
    for channel, alpha, sigma in pairs:
        for operator, order, series, whole in (
            ("s^alpha", alpha, alpha, 1.0),
            ("s^-sigma", -sigma, 1 - sigma, integrator),
        ):
            if isinstance(memory, float):
                power = rule_power(rule, series, omega * dt)
            else:
                # Not discretise(), which has whole orders exactly: the controller truncates them.
                power = truncated_power(rule, series, omega * dt, memory)
            ratio = scale**series * power * whole / (1j * omega) ** order
            sizes = worst_errors(ratio)
            entries.append(OperatorError(channel, operator, order, *sizes))
            if band is not None:
                named = operator if channel == "all" else f"{operator} of channel {channel}"
                warn_if_far(f"the controller's {named}", order, edges, sizes, 3)
    return TruncationReport(memory, controller.generator, dt, edges, tuple(entries))
