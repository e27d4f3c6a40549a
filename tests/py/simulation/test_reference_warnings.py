"""A scenario whose reference asks more than its robot has says so where it is made."""

import warnings

import nfopidn
import pytest
from nfopidn import Robot, Scenario, Trajectory
from nfopidn.trajectories import Limits, from_waypoints

FAST = Trajectory.from_samples([0, 0.1, 1, 3, 5, 7], [0] * 6, 0.2)


def test_torques_beyond_the_limit_are_told():
    with pytest.warns(
        UserWarning, match=r"Scenario: the reference torques reach .* at 0\.4 s; the "
    ):
        made = Scenario(FAST, rng=0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Scenario(FAST, torque_limit=100, rng=0)
        Scenario(FAST, feedforward=False, rng=0)
        Scenario(FAST, feedforward_limit=3.078, rng=0)
        made.replace(delay=1)  # told once
        nfopidn.Scenario.published(rng=0)


def test_speeds_beyond_friction_are_told():
    limits = Limits(speed=1, acceleration=0.1)
    slow = from_waypoints([[0, 0], [9, 0]], limits, 0.1)
    with pytest.warns(UserWarning, match=r"Scenario: friction takes 3\.\d+ N m a wheel where the"):
        Scenario(slow, Robot(), torque_limit=3, viscous_friction=0.25, rng=0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Scenario(slow, Robot(), torque_limit=4, viscous_friction=0.25, rng=0)


def test_scrub_is_friction_of_the_wheels_to_the_warning():
    """On a circle it takes M r / L of the outer wheel; on a line nothing."""
    circle, line = Trajectory.circle(period=60), Trajectory.line()
    limit = 2 * Robot().wheel_radius / Robot().track_width
    given = {"torque_limit": limit + 0.01, "coulomb_friction": 0.02, "rng": 0}
    with pytest.warns(UserWarning, match="Scenario: friction takes"):
        Scenario(circle, coulomb_scrub=2.0, **given)
    with pytest.warns(UserWarning, match="Scenario: friction takes"):
        Scenario(circle, viscous_scrub=2.0 / circle.omega[0], **given)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Scenario(circle, coulomb_scrub=1.9, **given)
        Scenario(line, coulomb_scrub=2.0, **given)


def test_what_is_planned_within_limits_is_not_told():
    limits = Limits(speed=0.8, wheel_torque=1.0, coulomb_friction=0.2)
    path = from_waypoints([[0, 0], [1, 1], [2, 0]], limits, 0.05, Robot())
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Scenario(path, Robot(), torque_limit=1.0, coulomb_friction=0.2, rng=0)
