"""A law as tables: gains and orders, taps, or a rival's parameters, and its settings."""

from __future__ import annotations

import json
from dataclasses import dataclass

from nfopidn._core import Controller, Rival
from nfopidn.export.design import DECOUPLED, PAPER
from nfopidn.reporting.numbers import readable
from nfopidn.reporting.settings import Row, setting_row
from nfopidn.reporting.words import CONTROLLER, MADE_FOR, RIVAL, Words

_ALLOCATIONS = {"paper": PAPER, "decoupled": DECOUPLED}
_LONGEST_TAPS = 64  # rows of the table


@dataclass
class Law:
    """What a page says of a law; the tables that it does not have are empty."""

    name: str
    settings: list[Row]
    gains: list[tuple[str, list[str]]]  # a row for each channel: gains, then orders
    taps: list[list[str]]  # a row for each past sample, newest first
    more_taps: int
    parameters: list[Row]


def law_of(controller: Controller | Rival) -> Law:
    """Return the tables of a law."""
    if isinstance(controller, Rival):
        name = f"{controller.law.capitalize()}, a rival of the neural controller,"
        return Law(name, _rival_rows(controller), [], [], 0, _rival_parameters(controller))
    gains = gains_table(controller)
    taps, more = ([], 0) if gains else taps_table(controller)
    name = "Nonlinear fractional-order PID neural controller"
    return Law(name, _controller_rows(controller), gains, taps, more, [])


def gains_table(controller: Controller) -> list[tuple[str, list[str]]]:
    """Return a row for each channel: gains, then orders; empty for free taps."""
    gains, alpha, sigma = controller.gains, controller.alpha, controller.sigma
    if gains is None or alpha is None or sigma is None:
        return []
    rows = []
    for i, channel in enumerate(("x, forward", "y, lateral", "θ, heading")):
        orders = [one if isinstance(one, int | float) else one[i] for one in (alpha, sigma)]
        rows.append((channel, [readable(value, 6) for value in (*gains[i], *orders)]))
    return rows


def taps_table(controller: Controller) -> tuple[list[list[str]], int]:
    """Return rows of taps, newest sample first, and how many more there are."""
    taps = controller.taps.T
    rows = [[readable(value, 6) for value in row] for row in taps[:_LONGEST_TAPS]]
    return rows, max(0, len(taps) - _LONGEST_TAPS)


def _rival_parameters(rival: Rival) -> list[Row]:
    rows = []
    for name, unit, _, _, meaning in Rival.describe(rival.law, rival.integral):
        value = f"{readable(rival.parameters[name], 6)} {unit.replace('^2', '²')}"
        rows.append(Row(name, value.rstrip(), meaning))
    return rows


def _rival_rows(rival: Rival) -> list[Row]:
    robot = json.loads(rival.to_json())["robot"]
    rows = [setting_row(key, getattr(rival, key), RIVAL[key]) for key in ("law", "speeds")]
    return rows + [setting_row(key, robot[key], RIVAL[key]) for key in robot]


#: Beginnings of the names of settings that only the tracking law has.
_TRACKING = ("net", "speed_gain", "speed_order", "amplitude", "pole", "integral")


def _controller_rows(controller: Controller) -> list[Row]:
    """Return the settings of a controller other than gains, orders and taps."""
    document = json.loads(controller.to_json())
    robot = document.get("robot") or {}
    left_out = {"robot", "format", "version", "gains", "alpha", "sigma", "taps", "allocation"}
    if controller.lateral != "speed":
        left_out.add("speed_scale")
    if controller.lateral != "scheduled":
        left_out |= {"lateral_speed", "lateral_power"}
    if controller.net == "increment":
        left_out |= {key for key in document if key.startswith(_TRACKING)}
    rows = [
        setting_row(key, value, CONTROLLER.get(key, Words(key, "", "")))
        for key, value in document.items()
        if key not in left_out
    ]
    rows += [setting_row(key, value, MADE_FOR[key]) for key, value in robot.items()]
    return [*rows, _allocation(controller)]


def _allocation(controller: Controller) -> Row:
    given = controller.allocation
    matrix = _ALLOCATIONS[given] if isinstance(given, str) else given.tolist()
    wheels = [
        f"{side} [{', '.join(readable(share) for share in row)}]"
        for side, row in zip(("left", "right"), matrix, strict=True)
    ]
    name = f"{given}: " if isinstance(given, str) else ""
    words = CONTROLLER["allocation"]
    return Row(words.label, f"{name}{', '.join(wheels)} of x, y, θ", words.meaning)
