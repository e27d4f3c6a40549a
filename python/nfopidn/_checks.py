"""Refusals that several modules share."""

from __future__ import annotations

from typing import Any

from nfopidn._core import Controller, Rival


def no_rival(controller: Any) -> Controller:
    """Return an NFOPIDN controller.

    Raises
    ------
    ValueError
        A rival, which has neither taps nor orders.
    """
    if isinstance(controller, Rival):
        raise ValueError(f"controller is the rival {controller.law!r}; must be a Controller")
    given: Controller = controller
    return given
