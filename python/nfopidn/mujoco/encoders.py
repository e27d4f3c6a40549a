"""What a robot knows of its pose from its wheels' encoders."""

from __future__ import annotations

import math
from dataclasses import dataclass

from nfopidn import _core
from nfopidn._core import Robot

Pose = tuple[float, float, float]


@dataclass
class Encoders:
    """Odometry from wheel angles, whole counts or exact, with the C++ core's step.

    Attributes
    ----------
    robot
        Whose wheel radius and track the odometry believes in.
    pose
        x, y [m], theta [rad], the last estimate; the heading is not wrapped.
    counts
        Counts a revolution of the wheel; None: angles as they are.
    dt
        Sample time [s].
    """

    robot: Robot
    pose: Pose
    counts: int | None
    dt: float
    before: tuple[float, float] = (0.0, 0.0)
    v: float = 0.0
    omega: float = 0.0

    def start(self, left: float, right: float) -> None:
        """Take the wheels' angles [rad] at the start."""
        self.before = (self._read(left), self._read(right))

    def read(self, left: float, right: float) -> tuple[float, float, float, float, float]:
        """Move the estimate to new wheel angles [rad] of REP-103.

        Returns
        -------
        tuple
            x, y [m], theta [rad], and v [m/s], omega [rad/s] as the mean since the last reading.
        """
        now = (self._read(left), self._read(right))
        radius = self.robot.wheel_radius
        ways = [radius * (new - old) for new, old in zip(now, self.before, strict=True)]
        self.before = now
        turned = (ways[1] - ways[0]) / self.robot.track_width
        x, y, _ = _core.odometry(self.pose, ways[0], ways[1], self.robot.track_width)
        self.pose = (x, y, self.pose[2] + turned)
        self.v = (ways[0] + ways[1]) / (2 * self.dt)
        self.omega = turned / self.dt
        return (*self.pose, self.v, self.omega)

    def _read(self, angle: float) -> float:
        """Give an angle as the encoder shows it."""
        if self.counts is None:
            return angle
        turn = 2 * math.pi
        return math.floor(angle / turn * self.counts) * turn / self.counts
