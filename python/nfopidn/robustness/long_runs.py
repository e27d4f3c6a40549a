"""Runs long enough to tell whether a controller stays on its path."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Controller, Rival, Scenario
from nfopidn.stability.closed_loop import repeated

AnyController = Controller | Rival
Array = NDArray[np.float64]

#: A path that closes is driven for at least as many laps, and samples, at most so many samples.
_LAPS, _SAMPLES, _MOST_SAMPLES = 3, 2000, 100_000
#: How far from the path a run may be that stays on it, as a part of the path's size, and as a
#: multiple of how far the undisturbed run is.
_NEAR, _LIKE_NOMINAL = 0.05, 10.0
#: For the long simulation: samples, the sideways step that must decay as a part of the path's
#: size, and what may be left of it.
_STABLE_SAMPLES, _NUDGE, _LEFT = 10_000, 0.01, 0.1


def path_size(scenario: Scenario) -> float:
    """Give the diagonal of the box around the path [m]."""
    path = scenario.trajectory
    return float(np.hypot(np.ptp(path.x), np.ptp(path.y)))


def lengthened(scenario: Scenario, samples: int = _SAMPLES) -> tuple[Scenario, bool]:
    """Give the scenario with laps enough, and whether its path closes: else it stays as it is."""
    path = scenario.trajectory
    lap = (len(path) - 1) // path.laps
    laps = max(_LAPS, -(-samples // lap))
    laps = max(min(laps, _MOST_SAMPLES // lap), path.laps)
    if not isinstance(scenario.disturbance, tuple):
        return scenario, False
    if path.name == "samples" and path.theta[0] != path.theta[-1] and laps > 1:
        turn = (path.theta[-1] - path.theta[0]) / (2 * np.pi)
        if abs(turn - round(turn)) > 0.1:
            return scenario, False  # the ends meet at an angle
    try:
        longer = repeated(path, laps)
    except ValueError:
        return scenario, False
    if np.hypot(path.x[0] - path.x[-1], path.y[0] - path.y[-1]) > 1e-6 * (1 + path_size(scenario)):
        return scenario, False  # a named path that is open, which starts again at its start
    return scenario.replace(trajectory=longer), True


def distances(scenario: Scenario, controller: AnyController) -> Array | None:
    """Give the robot's distance from its reference at each sample [m]; None if the run diverges."""
    run = _core.simulate(scenario, controller)
    if run.diverged_at is not None:
        return None
    return np.asarray(np.hypot(run.columns["e_x"], run.columns["e_y"]))


def _late(far: Array) -> float:
    """Give the root mean square of a run's second half."""
    return float(np.sqrt(np.mean(far[len(far) // 2 :] ** 2)))


class OnPath:
    """Whether runs of a scenario's variations stay on the path.

    One does that does not diverge, and whose second half is, in the root mean square, within 5 % of
    the path's size or ten times what the scenario itself leaves, whichever is more.
    """

    def __init__(self, scenario: Scenario, controller: AnyController) -> None:
        """Measure the scenario itself."""
        self.scenario, self.closed = lengthened(scenario)
        self.controller = controller
        far = distances(self.scenario, controller)
        size = path_size(scenario)
        #: [m]; infinite if the scenario's own run diverges
        self.nominal = float("inf") if far is None else _late(far)
        self.stays_nominal = self.nominal <= _NEAR * size
        near = _LIKE_NOMINAL * self.nominal if self.stays_nominal else 0.0
        self.limit = max(_NEAR * size, near)

    def stays(self, scenario: Scenario) -> bool:
        """Whether the controller stays on the path in a variation of the (lengthened) scenario."""
        far = distances(scenario, self.controller)
        return far is not None and _late(far) <= self.limit

    def shortfall(self, scenario: Scenario) -> float:
        """Give how far a run that does not stay on the path is from it, in (0, 1].

        Under a half, by how much it is off; from there on it diverges, the later the less.
        """
        run = _core.simulate(scenario, self.controller)
        if run.diverged_at is not None:
            path = scenario.trajectory
            return 1.0 - 0.5 * run.diverged_at / (len(path) * path.dt)
        off = _late(np.hypot(run.columns["e_x"], run.columns["e_y"])) / self.limit
        return 0.5 * max(off - 1.0, 0.0) / off


def largest(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Give how far from `low`, where it holds, towards `high` a condition holds: by bisection.

    Sixteen halvings, to a hundred-thousandth of the interval; `high` if it holds there, `low` if
    it never does. (SciPy's bisect gives the last place it tried, whether or not the condition holds
    there, and rounds its places in another way, which turns runs that are about to leave.)
    """
    if holds(high):
        return high
    for _ in range(16):
        middle = 0.5 * (low + high)
        if holds(middle):
            low = middle
        else:
            high = middle
    return low


@dataclass(frozen=True)
class LongRun:
    """What a long simulation says of stability.

    Attributes
    ----------
    stable
        whether the run stays on its path, and a step to the side decays
    duration
        simulated [s]
    text
        in words
    """

    stable: bool
    duration: float
    text: str


def long_run(scenario: Scenario, controller: AnyController) -> LongRun:
    """Simulate for long, without noise, from the scenario's start and from a step to the side."""
    quiet = scenario.replace(pose_noise=(0, 0))
    longer, closed = lengthened(quiet, _STABLE_SAMPLES)
    path = longer.trajectory
    duration = float(path.t[-1])
    start = longer.initial_pose or (path.x[0], path.y[0], path.theta[0])
    step = _NUDGE * path_size(scenario)
    side = (
        float(start[0] - step * np.sin(start[2])),
        float(start[1] + step * np.cos(start[2])),
        float(start[2]),
    )
    runs = [_core.simulate(one, controller) for one in (longer, longer.replace(initial_pose=side))]
    how = f"simulated for {duration:.5g} s" + ("" if closed else ", the whole of its open path")
    for run in runs:
        if run.diverged_at is not None:
            return LongRun(False, duration, f"{how}: diverges at {run.diverged_at:.5g} s")
    end = slice(-max(len(scenario.trajectory) // scenario.trajectory.laps, 2), None)
    poses = [run.pose[end, :2] for run in runs]
    left = float(np.max(np.hypot(*(poses[0] - poses[1]).T))) / step
    off = float(np.max(np.hypot(runs[0].columns["e_x"][end], runs[0].columns["e_y"][end])))
    if closed and off > max(2 * _NEAR * path_size(scenario), 1e-3):
        return LongRun(False, duration, f"{how}: ends {off:.3g} m off its path")
    if closed and left > _LEFT:
        return LongRun(False, duration, f"{how}: of a step to the side {left:.2g} is left")
    return LongRun(True, duration, f"{how}: of a step to the side {left:.2g} is left")
