"""What a robot can do, and how much of it a sampled trajectory asks for."""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import inf

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Robot, Trajectory
from nfopidn.arguments import real_number

_UNITS = {
    "speed": "m/s",
    "acceleration": "m/s^2",
    "deceleration": "m/s^2",
    "lateral_acceleration": "m/s^2",
    "turn_rate": "rad/s",
    "turn_acceleration": "rad/s^2",
    "wheel_speed": "rad/s",
    "wheel_torque": "N m",
    "no_load_speed": "rad/s",
    "coulomb_friction": "N m",
    "viscous_friction": "N m s/rad",
}
_OF_THE_WHEELS = ("wheel_speed", "wheel_torque", "no_load_speed")


@dataclass(frozen=True)
class Limits:
    """The most that a trajectory may ask of a robot; infinity where there is no limit.

    Something must limit the speed (speed, wheel_speed or no_load_speed) and something the
    acceleration (acceleration or wheel_torque): a time-optimal motion has no end of either.

    Attributes
    ----------
    speed
        [m/s], forward and backward.
    acceleration, deceleration
        [m/s^2] along the path, gaining and losing speed; a deceleration of None is the
        acceleration.
    lateral_acceleration
        of v omega [m/s^2], to either side.
    turn_rate, turn_acceleration
        [rad/s], [rad/s^2].
    wheel_speed
        of each wheel [rad/s].
    wheel_torque
        of each wheel [N m], friction included: what friction takes cannot accelerate the robot.
    no_load_speed
        wheel speed [rad/s] at which a motor on full voltage has no torque left. With it
        wheel_torque is the torque at standstill, and what is left falls in a straight line: a DC
        motor's limit of voltage. For a motor of torque_constant k_t, back_emf_constant k_e,
        resistance R and gear N at a voltage V: wheel_torque N k_t V / R, no_load_speed V / (N k_e).
    coulomb_friction, viscous_friction
        at each wheel [N m], [N m s/rad], as of a Scenario.
    """

    speed: float = inf
    acceleration: float = inf
    deceleration: float | None = None
    lateral_acceleration: float = inf
    turn_rate: float = inf
    turn_acceleration: float = inf
    wheel_speed: float = inf
    wheel_torque: float = inf
    no_load_speed: float = inf
    coulomb_friction: float = 0.0
    viscous_friction: float = 0.0

    def __post_init__(self) -> None:
        """Check the ranges.

        Raises
        ------
        ValueError
            Names the limit and its range, or what has no limit at all.
        """
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "deceleration" and value is None:
                value = self.acceleration
            is_friction = field.name.endswith("friction")
            unit = f" {_UNITS[field.name]}"
            least, most = (0.0, 1e6) if is_friction else (1e-6, inf)
            number = real_number(f"limits.{field.name}", value, least, most, unit)
            object.__setattr__(self, field.name, number)
        if min(self.speed, self.wheel_speed, self.no_load_speed) == inf:
            raise ValueError(
                "limits: nothing limits the speed; give speed, wheel_speed or no_load_speed"
            )
        if min(self.acceleration, self.wheel_torque) == inf:
            raise ValueError(
                "limits: nothing limits the acceleration; give acceleration or wheel_torque"
            )
        if self.no_load_speed < inf and self.wheel_torque == inf:
            raise ValueError("limits: no_load_speed needs wheel_torque, the torque at standstill")
        if self.coulomb_friction >= self.wheel_torque:
            raise ValueError(
                f"limits: coulomb_friction is {self.coulomb_friction:g} N m and takes all of "
                f"wheel_torque, {self.wheel_torque:g} N m: the robot cannot move"
            )

    def check_robot(self, robot: Robot | None) -> None:
        """Refuse limits of wheels without a robot.

        Raises
        ------
        ValueError
            Names the limit that needs the robot.
        """
        if robot is not None and not isinstance(robot, Robot):
            raise ValueError(f"robot is {robot!r}; must be a Robot or None")
        for name in _OF_THE_WHEELS:
            if robot is None and getattr(self, name) < inf:
                raise ValueError(f"robot is None; limits.{name} is of a wheel and needs a Robot")

    @property
    def torque_slope(self) -> float:
        """What each rad/s of a wheel takes from its torque [N m s/rad]: back EMF and bearings."""
        back = 0.0 if self.no_load_speed == inf else self.wheel_torque / self.no_load_speed
        return back + self.viscous_friction


