"""The sampled motion's coefficients, as the programme of the open-loop optimum has them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Robot, Scenario

Array = NDArray[np.float64]

#: Columns of the state: x, y [m], theta [rad], v [m/s], omega [rad/s].
STATES = 5
TURN = 2 * math.pi


def accelerations(robot: Robot) -> tuple[float, float]:
    """Return v' [m/s²] for a sum, omega' [rad/s²] for a difference of 1 N m of torques (eq. 4)."""
    drive = 1 / (robot.mass * robot.wheel_radius)
    turn = robot.track_width / (2 * robot.inertia * robot.wheel_radius)
    return drive, turn


def friction_rates(scenario: Scenario) -> tuple[float, float]:
    """Return the rates [1/s] at which viscous friction and scrub slow v and omega."""
    robot, viscous = scenario.robot, scenario.viscous_friction
    drive = 2 * viscous / (robot.mass * robot.wheel_radius**2)
    turn = viscous * robot.track_width**2 / (2 * robot.inertia * robot.wheel_radius**2)
    return drive, turn + scenario.viscous_scrub / robot.inertia


def disturbances(scenario: Scenario) -> Array:
    """Return accelerations by the disturbance, (N, 2): of v [m/s²], of omega [rad/s²]."""
    rows = np.broadcast_to(np.asarray(scenario.disturbance, dtype=float), (_samples(scenario), 2))
    return rows / (scenario.robot.mass, scenario.robot.inertia)


def start(scenario: Scenario) -> Array:
    """Return the state (5,) in which runs start."""
    first = scenario.reference[0]
    pose = first[:3] if scenario.initial_pose is None else scenario.initial_pose
    velocity = scenario.initial_velocity
    return np.array([*pose, *(first[3:5] if isinstance(velocity, str) else velocity)])


def branches(scenario: Scenario, theta: Array) -> Array:
    """Return what to add to the reference's heading (N,) to be within half a turn of theta."""
    return TURN * np.round((theta - scenario.reference[:, 2]) / TURN)


def _samples(scenario: Scenario) -> int:
    return len(scenario.trajectory)
