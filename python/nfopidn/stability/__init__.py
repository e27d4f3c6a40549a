"""Stability of the controller and of its loop on the robot.

============= =====================================================================
`controller`  zeros and poles of the channels' filters in the z-plane
`operator`    the same of a truncated fractional operator
`loop`        orbit, Floquet multipliers and verdict of the closed loop
`margins`     gain, phase, delay and disk margins of the drive and steering loops
`basin`       the initial poses from which a run ends on its path
============= =====================================================================

docs/stability.md explains each. Figures: `nfopidn.plot.z_plane`, `operator_z_plane`,
`multipliers`, `basin`.
"""

from nfopidn.stability.attraction import Basin, basin
from nfopidn.stability.closed_loop import LoopStability, Simulated, Switch, loop
from nfopidn.stability.loop_margins import DiskMargin, LoopMargins, Margins, margins
from nfopidn.stability.pole_map import (
    ControllerStability,
    Place,
    ZPlane,
    controller,
    operator,
)

__all__ = [
    "Basin",
    "ControllerStability",
    "DiskMargin",
    "LoopMargins",
    "LoopStability",
    "Margins",
    "Place",
    "Simulated",
    "Switch",
    "ZPlane",
    "basin",
    "controller",
    "loop",
    "margins",
    "operator",
]
