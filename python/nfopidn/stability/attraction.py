"""The basin of attraction: from where a run ends on its path."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn import _core
from nfopidn._core import Controller, Scenario
from nfopidn.arguments import (
    controller_or_published,
    is_number,
    real_number,
    real_numbers,
    scenario_or_published,
    shown,
)
from nfopidn.engines import Engine, Work, read_workers

Array = NDArray[np.float64]

_FIRST_BLOCK = 16  # poses of an engine's first blocks


@dataclass(frozen=True)
class Basin:
    """Which initial poses end on the path.

    Attributes
    ----------
    x, y
        (nx,), (ny,): initial positions [m]
    theta
        initial heading [rad]
    position_error, heading_error
        (ny, nx): root mean squares over the last samples [m], [rad]; infinite where the run
        diverges
    converged
        (ny, nx) bool: both errors within their tolerances
    tolerance
        [m]
    heading_tolerance
        [rad], or None: any
    scenario
        whose path and divergence distance hold
    """

    x: Array
    y: Array
    theta: float
    position_error: Array
    heading_error: Array
    converged: NDArray[np.bool_]
    tolerance: float
    heading_tolerance: float | None
    scenario: Scenario

    @property
    def share(self) -> float:
        """Of the grid's poses that converge, [0, 1]."""
        return float(np.mean(self.converged))

    def __str__(self) -> str:
        diverged = np.mean(np.isinf(self.position_error))
        return (
            f"{self.share:.1%} of {self.converged.size} poses end within {self.tolerance:g} m of "
            f"the path, {diverged:.1%} diverge"
        )


def _axis(name: str, given: ArrayLike | None, centre: float) -> Array:
    if given is None:
        return np.linspace(centre - 3, centre + 3, 100)
    try:
        axis = np.atleast_1d(real_numbers(name, given))
    except ValueError:
        raise ValueError(f"{name} is {shown(given)}; must be numbers [m]") from None
    if axis.ndim != 1 or axis.size == 0:
        raise ValueError(f"{name} has shape {axis.shape}; must be one-dimensional, not empty")
    if not np.all(np.abs(axis) <= 1e6):
        worst = axis[~(np.abs(axis) <= 1e6)][0]
        raise ValueError(f"{name} has {worst}; must be in [-1e+06, 1e+06] m")
    return axis


def _check(name: str, value: Any, low: float, high: float, unit: str) -> None:
    if not is_number(value) or not low < float(value) <= high:
        text = value if isinstance(value, str) else shown(value)
        raise ValueError(f"{name} is {text}; must be in ({low:g}, {high:g}] {unit}")


@dataclass(frozen=True)
class _FinalErrors:
    """What an engine's workers are given."""

    scenario: Scenario
    controller: Controller
    samples: int

    def __call__(self, poses: Array, threads: int = 1) -> Array:
        """Give the errors of poses (n, 3) over the last samples: (n, 2)."""
        return _core.final_errors(self.scenario, self.controller, poses, self.samples, threads)


def _on_engine(final: _FinalErrors, poses: Array, engine: Engine) -> Array:
    errors = np.empty((len(poses), 2))
    with engine, Work(engine, final, "scenario", "poses", first=_FIRST_BLOCK) as work:
        for block in work.blocks(len(poses), lambda first, size: poses[first : first + size]):
            errors[block.first : block.first + block.size] = block.answer
    return errors


def basin(
    scenario: Scenario | None = None,
    controller: Controller | None = None,
    *,
    x: ArrayLike | None = None,
    y: ArrayLike | None = None,
    theta: float | None = None,
    tolerance: float = 0.3,
    heading_tolerance: float | None = None,
    last: float = 10.0,
    workers: Any = None,
) -> Basin:
    """Simulate the scenario from a grid of initial poses, and see which end on the path.

    Parameters
    ----------
    scenario
        None: the published one. Its own initial pose is not used but for the heading.
    controller
        None: the published one
    x, y
        (nx,), (ny,): initial positions [m]; None: 100 each, up to 3 m either side of the path's
        start
    theta
        initial heading [rad]; None: that of the scenario's initial pose
    tolerance
        root mean square of the position error over the run's last samples [m], (0, 1e6]
    heading_tolerance
        the same of the heading error [rad], (0, 1e6]; None: any heading
    last
        how long the last samples are [s], (0, the scenario's duration]
    workers
        threads; None or -1: one a processor; or an Executor as of concurrent.futures, a
        dask.distributed.Client or a function like map, whose workers take poses. The result is the
        same with each.

    Returns
    -------
    Basin
        the errors and which poses converge; `nfopidn.plot.basin` draws it

    Raises
    ------
    ValueError
        If an argument is out of range.
    EngineError
        The workers keep dying, or were closed meanwhile.

    Examples
    --------
    >>> import nfopidn
    >>> axis = [-0.5, 0.0, 0.5]
    >>> found = nfopidn.stability.basin(x=[2.5, 3.0, 3.5], y=axis, theta=0.0)
    >>> found.converged.shape
    (3, 3)
    """
    scenario = scenario_or_published(scenario)
    controller = controller_or_published(controller, scenario)
    path = scenario.trajectory
    start = scenario.initial_pose or (path.x[0], path.y[0], path.theta[0])
    x_axis, y_axis = _axis("x", x, float(path.x[0])), _axis("y", y, float(path.y[0]))
    heading = real_number("theta", float(start[2]) if theta is None else theta, -1e6, 1e6, " rad")
    _check("tolerance", tolerance, 0, 1e6, "m")
    if heading_tolerance is not None:
        _check("heading_tolerance", heading_tolerance, 0, 1e6, "rad")
    _check("last", last, 0, float(path.t[-1]), "s")
    crew = read_workers(-1 if workers is None else workers)

    columns, rows = np.meshgrid(x_axis, y_axis)
    poses = np.column_stack([columns.ravel(), rows.ravel(), np.full(columns.size, heading)])
    samples = max(1, round(last / path.dt))
    final = _FinalErrors(scenario, controller, samples)
    errors = final(poses, crew) if isinstance(crew, int) else _on_engine(final, poses, crew)
    position, turn = (errors[:, i].reshape(columns.shape) for i in (0, 1))
    converged = position <= tolerance
    if heading_tolerance is not None:
        converged &= turn <= heading_tolerance
    return Basin(
        x=x_axis,
        y=y_axis,
        theta=heading,
        position_error=position,
        heading_error=turn,
        converged=converged,
        tolerance=tolerance,
        heading_tolerance=heading_tolerance,
        scenario=scenario,
    )
