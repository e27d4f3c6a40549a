"""Figures of runs, controllers and the system itself.

Each function draws one figure: into the Axes that it is given, or into a new figure. None changes
matplotlib's settings, and matplotlib is loaded when the first figure is asked for, not before.

========================== ========================================================
`path`                     reference and driven path
`orientation`              reference and driven heading
`feedforward_torque`       what the reference's motion needs
`feedback_torque`          what the controller adds
`total_torque`             what the wheels get, and its limit
`wheel_action`             torque, speed and power of each wheel
`velocities`               linear and angular speed, and the reference's
`errors`                   position and heading errors in the robot's frame
`weights`                  weights of the fractional derivative and integral
`z_plane`                  zeros and poles of a channel's filter
`discretisation`           methods for s^alpha: magnitude, phase, error
`operator_z_plane`         the same of a truncated fractional operator
`multipliers`              Floquet multipliers of a loop's orbit
`basin`                    from where a run ends on its path
`robot_schematic`          the robot, its coordinates and torques
`control_system_schematic` the closed loop
`controller_schematic`     the controller
`convergence`              a search: the best cost against evaluations
`pareto_front`             a search over objectives: what none of the others dominates
`hypervolume`              how that front grew
`comparison`               controllers on scenarios: a metric of each
`paths`                    driven paths of several controllers
`distances`                how far they are from the reference
`variation_costs`          what each variation costs several controllers
`path_bundle`              the paths driven on every scenario of a family
`margin_bars`              gain, phase and delay margin, with their thresholds
`cost_histogram`           costs of many runs, with a limit
`tornado`                  which parameter drives them
`failures`                 where in the parameters' space runs fail
`quantile_bands`           between which errors shares of the runs lie along the path
`identification`           measured against simulated motion of a log, and what is left
`overview`                 a run on one page
========================== ========================================================
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from nfopidn.plot.comparisons import comparison, distances, paths
    from nfopidn.plot.filters import weights, z_plane
    from nfopidn.plot.identification import identification
    from nfopidn.plot.montecarlo import cost_histogram, failures, quantile_bands, tornado
    from nfopidn.plot.operators import discretisation
    from nfopidn.plot.page import overview
    from nfopidn.plot.pareto import hypervolume, pareto_front
    from nfopidn.plot.robustness import margin_bars, path_bundle, variation_costs
    from nfopidn.plot.runs import (
        errors,
        feedback_torque,
        feedforward_torque,
        orientation,
        path,
        total_torque,
        velocities,
        wheel_action,
    )
    from nfopidn.plot.schematics import (
        control_system_schematic,
        controller_schematic,
        robot_schematic,
    )
    from nfopidn.plot.searches import convergence
    from nfopidn.plot.stability import basin, multipliers, operator_z_plane

__all__ = [
    "basin",
    "comparison",
    "control_system_schematic",
    "controller_schematic",
    "convergence",
    "cost_histogram",
    "discretisation",
    "distances",
    "errors",
    "failures",
    "feedback_torque",
    "feedforward_torque",
    "hypervolume",
    "identification",
    "margin_bars",
    "multipliers",
    "operator_z_plane",
    "orientation",
    "overview",
    "pareto_front",
    "path",
    "path_bundle",
    "paths",
    "quantile_bands",
    "robot_schematic",
    "tornado",
    "total_torque",
    "variation_costs",
    "velocities",
    "weights",
    "wheel_action",
    "z_plane",
]

_MODULES = (
    "runs",
    "filters",
    "operators",
    "schematics",
    "searches",
    "page",
    "stability",
    "comparisons",
    "robustness",
    "montecarlo",
    "pareto",
    "identification",
)


# The modules import matplotlib, which takes longer than most simulations: only a figure needs it.
def __getattr__(name: str) -> Any:
    if name in __all__:
        for module_name in _MODULES:
            module = import_module(f"{__name__}.{module_name}")
            if hasattr(module, name):
                globals()[name] = getattr(module, name)
                return globals()[name]
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
