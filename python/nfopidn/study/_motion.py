"""The sampled motion under given torques: what the simulation does, without a controller."""

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
    """Return the rates [1/s] at which viscous friction slows v and omega."""
    robot, viscous = scenario.robot, scenario.viscous_friction
    drive = 2 * viscous / (robot.mass * robot.wheel_radius**2)
    turn = viscous * robot.track_width**2 / (2 * robot.inertia * robot.wheel_radius**2)
    return drive, turn


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


def replay(scenario: Scenario, torque: Array) -> Array:
    """Return the states (N, 5) at the samples, under torques (N, 2) [N m], left and right.

    Semi-implicit Euler in `scenario.substeps` steps a sample, viscous friction implicit.
    """
    step = scenario.trajectory.dt / scenario.substeps
    by_sum, by_difference = accelerations(scenario.robot)
    drive, turn = (1 + step * rate for rate in friction_rates(scenario))
    pushes = disturbances(scenario)
    states = np.empty((len(torque), STATES))
    x, y, theta, v, omega = start(scenario).tolist()
    for k, (left, right) in enumerate(torque.tolist()):
        states[k] = x, y, theta, v, omega
        v_rate = by_sum * (left + right) + pushes[k, 0]
        omega_rate = by_difference * (left - right) + pushes[k, 1]
        for _ in range(scenario.substeps):
            v = (v + step * v_rate) / drive
            omega = (omega + step * omega_rate) / turn
            x += step * v * math.cos(theta)
            y += step * v * math.sin(theta)
            theta += step * omega
    return states


def branches(scenario: Scenario, theta: Array) -> Array:
    """Return what to add to the reference's heading (N,) to be within half a turn of theta."""
    return TURN * np.round((theta - scenario.reference[:, 2]) / TURN)


def cost(scenario: Scenario, states: Array, torque: Array) -> float:
    """Return eq. 41 of states (N, 5) and torques (N, 2)."""
    reference = scenario.reference
    pose = reference[:, :3] - states[:, :3]
    pose[:, 2] += branches(scenario, states[:, 2])
    return float((np.sum(pose**2) + np.sum((reference[:, 5:7] - torque) ** 2)) / len(torque))


def columns(scenario: Scenario, states: Array, torque: Array) -> dict[str, Array]:
    """Return the columns of a run table; tau_fb is the deviation from the reference torques."""
    count = len(torque)
    reference = scenario.reference[:count]
    x, y, theta, v, omega = states.T
    ahead, aside = reference[:, 0] - x, reference[:, 1] - y
    wrapped = np.mod(reference[:, 2] - theta + np.pi, TURN) - np.pi
    tau_ref, deviation = reference[:, 5:7], torque - reference[:, 5:7]
    table = {"t": np.asarray(scenario.trajectory.t)[:count]}
    table |= dict(zip(("x_ref", "y_ref", "theta_ref"), reference[:, :3].T, strict=True))
    table |= {"x": x, "y": y, "theta": theta, "v": v, "omega": omega}
    table |= {
        "e_x": np.cos(theta) * ahead + np.sin(theta) * aside,
        "e_y": np.cos(theta) * aside - np.sin(theta) * ahead,
        "e_theta": wrapped,
    }
    for name, pair in (("tau_ref", tau_ref), ("tau_fb", deviation), ("tau", torque)):
        table |= {f"{name}_left": pair[:, 0], f"{name}_right": pair[:, 1]}
    return {name: np.array(column) for name, column in table.items()}


def _samples(scenario: Scenario) -> int:
    return len(scenario.trajectory)
