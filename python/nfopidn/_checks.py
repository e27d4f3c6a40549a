"""Refusals that several modules share."""

from __future__ import annotations

from numbers import Integral, Real
from typing import Any

import numpy as np

from nfopidn._core import Controller, Rival

_MOST = 10**9


def is_number(value: Any) -> bool:
    """Whether a value is a real number, infinity included, and no bool."""
    if isinstance(value, bool | np.bool_) or not isinstance(value, Real | np.number):
        return False
    try:
        return not np.isnan(float(value))
    except (OverflowError, TypeError):
        return False


def whole_number(name: str, value: Any, least: int, most: int = _MOST) -> int:
    """Return a whole number in [least, most], 1e9 if not given.

    Raises
    ------
    ValueError
        Names the argument, its value and the range.
    """
    whole = isinstance(value, Integral) and not isinstance(value, bool)
    if not whole or not least <= int(value) <= most:
        end = "1e9" if most == _MOST else most
        raise ValueError(f"{name} is {value!r}; must be a whole number in [{least}, {end}]")
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
