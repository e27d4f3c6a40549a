"""Pickles of the core's classes, by every protocol.

By themselves protocols 0 and 1 would make an object of the core without its constructor, which
ends the interpreter.
"""

from __future__ import annotations

import copyreg
from typing import Any

from nfopidn._core import (
    Controller,
    CostFunction,
    Rival,
    Robot,
    SampleFilter,
    Scenario,
    SimulationResult,
    Trajectory,
)


def _reduce(value: Any) -> tuple[Any, ...]:
    return copyreg.__newobj__, (type(value),), value.__getstate__()  # type: ignore[attr-defined]


def _refuse(value: Any) -> tuple[Any, ...]:
    raise TypeError(f"cannot pickle a {type(value).__name__}")


def register() -> None:
    """Tell pickle and copy how it is done."""
    for kind in (Controller, Rival, Robot, Scenario, SimulationResult, Trajectory):
        copyreg.pickle(kind, _reduce)
    for other in (CostFunction, SampleFilter):
        copyreg.pickle(other, _refuse)