@dataclass(frozen=True)
class Use:
    """How much of one limit is used at each sample.

    Attributes
    ----------
    name
        of the limit, that of a wheel with its side.
    value
        what is asked for (N,), in the limit's unit.
    limit
        the most there is (N,).
    power
        2 for speeds, 1 for accelerations and torques: ratio to this power is the factor by which
        the square of the speed along the path is too large.
    """

    name: str
    value: NDArray[np.float64]
    limit: NDArray[np.float64]
    power: int

    @property
    def ratio(self) -> NDArray[np.float64]:
        """Value over limit (N,); infinity where nothing is left and something is asked for."""
        with np.errstate(divide="ignore", invalid="ignore"):
            found = self.value / self.limit
        found[self.value <= 0] = 0.0
        found[(self.limit <= 0) & (self.value > 0)] = inf
        return found


def wheel_rates(
    robot: Robot, v: NDArray[np.float64], omega: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the wheels' speeds or accelerations, those of v and omega (eq. 1), in rad/s."""
    half = 0.5 * robot.track_width * omega
    return (v + half) / robot.wheel_radius, (v - half) / robot.wheel_radius


def wheel_torques(
    robot: Robot, acceleration: NDArray[np.float64], turn_acceleration: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the torques of left and right wheel [N m] that accelerate the robot (eqs. 9, 10)."""
    drive = 0.5 * robot.mass * robot.wheel_radius * acceleration
    steer = robot.inertia * robot.wheel_radius / robot.track_width * turn_acceleration
    return drive + steer, drive - steer


def uses(trajectory: Trajectory, limits: Limits, robot: Robot | None = None) -> list[Use]:
    """Return what a trajectory uses of each limit that is finite, sample by sample.

    The values are those that a controller is given: the trajectory's own v, omega and their
    derivatives, which are differences of its samples.

    Parameters
    ----------
    trajectory
        of N samples.
    limits, robot
        as of from_waypoints().

    Returns
    -------
    list of Use
        name, value (N,), limit (N,) in the limit's unit; `wheel_torque` of both wheels, where the
        limit is what friction and back EMF leave at the wheel's speed.
    """
    limits.check_robot(robot)
    v, omega = trajectory.v, trajectory.omega
    along = np.where(np.signbit(v), -1.0, 1.0) * trajectory.acceleration

    def use(name: str, value: NDArray[np.float64], power: int) -> Use:
        return Use(name, value, np.full(value.shape, getattr(limits, name)), power)

    found = [
        use("speed", np.abs(v), 2),
        use("acceleration", np.maximum(along, 0.0), 1),
        use("deceleration", np.maximum(-along, 0.0), 1),
        use("lateral_acceleration", np.abs(v * omega), 1),
        use("turn_rate", np.abs(omega), 2),
        use("turn_acceleration", np.abs(trajectory.turn_acceleration), 1),
    ]
    if robot is not None:
        speeds = wheel_rates(robot, v, omega)
        torques = wheel_torques(robot, trajectory.acceleration, trajectory.turn_acceleration)
        for side, speed, torque in zip(("left", "right"), speeds, torques, strict=True):
            most = np.full(speed.shape, limits.wheel_speed)
            found.append(Use(f"{side} wheel_speed", np.abs(speed), most, 2))
            if limits.wheel_torque == inf:
                continue
            left = limits.wheel_torque - limits.torque_slope * np.abs(speed)
            left = np.where(speed != 0, left - limits.coulomb_friction, left)
            found.append(Use(f"{side} wheel_torque", np.abs(torque), left, 1))
    return [one for one in found if np.isfinite(one.limit).all()]
