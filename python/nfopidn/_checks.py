"""Refusals that several modules share."""

from __future__ import annotations

from numbers import Integral
from typing import Any

from nfopidn._core import Controller, Rival

_MOST = 10**9


def whole_number(name: str, value: Any, least: int) -> int:
    """Return a whole number in [least, 1e9].

    Raises
    ------
    ValueError
        Names the argument, its value and the range.
    """
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or not least <= int(value) <= _MOST:
        raise ValueError(f"{name} is {value!r}; must be a whole number in [{least}, 1e9]")
    return int(value)


def no_rival(controller: Any) -> Controller:
    """Return an NFOPIDN controller.

    Raises
    ------
    ValueError
        A rival, which has neither taps nor orders, or no controller at all.
    """
    if isinstance(controller, Rival):
        raise ValueError(f"controller is the rival {controller.law!r}; must be a Controller")
    if not isinstance(controller, Controller):
        raise ValueError(f"controller is {controller!r}; must be a Controller")
    return controller
