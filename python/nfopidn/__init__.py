"""Nonlinear fractional-order PID neural control of differential-drive robots."""

from nfopidn import _pickle, fractional, plot, stability, study
from nfopidn._bfoa import bfoa
from nfopidn._compare import Comparison, compare, scenario_suite, tune_contenders
from nfopidn._core import (
    Controller,
    Rival,
    Robot,
    Scenario,
    SimulationResult,
    Trajectory,
    __version__,
    simulate,
)
from nfopidn._export import export_c, export_cpp
from nfopidn._forager import Forager
from nfopidn._objective import Objective
from nfopidn._parameters import default_bounds
from nfopidn._report import report
from nfopidn._search import OptimizeResult
from nfopidn._tune_result import TuneResult
from nfopidn._tuning import tune

_pickle.register()

__all__ = [
    "Comparison",
    "Controller",
    "Forager",
    "Objective",
    "OptimizeResult",
    "Rival",
    "Robot",
    "Scenario",
    "SimulationResult",
    "Trajectory",
    "TuneResult",
    "__version__",
    "bfoa",
    "compare",
    "default_bounds",
    "export_c",
    "export_cpp",
    "fractional",
    "plot",
    "report",
    "scenario_suite",
    "simulate",
    "stability",
    "study",
    "tune",
    "tune_contenders",
]
