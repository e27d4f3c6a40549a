"""Nonlinear fractional-order PID neural control of differential-drive robots."""

from nfopidn import families, fractional, montecarlo, pickling, plot, stability, study
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
from nfopidn.comparison import Comparison, compare, scenario_suite, tune_contenders
from nfopidn.engines import EngineError
from nfopidn.export import export_c, export_cpp
from nfopidn.families import Family, simulate_many
from nfopidn.montecarlo.result import MonteCarloResult
from nfopidn.montecarlo.runs import monte_carlo
from nfopidn.reporting import report
from nfopidn.robustness import Verdict, verdict
from nfopidn.search.bfoa import bfoa
from nfopidn.search.forager import Forager
from nfopidn.search.optimise import OptimizeResult
from nfopidn.tuning.objective import Objective
from nfopidn.tuning.parameters import default_bounds
from nfopidn.tuning.result import TuneResult
from nfopidn.tuning.tuner import tune

pickling.register()

__all__ = [
    "Comparison",
    "Controller",
    "EngineError",
    "Family",
    "Forager",
    "MonteCarloResult",
    "Objective",
    "OptimizeResult",
    "Rival",
    "Robot",
    "Scenario",
    "SimulationResult",
    "Trajectory",
    "TuneResult",
    "Verdict",
    "__version__",
    "bfoa",
    "compare",
    "default_bounds",
    "export_c",
    "export_cpp",
    "families",
    "fractional",
    "monte_carlo",
    "montecarlo",
    "plot",
    "report",
    "scenario_suite",
    "simulate",
    "simulate_many",
    "stability",
    "study",
    "tune",
    "tune_contenders",
    "verdict",
]
