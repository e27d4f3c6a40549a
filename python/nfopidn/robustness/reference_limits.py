"""What a reference asks of a robot, against what there is."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Scenario


def check_moves(scenario: Scenario) -> None:
    """Refuse a reference that never moves, of which nothing can be said.

    Raises
    ------
    ValueError
        Speed and turn rate are 0 at every sample.
    """
    path = scenario.trajectory
    if not (np.any(path.v) or np.any(path.omega)):
        raise ValueError(
            "the reference never moves: speed and turn rate are 0 at each of its "
            f"{len(path)} samples; a verdict is of a path that is driven"
        )


def _asked_torques(scenario: Scenario) -> NDArray[np.float64]:
    """Give what the motion needs (N, 2) [N m], whether or not all of it is fed forward."""
    return np.abs(scenario.replace(feedforward_limit=None).reference[:, 5:7])


def warn_of_reference_torques(
    callable_name: str, scenarios: Sequence[Scenario], *, above: int = 1
) -> None:
    """Warn of the first scenario that feeds more torque forward than the robot has.

    The warning is of the line that called `callable_name`, so many calls above this one.

    Eq. 41 counts what of it is cut off at the torque limit, whatever the controller does. With
    "forward" heading the torques at a cusp grow with the square of the sampling rate.
    """
    for scenario in scenarios:
        limit = scenario.torque_limit
        torque = np.abs(scenario.reference[:, 5:7]).max(axis=1)
        if not scenario.feedforward or torque.max() <= limit:
            continue
        place = int(np.argmax(torque))
        warnings.warn(
            f"{callable_name}: the reference torques reach {torque[place]:.3g} N m, at "
            f"{scenario.trajectory.t[place]:.4g} s; the torque limit is {limit:g} N m, and the "
            f"cost counts what is beyond it: feedforward_limit={limit:g} feeds forward, and "
            "compares with, what can be driven",
            UserWarning,
            stacklevel=above + 2,
        )
        return


def beyond_the_robot(scenario: Scenario) -> tuple[str, ...]:
    """Tell what the reference asks of the true robot that it does not have, in words.

    A wheel has the torque limit less what friction takes. With viscous friction there is also a
    speed that no torque exceeds.
    """
    path, robot, limit = scenario.trajectory, scenario.robot, scenario.torque_limit
    torque = _asked_torques(scenario)
    turn = 0.5 * robot.track_width * path.omega
    wheels = np.column_stack([path.v + turn, path.v - turn]) / robot.wheel_radius
    found = []
    if scenario.feedforward and torque.max() > limit:
        place = int(np.argmax(torque.max(axis=1)))
        found.append(
            f"the reference torques reach {torque.max():.3g} N m, at {path.t[place]:.4g} s; the "
            f"limit is {limit:g} N m"
        )
    # Scrub takes of one wheel what it gives back at the other.
    moment = scenario.coulomb_scrub * np.sign(path.omega) + scenario.viscous_scrub * path.omega
    scrub = moment * robot.wheel_radius / robot.track_width
    friction = scenario.coulomb_friction * np.sign(wheels) + scenario.viscous_friction * wheels
    friction = np.abs(friction + np.column_stack([scrub, -scrub]))
    if float(friction.max()) > limit:
        place = int(np.argmax(friction.max(axis=1)))
        found.append(
            f"friction takes {friction.max():.3g} N m a wheel where the reference "
            f"moves at {path.v[place]:.3g} m/s and turns at {path.omega[place]:.3g} rad/s; the "
            f"limit is {limit:g} N m"
        )
    return tuple(found)


def told_at_construction(scenario: Scenario) -> tuple[str, ...]:
    """Tell what a new scenario warns of: beyond_the_robot(), but for torques that are cut off.

    Whoever sets a feedforward_limit knows of them.
    """
    limit = scenario.feedforward_limit
    if limit is not None and limit <= scenario.torque_limit:
        return tuple(one for one in beyond_the_robot(scenario) if one.startswith("friction"))
    return beyond_the_robot(scenario)
