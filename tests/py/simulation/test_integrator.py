"""The accurate integrator against an independent solution of the differential equations."""

import nfopidn
import numpy as np
import pytest
from independent_motion import STICKS, Motion
from nfopidn import Controller, Robot, Scenario, Trajectory

IDLE = Controller.published(gains=np.zeros((3, 3)))
CIRCLE = Trajectory.circle(period=30)
STATE = ["x", "y", "theta", "v", "omega"]


def wind(samples, scale, seed):
    return np.random.default_rng(seed).normal(size=(samples, 2)) * scale


def drifting(samples, scale, seed):
    """A disturbance that wanders through the friction's limits."""
    return np.cumsum(wind(samples, scale, seed), axis=0)


def coasting(velocity, **changes):
    """No torque at all: the robot is left to its speed, disturbance and friction."""
    settings = {"initial_velocity": velocity, "feedforward": False, "divergence_distance": 1e3}
    return Scenario(CIRCLE, **(settings | changes), integrator="exact")


def largest_error(scenario, controller, samples):
    """Between the recorded run and the independent solution, restarted at each sample."""
    result = nfopidn.simulate(scenario, controller)
    states = np.column_stack([result.columns[name] for name in STATE])
    outside = np.broadcast_to(scenario.disturbance, (len(scenario.trajectory), 2))
    motion = Motion(scenario)
    errors, modes = [], set()
    for k in range(min(samples, len(states) - 1)):
        state, passed = motion.advance(
            states[k], result.torque[k], outside[k], scenario.trajectory.dt
        )
        errors.append(np.abs(state - states[k + 1]).max())
        modes.update(passed)
    assert len(errors) > 20
    return max(errors), modes


FRICTIONLESS = {
    "published": {},
    "viscous": {"viscous_friction": 0.02},
    "stiff": {"viscous_friction": 5.0},
    "constant disturbance": {"disturbance": (3.0, 0.5)},
    "disturbance by sample": {"disturbance": wind(751, 3, 0), "viscous_friction": 0.1},
    "substeps": {"disturbance": wind(751, 3, 0), "viscous_friction": 0.1, "substeps": 3},
    "other robot": {"robot": Robot(2.0, 0.01, 0.2, 0.03), "torque_limit": 0.3},
}


@pytest.mark.parametrize("changes", FRICTIONLESS.values(), ids=FRICTIONLESS.keys())
def test_without_coulomb_friction(changes):
    scenario = Scenario.published(integrator="exact", **changes)
    error, _ = largest_error(scenario, Controller.published(), 40)
    assert error < 1e-10


def test_spinning_fast():
    scenario = coasting((5.0, 120.0), divergence_distance=1e5)
    error, _ = largest_error(scenario, IDLE, 25)
    assert error < 1e-10


def test_sliding():
    scenario = Scenario(
        CIRCLE,
        integrator="exact",
        initial_velocity="reference",
        coulomb_friction=0.1,
        viscous_friction=0.01,
    )
    error, modes = largest_error(scenario, Controller.published(), 60)
    assert error < 1e-10
    assert modes == {(1, 1)}


STOPS = {
    "both at once": (coasting((0.4, 0.0), coulomb_friction=0.1), {(1, 1), (0, 0)}),
    "one first": (coasting((0.3, 1.0), coulomb_friction=0.1), {(1, 1), (1, 0), (0, 0)}),
    "turning": (
        coasting((0.3, -4.0), coulomb_friction=0.1, viscous_friction=0.02),
        {(-1, 1), (0, 1), (0, 0)},
    ),
}


@pytest.mark.parametrize(("scenario", "expected"), STOPS.values(), ids=STOPS.keys())
def test_stopping(scenario, expected):
    error, modes = largest_error(scenario, IDLE, 40)
    assert error < 1e-10
    assert modes == expected
    final = nfopidn.simulate(scenario, IDLE)
    assert np.all(final.columns["v"][-50:] == 0)
    assert np.all(final.columns["omega"][-50:] == 0)
    assert np.all(final.pose[-50:] == final.pose[-1])


@pytest.mark.parametrize("viscous", [0.0, 0.02])
@pytest.mark.parametrize("seed", [3, 4])
def test_sticking_and_breaking_loose(viscous, seed):
    scenario = coasting(
        (0.0, 0.0),
        coulomb_friction=0.15,
        viscous_friction=viscous,
        disturbance=drifting(151, (0.75, 0.15), seed),
    )
    error, modes = largest_error(scenario, IDLE, 100)
    assert error < 1e-10
    assert (STICKS, STICKS) in modes
    assert len(modes) > 3


def test_under_control_with_friction():
    scenario = Scenario.published(integrator="exact", coulomb_friction=0.2)
    error, modes = largest_error(scenario, Controller.published(), 60)
    assert error < 1e-10
    assert len(modes) > 2


