"""Nonlinear fractional-order PID neural control of differential-drive robots."""

from nfopidn import (
    families,
    formats,
    fractional,
    identification,
    montecarlo,
    mujoco,
    pickling,
    plot,
    stability,
    study,
    trajectories,
)
from nfopidn._core import (
    Controller,
    Motor,
    Rival,
    Robot,
    Scenario,
    SimulationResult,
    Trajectory,
    __version__,
    odometry,
    simulate,
    to_rep103,
)
from nfopidn.comparison import Comparison, compare, scenario_suite, tune_contenders
from nfopidn.engines import EngineError
from nfopidn.export import export_c, export_cpp
from nfopidn.families import Family, simulate_many
from nfopidn.identification.identifier import identify
from nfopidn.identification.result import IdentificationResult
from nfopidn.montecarlo.result import MonteCarloResult
from nfopidn.montecarlo.runs import monte_carlo
from nfopidn.reporting import report
from nfopidn.robustness import Verdict, verdict
from nfopidn.scoring import score
from nfopidn.search.bfoa import bfoa
from nfopidn.search.forager import Forager
from nfopidn.search.optimise import OptimizeResult
from nfopidn.tuning.objective import Objective
from nfopidn.tuning.parameters import default_bounds
from nfopidn.tuning.pareto_result import ParetoResult
from nfopidn.tuning.result import TuneResult
from nfopidn.tuning.tuner import tune

pickling.register()

__all__ = [
    "Comparison",
    "Controller",
    "EngineError",
    "Family",
    "Forager",
    "IdentificationResult",
    "MonteCarloResult",
    "Motor",
    "Objective",
    "OptimizeResult",
    "ParetoResult",
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
    "formats",
    "fractional",
    "identification",
    "identify",
    "monte_carlo",
    "montecarlo",
    "mujoco",
    "odometry",
    "plot",
    "report",
    "scenario_suite",
    "score",
    "simulate",
    "simulate_many",
    "stability",
    "study",
    "to_rep103",
    "trajectories",
    "tune",
    "tune_contenders",
    "verdict",
]
