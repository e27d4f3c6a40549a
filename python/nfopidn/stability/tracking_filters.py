"""The tracking law on a straight line, where it is three filters of the error."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from nfopidn._core import Controller

Array = NDArray[np.float64]


def _difference_weights(order: float, count: int) -> Array:
    """Give the first weights of (1 - w)^order."""
    steps = (np.arange(1, count) - 1 - order) / np.arange(1, count)
    return np.cumprod(np.append(1.0, steps))


def tracking_filters(controller: Controller, speed: float) -> tuple[list[Array], list[Array]]:
    """Give numerators and denominators of the filters of e_x, e_y and e_theta, in powers of w.

    Near a straight line a speed error is the pose error's difference, n(k) = e(k) - e(k-1), the
    neuron has its slope at 0, and the limit of the integral states is not reached: with the pole c
    and the retention l the filter of a channel is

        slope F(w) / (1 + c w) + k_i / (1 - l w),
        F(w) = k_p + k_d (1 - w) sum_j g_j w^j.

    Parameters
    ----------
    controller
        with net "speed-errors" and the decoupled allocation
    speed
        of the reference [m/s]

    Raises
    ------
    ValueError
        Another net, allocation or memory than the tracking law's.
    """
    if controller.net != "speed-errors" or controller.allocation != "decoupled":
        raise ValueError(
            "the controller has parts of the tracking law without its speed errors, or another "
            "allocation than the decoupled one; margins are known of the whole tracking law alone"
        )
    count = int(controller.memory) + 2
    slope = 1.0 if controller.activation == "linear" else 0.5
    gains = np.asarray(controller.gains, dtype=float)[:, 0]
    factor = {
        "plain": 1.0,
        "direction": float(np.sign(speed)),
        "scheduled": speed
        * (speed**2 + controller.lateral_speed**2) ** (-0.5 * controller.lateral_power),
    }
    if controller.lateral not in factor:
        raise ValueError(f"lateral is {controller.lateral!r}; must be one of {', '.join(factor)}")
    lateral = factor[controller.lateral]
    numerators, denominators = [], []
    steers = controller.integral_y != 0 or controller.integral_theta != 0
    for channel, gain, integral, scale, own, integrates in (
        ("x", gains[0], controller.integral_x, 1.0, controller.pole_x, controller.integral_x != 0),
        ("y", gains[1], controller.integral_y, lateral, controller.pole_theta, steers),
        ("theta", gains[2], controller.integral_theta, 1.0, controller.pole_theta, steers),
    ):
        net = np.array([gain])
        if channel != "y":
            weights = _difference_weights(
                getattr(controller, f"speed_order_{channel}") - 1, count
            ) * getattr(controller, f"speed_gain_{channel}")
            net = polynomial.polyadd(net, polynomial.polymul([1.0, -1.0], weights))
        # An integral state that nothing enters is no pole of the loop.
        held = np.array([1.0, -controller.integral_retention] if integrates else [1.0])
        delayed = np.array([1.0, own])
        numerator = polynomial.polyadd(
            polynomial.polymul(slope * scale * net, held), integral * scale * delayed
        )
        numerators.append(np.asarray(numerator, dtype=float))
        denominators.append(np.asarray(polynomial.polymul(held, delayed), dtype=float))
    return numerators, denominators


def state_space(
    numerators: Sequence[Array], denominator: Array
) -> tuple[Array, Array, Array, Array]:
    """Give A, B, C, D of a sum of filters in powers of w with one denominator, an input each.

    It is the transposed direct form II, which has no more states than the longest polynomial.
    """
    size = max(map(len, [*numerators, denominator])) - 1
    below = np.zeros(size + 1)
    below[: len(denominator)] = denominator
    above = np.zeros((size + 1, len(numerators)))
    for column, numerator in enumerate(numerators):
        above[: len(numerator), column] = numerator
    step = np.eye(size, k=1)
    step[:, 0] -= below[1:]
    return step, above[1:] - np.outer(below[1:], above[0]), np.eye(1, size)[0], above[0]
