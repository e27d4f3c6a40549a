"""Nonlinear fractional-order PID neural control of differential-drive robots."""

from nfopidn import plot
from nfopidn._core import (
    Controller,
    Robot,
    Scenario,
    SimulationResult,
    Trajectory,
    __version__,
    simulate,
)

__all__ = [
    "Controller",
    "Robot",
    "Scenario",
    "SimulationResult",
    "Trajectory",
    "__version__",
    "plot",
    "simulate",
]
