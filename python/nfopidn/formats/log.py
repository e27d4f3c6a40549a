"""What a file holds of a motion, and what was made of the file."""

from __future__ import annotations

import importlib
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import SimulationResult, Trajectory
from nfopidn.trajectories import from_states

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Log:
    """States or waypoints that were read from a file, N of them.

    Attributes
    ----------
    x, y
        (N,) [m].
    t
        (N,) [s] since `start`, or None where the file has no times.
    theta
        (N,) [rad], counter-clockwise from the x axis, or None.
    v, omega
        (N,) along the heading [m/s], [rad/s], or None.
    start
        stamp [s] of the first state in the file.
    reverse
        (N,) whether the robot drives backwards on from here, or None.
    source
        file and topic.
    notes
        what was made of each column, field or topic, and what of it is worth knowing.
    """

    x: Array
    y: Array
    t: Array | None = None
    theta: Array | None = None
    v: Array | None = None
    omega: Array | None = None
    start: float = 0.0
    reverse: NDArray[np.bool_] | None = None
    source: str = ""
    notes: tuple[str, ...] = field(default=())

    def __len__(self) -> int:
        """Return the number of states."""
        return len(self.x)

    @property
    def points(self) -> Array:
        """Positions x, y (N, 2) [m], as Trajectory.from_waypoints() takes them."""
        return np.column_stack([self.x, self.y])

    def trajectory(
        self,
        dt: float | None = None,
        speed_limit: float | None = None,
        standstill_speed: float | None = None,
    ) -> Trajectory:
        """Return the trajectory of these states: Trajectory.from_states(), which has the arguments.

        Raises
        ------
        ValueError
            The file has no times, or what from_states() refuses.
        """
        if self.t is None:
            raise ValueError(
                f"{self.source}: no times; Trajectory.from_waypoints(log.points, limits, dt) makes "
                "a trajectory of positions alone"
            )
        try:
            made = from_states(
                self.t,
                self.x,
                self.y,
                self.theta,
                self.v,
                self.omega,
                dt,
                speed_limit,
                standstill_speed,
            )
        except ValueError as error:
            raise ValueError(f"{self.source}: {error}") from None
        from nfopidn import _core

        return _core.annotate(made, [*self.notes, *made.notes])

    def noted(self, *lines: str) -> Log:
        """Return the log with more notes."""
        return replace(self, notes=(*self.notes, *lines))


def extra(module: str, what: str) -> Any:
    """Import a package of the extra `formats`.

    Raises
    ------
    ImportError
        Says how to install it.
    """
    try:
        return importlib.import_module(module)
    except ImportError:
        package = module.partition(".")[0]
        words = f"{what} needs {package}: pip install 'nfopidn[formats]'"
        raise ImportError(words) from None


@dataclass(frozen=True)
class Poses:
    """What a writer writes: stamps [s], poses and speeds, in the frame that positions came in."""

    t: Array
    x: Array
    y: Array
    theta: Array
    v: Array
    omega: Array
    acceleration: Array


def poses_of(source: Trajectory | SimulationResult, reference: bool = False) -> Poses:
    """Return the poses of a trajectory, of a run, or of a run's reference.

    What was taken off the positions (Trajectory.origin) is added again.

    Raises
    ------
    ValueError
        Neither a trajectory nor a run.
    """
    if isinstance(source, SimulationResult):
        trajectory = source.scenario.trajectory
        if not reference:
            c = source.columns
            x, y, theta, v, omega, t = (c[name] for name in ("x", "y", "theta", "v", "omega", "t"))
            rate = np.gradient(v, t) if len(t) > 1 else np.zeros(len(t))
            east, north = trajectory.origin
            return Poses(t, x + east, y + north, theta, v, omega, rate)
        count = len(source.columns["t"])  # a run that diverged ends early
    elif isinstance(source, Trajectory):
        trajectory, count = source, len(source)
    else:
        raise ValueError(f"source is {source!r}; must be a Trajectory or a SimulationResult")
    east, north = trajectory.origin
    return Poses(
        trajectory.t[:count],
        trajectory.x[:count] + east,
        trajectory.y[:count] + north,
        trajectory.theta[:count],
        trajectory.v[:count],
        trajectory.omega[:count],
        trajectory.acceleration[:count],
    )
