"""What identification found, and how sure it is."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Motor, Robot, Scenario
from nfopidn.files import replace_file
from nfopidn.identification.models import DRIVES
from nfopidn.identification.residuals import Whiteness
from nfopidn.trajectories import from_states

Array = NDArray[np.float64]

_FORMAT = "nfopidn-identification"


@dataclass(frozen=True)
class IdentificationResult:
    """Parameters of a robot and its drive, from a log.

    Attributes
    ----------
    model
        "torque", "voltage", "velocity" or "odometry".
    parameters
        values by name, `units` has their units; those that were not free or cannot be had are as
        they were given. `delay` is in samples of `dt`.
    units
        by name.
    standard_errors
        by name, of the free parameters: infinite where the log does not tell the parameter. They
        are true as far as the residuals are white.
    names, covariance
        the free parameters that were found, and their covariance (q, q).
    undetermined
        by name, which parameters the log does not tell, and what to drive instead.
    indistinguishable
        groups of parameters of which the log tells combinations alone.
    singular_values
        of the Jacobian by the free parameters, its columns normalised, falling: near zero where
        parameters cannot be told apart.
    delay
        [samples].
    dt
        sample time of the commands [s].
    noise
        standard deviations of the measured position [m] and heading [rad].
    train_error, validation_error
        root mean square of the residuals over `noise`, of position and heading together: in the
        windows that the first fit was made to, and in those that it did not see. The parameters are
        of a last fit to all windows.
    whiteness
        of the residuals, by channel: x, y, theta.
    outliers
        rows of the log that lie beyond six standard deviations.
    t, measured, simulated
        (n,) stamps [s] and (n, 3) poses of the rows in windows.
    window, validation
        (n,) number of the window, and whether it is one of validation.
    notes
        what was made of the log.
    given_robot, motor
        the arguments.
    torque_limit
        the largest torque in the log [N m].
    nodes
        (n, 4) t [s], x, y [m], theta [rad]: the smoothed motion.
    """

    model: str
    parameters: Mapping[str, float]
    units: Mapping[str, str]
    standard_errors: Mapping[str, float]
    names: tuple[str, ...]
    covariance: Array
    undetermined: Mapping[str, str]
    indistinguishable: tuple[tuple[str, ...], ...]
    singular_values: Array
    delay: float
    dt: float
    noise: tuple[float, float]
    train_error: float
    validation_error: float
    whiteness: Mapping[str, Whiteness]
    outliers: NDArray[np.intp]
    t: Array
    measured: Array
    simulated: Array
    window: NDArray[np.intp]
    validation: NDArray[np.bool_]
    notes: tuple[str, ...]
    given_robot: Robot | None = field(repr=False)
    motor: Motor | None = field(repr=False)
    torque_limit: float = field(repr=False)
    nodes: Array = field(repr=False)

    @property
    def robot(self) -> Robot:
        """The robot that was given, with what was found of it; of two radii their mean.

        Raises
        ------
        ValueError
            model="velocity" without a robot.
        """
        if self.given_robot is None:
            raise ValueError("no robot was given, and the model velocity finds none by itself")
        p = self.parameters
        if self.model == "odometry":
            radii = p["wheel_radius_left"], p["wheel_radius_right"]
            return self.given_robot.replace(
                wheel_radius=sum(radii) / 2, track_width=p["track_width"]
            )
        if self.model != "velocity":
            return self.given_robot.replace(mass=p["mass"], inertia=p["inertia"])
        return self.given_robot.replace(
            wheel_radius=self.given_robot.wheel_radius * p["gain"],
            track_width=self.given_robot.track_width * p["gain"] / p["turn_gain"],
        )

    @cached_property
    def scenario(self) -> Scenario:
        """The log's motion as a scenario: robot, friction, delay, noise, torque limit as found.

        Its trajectory is the smoothed motion; scenario.replace(trajectory=...) drives another one.
        The torque limit is the largest torque in the log.

        Raises
        ------
        ValueError
            The models velocity and odometry have no plant, or the smoothed motion is no trajectory.
        """
        if self.model not in DRIVES:
            raise ValueError(f"model={self.model!r} finds no plant, which a Scenario has")
        t, x, y, theta = self.nodes.T
        p = self.parameters
        return Scenario(
            from_states(t, x, y, theta, dt=self.dt),
            self.robot,
            viscous_friction=p["viscous_friction"],
            coulomb_friction=p["coulomb_friction"],
            delay=max(round(self.delay), 0),
            pose_noise=self.noise,
            torque_limit=self.torque_limit,
            motor=self.motor,
            integrator="exact",
            rng=0,
        )

    def __str__(self) -> str:
        width = max(map(len, self.parameters))
        lines = []
        for name, value in self.parameters.items():
            error = self.standard_errors.get(name)
            sure = "as given" if error is None else f"+- {error:.2g}"
            if name == "delay":
                sure = f"of {self.dt:.4g} s"
            if name in self.undetermined:
                sure = "as given; the log does not tell it"
            lines.append(f"{name:{width}}  {value:.6g} {self.units[name]} ({sure})")
        lines.append(
            f"residuals over noise: {self.train_error:.3f} in training, "
            f"{self.validation_error:.3f} in validation; noise {self.noise[0]:.3g} m, "
            f"{self.noise[1]:.3g} rad"
        )
        lines += [f"{name}: {why}" for name, why in self.undetermined.items()]
        lines += [
            f"not told apart: {', '.join(group)}; only combinations of them are found"
            for group in self.indistinguishable
        ]
        coloured = [name for name, test in self.whiteness.items() if not test.white]
        if coloured:
            lines.append(
                f"residuals of {', '.join(coloured)} are not white: the model misses something, or "
                "the log's poses are filtered; the standard errors are too small"
            )
        return "\n".join(lines)

    def to_json(self, path: str | PathLike[str] | None = None) -> str:
        """Return the result as JSON, and write it where a path is given.

        The rows of the log are not in it. Infinite standard errors are null.
        """
        robot = self.given_robot and self.robot
        content: dict[str, Any] = {
            "format": _FORMAT,
            "version": 1,
            "model": self.model,
            "parameters": dict(self.parameters),
            "units": dict(self.units),
            "standard_errors": {
                name: error if np.isfinite(error) else None
                for name, error in self.standard_errors.items()
            },
            "covariance": {"names": list(self.names), "rows": self.covariance.tolist()},
            "undetermined": dict(self.undetermined),
            "indistinguishable": [list(group) for group in self.indistinguishable],
            "singular_values": self.singular_values.tolist(),
            "delay": self.delay,
            "dt": self.dt,
            "noise": {"position": self.noise[0], "heading": self.noise[1]},
            "train_error": self.train_error,
            "validation_error": self.validation_error,
            "whiteness": {
                name: {
                    "correlations": test.correlations.tolist(),
                    "bound": test.bound,
                    "p_value": test.p_value,
                }
                for name, test in self.whiteness.items()
            },
            "outliers": self.outliers.tolist(),
            "torque_limit": self.torque_limit,
            "robot": None
            if robot is None
            else {
                name: getattr(robot, name)
                for name in ("mass", "inertia", "track_width", "wheel_radius")
            },
            "notes": list(self.notes),
        }
        text = json.dumps(content, indent=2, allow_nan=False) + "\n"
        if path is not None:
            replace_file(path, text)
        return text

    def plot(self, axes: Any = None, dark: bool = False) -> Any:
        """Draw measured against simulated, and what is left: nfopidn.plot.identification()."""
        from nfopidn.plot import identification

        return identification(self, axes, dark)
