"""Nonlinear fractional-order PID neural control of differential-drive robots."""

from nfopidn import fractional, plot, stability, study
from nfopidn._core import (
    Controller,
    Robot,
    Scenario,
    SimulationResult,
    Trajectory,
    __version__,
    simulate,
)
from nfopidn._export import export_c, export_cpp
from nfopidn._search import Forager, OptimizeResult, bfoa
from nfopidn._tuning import Objective, TuneResult, default_bounds, tune

__all__ = [
    "Controller",
    "Forager",
    "Objective",
    "OptimizeResult",
    "Robot",
    "Scenario",
    "SimulationResult",
    "Trajectory",
    "TuneResult",
    "__version__",
    "bfoa",
    "default_bounds",
    "export_c",
    "export_cpp",
    "fractional",
    "plot",
    "simulate",
    "stability",
    "study",
    "tune",
]
