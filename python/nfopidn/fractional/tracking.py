"""The tracking law at another sample time (docs/theory.md has the rules)."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from nfopidn._core import Controller
from nfopidn.fractional import orders as checks

_CHANNELS = ("x", "y", "theta")
_POLES = ("pole_x", "pole_theta", "pole_theta")  # y and theta steer
_LARGEST_POLE = 0.9  # the end of the search's box: a larger one multiplies noise by over twenty


def has_drive_and_steering(controller: Controller) -> bool:
    """Whether drive and steering are states, with pole and integral, as the core has them."""
    allocation = controller.allocation
    decoupled = isinstance(allocation, str) and allocation == "decoupled"
    return decoupled and controller.form == "positional" and controller.uses_tracking_law


def net_taps(controller: Controller) -> NDArray[np.float64]:
    """Return the filters from the errors to the nets, (3, memory + 2) or one tap longer.

    Near the path the speed error is the error's difference of two samples.
    """
    amplitudes = [[getattr(controller, f"amplitude_{name}")] for name in _CHANNELS]
    taps = np.asarray(controller.taps * np.array(amplitudes))
    if controller.net != "speed-errors":
        return taps
    assert controller.gains is not None
    longer = np.hstack([taps, np.zeros((3, 1))])
    for channel in (0, 2):
        longer[channel, 1:] -= taps[channel]
        longer[channel, 0] += controller.gains[channel][0]
    return longer


def schedule(controller: Controller, speed: float) -> float:
    """Return the lateral error's factor with lateral "scheduled"."""
    square = speed**2 + controller.lateral_speed**2
    return float(speed * square ** (-controller.lateral_power / 2))


def rational(controller: Controller) -> list[tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Return each channel's filter from error to net, numerator and denominator in powers of 1/z.

    Pole and integral states stand in it as what a net would do as much. The lateral error is that
    after its schedule.
    """
    # Of a neuron at 0, whatever its amplitude: O = S tanh(net / (2 S)).
    slope = 1.0 if controller.activation == "linear" else 0.5
    found = []
    for name, pole_name, taps in zip(_CHANNELS, _POLES, net_taps(controller), strict=True):
        integral = getattr(controller, f"integral_{name}") / slope
        pole = np.array([1.0, getattr(controller, pole_name)])
        leak = np.array([1.0, -controller.integral_retention])
        numerator, denominator = taps, np.trim_zeros(pole, "b")
        if integral != 0:
            numerator = polynomial.polyadd(polynomial.polymul(taps, leak), integral * pole)
            denominator = polynomial.polymul(denominator, leak)
        found.append((np.asarray(numerator), np.asarray(denominator)))
    return found


def response(controller: Controller, w: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return what those filters do, (3, n), w being exp(-i omega T)."""
    return np.array(
        [
            polynomial.polyval(w, numerator) / polynomial.polyval(w, denominator)
            for numerator, denominator in rational(controller)
        ]
    )


def _derivative(controller: Controller, channel: str, omega: NDArray[np.float64], dt: float) -> Any:
    """Gain of the speed error's derivative for an error, for a speed gain of 1."""
    order = getattr(controller, f"speed_order_{channel}") - 1
    w = np.exp(-1j * omega * dt)
    weights = np.ones(int(controller.memory) + 2)
    for j in range(1, len(weights)):
        weights[j] = weights[j - 1] * (j - 1 - order) / j
    return np.abs((1 - w) * polynomial.polyval(w, weights))


def _pole(name: str, value: float, ratio: float) -> float:
    """Give the pole of the same lead in seconds at low frequencies, T c / (1 + c)."""
    lead = value / (1 + value) / ratio
    largest = _LARGEST_POLE / (1 + _LARGEST_POLE)
    if lead > max(largest, value / (1 + value)):
        warnings.warn(
            f"retune: {name} would have to lead by {lead:.3g} samples, more than a pole can; it is "
            f"{_LARGEST_POLE:g}",
            stacklevel=5,
        )
        return _LARGEST_POLE
    return lead / (1 - lead)


def changes(
    controller: Controller, dt: float, new: float, gains: NDArray[np.float64], memory: Any
) -> dict[str, Any]:
    """Return the settings at the sample time `new`.

    `gains` are those of the same continuous ones (eq. 25), `memory` is the new one.
    """
    ratio = new / dt
    result: dict[str, Any] = {"memory": memory}
    scale = np.ones(3)  # of net and amplitude: what the pole takes away at low frequencies
    for name in ("pole_x", "pole_theta"):
        before = getattr(controller, name)
        result[name] = after = _pole(name, before, ratio)
        for channel in range(3):
            if _POLES[channel] == name:
                scale[channel] = (1 + after) / (1 + before)
    adds = controller.form == "incremental"
    # An increment is in proportion to the sample time, and so is what is added in a sample.
    rate = (ratio if adds else 1.0) / (ratio if controller.net == "increment" else 1.0)
    result["gains"] = gains * scale[:, None] * rate
    longer = controller.replace(memory=memory)
    omega = checks.frequencies(checks.band(None, max(dt, new)))
    for letter, own in (("x", scale[0]), ("theta", scale[2])):
        before = _derivative(controller, letter, omega, dt)
        after = _derivative(longer, letter, omega, new)
        kept = float(np.exp(np.mean(np.log(before / after))))
        name = f"speed_gain_{letter}"
        result[name] = getattr(controller, name) * kept * own * (ratio if adds else 1.0)
    for letter, own in zip(_CHANNELS, scale, strict=True):
        if controller.activation == "sigmoid":
            name = f"amplitude_{letter}"
            result[name] = getattr(controller, name) * own * (ratio if adds else 1.0)
        result[f"integral_{letter}"] = getattr(controller, f"integral_{letter}") * ratio
    result["integral_retention"] = controller.integral_retention**ratio
    return result
