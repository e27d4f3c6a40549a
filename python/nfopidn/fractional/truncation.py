"""How far a controller's truncated operators are from the fractional ones."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from nfopidn._core import Controller
from nfopidn.arguments import no_rival
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
        "s^alpha" or "s^-sigma"; "gl s^(alpha - 1) of the speed error" with net "speed-errors"
    order
        alpha, -sigma or alpha - 1
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
    differentiator, as its weights never decay. An infinite memory is not truncated. Where the
    tracking law's net is made of the errors themselves (docs/theory.md), the integral is the
    truncated series of s^-sigma alone, and operators without a gain are left out.

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
    if controller.alpha is None or controller.sigma is None:
        raise ValueError("controller has free taps; must have gains and orders")
    dt = checks.controller_sample_time(controller, dt)
    edges = checks.band(band, dt)
    alphas, sigmas = (
        np.broadcast_to(np.asarray(o, dtype=float), 3) for o in (controller.alpha, controller.sigma)
    )
    pairs = list(zip(("x", "y", "theta"), alphas.tolist(), sigmas.tolist(), strict=True))
    memory, rule = controller.memory, controller.generator
    if controller.net != "increment":
        operators = _of_whole_nets(controller, pairs)
    else:
        if len({pair[1:] for pair in pairs}) == 1:
            pairs = [("all", *pairs[0][1:])]
        operators = [
            one
            for channel, alpha, sigma in pairs
            for one in (
                _Operator(channel, "s^alpha", alpha, rule, alpha, memory),
                _Operator(channel, "s^-sigma", -sigma, rule, 1 - sigma, memory),
            )
        ]
    entries = []
    omega = checks.frequencies(edges)
    for channel, operator, order, own_rule, series, terms in operators:
        scale = (1 + checks.POLES[own_rule]) / dt
        if isinstance(terms, float):
            power = rule_power(own_rule, series, omega * dt)
        else:
            # Not discretise(), which has whole orders exactly: the controller truncates them.
            power = truncated_power(own_rule, series, omega * dt, terms)
        # Of the integral of eq. 34 one order is the rule's own 1/s.
        whole: Any = 1.0
        if order != series:
            whole = 1 / (scale * rule_power(own_rule, 1.0, omega * dt))
        sizes = worst_errors(scale**series * power * whole / (1j * omega) ** order)
        entries.append(OperatorError(channel, operator, order, *sizes))
        if band is not None:
            named = operator if channel == "all" else f"{operator} of channel {channel}"
            warn_if_far(f"the controller's {named}", order, edges, sizes, 3)
    return TruncationReport(memory, controller.generator, dt, edges, tuple(entries))


class _Operator(NamedTuple):
    channel: str
    name: str
    order: float
    rule: str
    series: float  # order of the truncated series
    memory: float  # its last power


def _of_whole_nets(
    controller: Controller, pairs: list[tuple[str, float, float]]
) -> list[_Operator]:
    """Give the operators that have a gain, where sums run over the error itself."""
    assert controller.gains is not None
    last, rule = controller.memory + 1, controller.generator
    found = []
    for (channel, alpha, sigma), (_, integral, derivative) in zip(
        pairs, controller.gains.tolist(), strict=True
    ):
        if derivative != 0:
            found.append(_Operator(channel, "s^alpha", alpha, rule, alpha, last))
        if integral != 0:
            found.append(_Operator(channel, "s^-sigma", -sigma, rule, -sigma, last))
        if controller.net == "speed-errors" and channel != "y":
            order = getattr(controller, f"speed_order_{channel}") - 1
            name = "gl s^(alpha - 1) of the speed error"
            found.append(_Operator(channel, name, order, "gl", order, last))
    return found