SCRUBBING = {
    "stops turning, then rolls straight": coasting(
        (0.4, 0.5), coulomb_scrub=0.15, viscous_friction=0.01
    ),
    "with friction of the wheels": coasting((0.4, 0.5), coulomb_scrub=0.1, coulomb_friction=0.03),
    "turns about a wheel": coasting(
        (0.1, 1.2), coulomb_scrub=0.02, coulomb_friction=0.1, viscous_scrub=0.1
    ),
    "is pushed past it": coasting(
        (0.0, 0.0),
        coulomb_scrub=0.1,
        coulomb_friction=0.1,
        viscous_scrub=0.05,
        viscous_friction=0.02,
        disturbance=drifting(151, (0.75, 0.15), 5),
    ),
    "alone": coasting(
        (0.3, 0.0), coulomb_scrub=0.2, viscous_scrub=0.1, disturbance=drifting(151, (0.05, 0.06), 8)
    ),
    "under control": Scenario.published(
        integrator="exact", coulomb_scrub=0.2, viscous_scrub=0.1, coulomb_friction=0.05
    ),
}
#: Ways to move: left wheel, right wheel, turning.
WAYS = {
    "stops turning, then rolls straight": {(1, 1, 1), (1, 1, 0)},
    "with friction of the wheels": {(1, 1, 1), (1, 1, 0), (0, 0, 0)},
    "turns about a wheel": {(1, -1, 1), (1, 0, 1), (0, 0, 0)},
    "is pushed past it": {(0, 0, 0), (-1, 0, -1), (-1, 1, -1), (-1, -1, -1)},
    "alone": {(1, 1, 0), (1, 1, 1), (1, 1, -1), (-1, -1, 0)},
    "under control": {(1, 1, 0), (1, 1, 1)},
}


@pytest.mark.parametrize("name", SCRUBBING)
def test_with_scrub(name):
    controlled = name == "under control"
    error, modes = largest_error(
        SCRUBBING[name], Controller.published() if controlled else IDLE, 60 if controlled else 100
    )
    assert error < 1e-10
    assert modes >= WAYS[name]


def test_viscous_scrub():
    scenario = Scenario.published(integrator="exact", viscous_scrub=0.2, viscous_friction=0.01)
    error, _ = largest_error(scenario, Controller.published(), 40)
    assert error < 1e-10


def final_state(scenario, controller, **changes):
    result = nfopidn.simulate(scenario.replace(**changes), controller)
    assert result.diverged_at is None
    return np.array([result.columns[name][-1] for name in STATE])


ORDERS = {
    "published": (Scenario.published(period=150), Controller.published()),
    "viscous": (Scenario.published(viscous_friction=0.05), Controller.published()),
    "disturbance": (coasting((0.3, 0.5), disturbance=wind(151, 0.5, 1)), IDLE),
    "sliding": (
        coasting((2.0, 0.3), coulomb_friction=0.05, disturbance=(2.0, 0.0)),
        IDLE,
    ),
}


@pytest.mark.parametrize(("scenario", "controller"), ORDERS.values(), ids=ORDERS.keys())
def test_euler_converges_to_the_exact_motion_at_first_order(scenario, controller):
    exact = final_state(scenario, controller, integrator="exact")
    errors = [
        np.linalg.norm(
            final_state(scenario, controller, integrator="semi-implicit-euler", substeps=n) - exact
        )
        for n in (64, 128, 256, 512)
    ]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert errors[-1] > 1e-9
    np.testing.assert_allclose(orders, 1, atol=0.05)


def test_euler_converges_to_the_exact_stop():
    scenario, _ = STOPS["one first"]
    exact = final_state(scenario, IDLE)
    errors = [
        np.abs(
            final_state(scenario, IDLE, integrator="semi-implicit-euler", substeps=n) - exact
        ).max()
        for n in (10, 100, 1000)
    ]
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[2] < 1e-3


@pytest.mark.parametrize("path", [Trajectory.line, Trajectory.circle])
def test_feedforward_alone_holds_a_line_and_a_circle(path):
    scenario = Scenario(
        path(derivatives="analytic"), integrator="exact", initial_velocity="reference"
    )
    result = nfopidn.simulate(scenario, IDLE)
    assert result.metrics["position_max"] < 1e-10
    assert np.abs(result.columns["e_theta"]).max() < 1e-10


def test_substeps_do_not_change_the_exact_motion():
    scenario = Scenario.published(integrator="exact", coulomb_friction=0.05, viscous_friction=0.01)
    once = final_state(scenario, Controller.published())
    often = final_state(scenario, Controller.published(), substeps=7)
    np.testing.assert_allclose(often, once, rtol=0, atol=1e-9)


def test_delay_shifts_the_applied_torques():
    scenario = Scenario.published(integrator="exact", delay=2)
    result = nfopidn.simulate(scenario)
    states = np.column_stack([result.columns[name] for name in STATE])
    applied = np.vstack([np.zeros((2, 2)), result.torque[:-2]])
    motion = Motion(scenario)
    for k in range(40):
        state, _ = motion.advance(states[k], applied[k], (0.0, 0.0), 0.2)
        np.testing.assert_allclose(states[k + 1], state, rtol=0, atol=1e-10)
