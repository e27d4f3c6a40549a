"""The models: their parameters, and the runs that they predict.

Torques and voltages are replayed through the product's own plant with the exact integrator; the
motors' back EMF and rotors are friction, mass and inertia of that plant, as in motor.hpp.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Motor, Robot, Scenario, Trajectory

Array = NDArray[np.float64]

_TINY = 1e-9


@dataclass(frozen=True)
class Parameter:
    """A parameter that can be identified.

    Attributes
    ----------
    unit
        of its value.
    low
        least value; one that is positive is of a parameter that only its logarithm moves.
    drive
        what a log must hold for it.
    """

    unit: str
    low: float
    drive: str


PARAMETERS: Mapping[str, Mapping[str, Parameter]] = {
    "torque": {
        "mass": Parameter("kg", _TINY, "speed up and brake on straight lines"),
        "inertia": Parameter("kg m^2", _TINY, "change the turn rate, left and right, to and fro"),
        "coulomb_friction": Parameter("N m", 0.0, "drive slowly and fast, and stop and go"),
        "viscous_friction": Parameter("N m s/rad", 0.0, "hold several speeds, low and high"),
        "torque_scale": Parameter("", _TINY, "weigh the robot: no log of motion tells it"),
    },
    "velocity": {
        "gain": Parameter("", _TINY, "hold several forward speeds"),
        "turn_gain": Parameter("", _TINY, "hold several turn rates, left and right"),
        "lag": Parameter("s", _TINY, "change the commanded speeds in steps"),
    },
    "odometry": {
        "wheel_radius_left": Parameter("m", _TINY, "drive several metres"),
        "wheel_radius_right": Parameter("m", _TINY, "drive several metres"),
        "track_width": Parameter("m", _TINY, "turn, both ways"),
    },
}
PARAMETERS = {**PARAMETERS, "voltage": PARAMETERS["torque"]}
#: Models whose commands drive the plant.
DRIVES = ("torque", "voltage")
#: Those that are identified where `free` does not say.
FREE: Mapping[str, tuple[str, ...]] = {
    "torque": ("mass", "inertia", "coulomb_friction", "viscous_friction"),
    "voltage": ("mass", "inertia", "coulomb_friction", "viscous_friction"),
    "velocity": ("gain", "turn_gain", "lag"),
    "odometry": ("wheel_radius_left", "wheel_radius_right", "track_width"),
}


class DriveModel:
    """Torques or voltages at the wheels.

    Parameters
    ----------
    dt
        length of a cell [s].
    robot
        track_width and wheel_radius, which stay.
    motor
        of the model "voltage": its inputs are volts. Mass, inertia and friction are then without
        what the motors add.
    names
        of the free parameters.
    fixed
        values of all parameters; those of the free ones are not looked at.
    """

    def __init__(
        self,
        dt: float,
        robot: Robot,
        motor: Motor | None,
        names: tuple[str, ...],
        fixed: Mapping[str, float],
    ) -> None:
        self._dt, self._robot, self._motor = dt, robot, motor
        self._names, self._fixed = names, dict(fixed)
        self._bases: dict[int, Scenario] = {}

    def torque(self, command: Array) -> Array:
        """Return torques at a wheel that stands [N m]."""
        motor = self._motor
        if motor is None:
            return command
        applied = np.clip(command, -motor.supply_voltage, motor.supply_voltage)
        left: Array = applied - np.clip(applied, -motor.dead_band, motor.dead_band)
        return left * (motor.gear_ratio * motor.torque_constant / motor.resistance)

    def added(self) -> dict[str, float]:
        """Return what the motors add to each parameter."""
        motor, robot = self._motor, self._robot
        if motor is None:
            return dict.fromkeys(FREE["torque"], 0.0)
        ratio = motor.gear_ratio
        at_rim = ratio**2 * motor.rotor_inertia / robot.wheel_radius**2
        emf = ratio**2 * motor.torque_constant * motor.back_emf_constant / motor.resistance
        return {
            "mass": 2 * at_rim,
            "inertia": at_rim * robot.track_width**2 / 2,
            "coulomb_friction": motor.coulomb_friction,
            "viscous_friction": emf + motor.viscous_friction,
        }

    def scenario(self, samples: int) -> Scenario:
        """Return a scenario of so many samples whose torques are given."""
        if samples not in self._bases:
            line = np.linspace(0, 1, samples)
            still = np.zeros(samples)
            self._bases[samples] = Scenario(
                Trajectory.from_samples(line, still, self._dt, theta=still),
                self._robot,
                initial_pose=(0, 0, 0),
                torque_limit=1e6,
                integrator="exact",
                divergence_distance=1e6,
                rng=0,
            )
        return self._bases[samples]

    def __call__(self, values: Array, cells: Array, speed: Array) -> Array:
        """Return the states at the nodes: a Simulator of output_error.py."""
        given = {**self._fixed, **dict(zip(self._names, values.tolist(), strict=True))}
        plus = self.added()
        scenario = self.scenario(len(cells) + 1).replace(
            robot=self._robot.replace(
                mass=given["mass"] + plus["mass"], inertia=given["inertia"] + plus["inertia"]
            ),
            coulomb_friction=given["coulomb_friction"] + plus["coulomb_friction"],
            viscous_friction=given["viscous_friction"] + plus["viscous_friction"],
            initial_velocity=tuple(speed.tolist()),
        )
        torque = np.vstack([self.torque(cells) * given["torque_scale"], np.zeros((1, 2))])
        columns = _core.play(scenario, torque).columns
        return np.column_stack([columns[name] for name in ("x", "y", "theta", "v", "omega")])


class VelocityModel:
    """Speeds that follow their commands by a gain and a lag of first order."""

    def __init__(self, dt: float, names: tuple[str, ...], fixed: Mapping[str, float]) -> None:
        self._dt, self._names, self._fixed = dt, names, dict(fixed)

    def __call__(self, values: Array, cells: Array, speed: Array) -> Array:
        """Return the states at the nodes: a Simulator of output_error.py."""
        given = {**self._fixed, **dict(zip(self._names, values.tolist(), strict=True))}
        goal = cells * np.array([given["gain"], given["turn_gain"]])
        lag, dt = given["lag"], self._dt
        keep = np.exp(-dt / lag)
        speeds = np.empty((len(cells) + 1, 2))
        speeds[0] = speed
        for k in range(len(cells)):
            speeds[k + 1] = goal[k] + (speeds[k] - goal[k]) * keep
        # Simpson's rule over each cell, of speeds that are exponentials.
        away = speeds[:-1] - goal
        turned = goal[:, 1] * dt + away[:, 1] * lag * (1 - keep)
        theta = np.concatenate([[0.0], np.cumsum(turned)])
        half = np.exp(-0.5 * dt / lag)
        middle = goal + away * half
        heading = theta[:-1] + goal[:, 1] * dt / 2 + away[:, 1] * lag * (1 - half)
        position = []
        for part in (np.cos, np.sin):
            ends = speeds[:, 0] * part(theta)
            mean = (ends[:-1] + 4 * middle[:, 0] * part(heading) + ends[1:]) / 6
            position.append(np.concatenate([[0.0], np.cumsum(mean * dt)]))
        return np.column_stack([*position, theta, speeds])


class OdometryModel:
    """Wheels that roll: their turning rates [rad/s], in the paper's sign, give the motion.

    Parameters
    ----------
    mirrored
        whether the pair's first is the wheel that the parameters call the right one.
    """

    def __init__(
        self, dt: float, names: tuple[str, ...], fixed: Mapping[str, float], mirrored: bool
    ) -> None:
        self._dt, self._names, self._fixed = dt, names, dict(fixed)
        sides = ("right", "left") if mirrored else ("left", "right")
        self._radii = [f"wheel_radius_{side}" for side in sides]

    def __call__(self, values: Array, cells: Array, speed: Array) -> Array:
        """Return the states at the nodes, whatever `speed` is: a Simulator of output_error.py."""
        given = {**self._fixed, **dict(zip(self._names, values.tolist(), strict=True))}
        rims = cells * np.array([given[name] for name in self._radii])
        v = rims.mean(axis=1)
        omega = (rims[:, 0] - rims[:, 1]) / given["track_width"]
        turned = omega * self._dt
        theta = np.concatenate([[0.0], np.cumsum(turned)])
        middle = theta[:-1] + 0.5 * turned
        chord = v * self._dt * np.sinc(0.5 * turned / np.pi)
        position = [
            np.concatenate([[0.0], np.cumsum(chord * part(middle))]) for part in (np.cos, np.sin)
        ]
        speeds = np.column_stack([v, omega])
        nodes = np.vstack([speeds[:1], 0.5 * (speeds[1:] + speeds[:-1]), speeds[-1:]])
        return np.column_stack([*position, theta, nodes])
