"""Scrub, and the wheels' inertia, as Python has them."""

import json

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Robot, Scenario, Trajectory

IDLE = Controller.published(gains=np.zeros((3, 3)))
SCRUB = {"viscous_scrub": 0.05, "coulomb_scrub": 0.02}


def test_documents_without_it_are_as_they_were():
    plain = Scenario.published(rng=0)
    assert not {*SCRUB} & {*json.loads(plain.to_json())}
    with_scrub = plain.replace(**SCRUB)
    document = json.loads(with_scrub.to_json())
    assert {name: document[name] for name in SCRUB} == SCRUB
    assert Scenario.from_json(with_scrub.to_json()) == with_scrub
    assert with_scrub.replace(viscous_scrub=0.0, coulomb_scrub=0.0) == plain


@pytest.mark.parametrize("integrator", ["semi-implicit-euler", "exact"])
def test_a_spinning_robot_stops_and_a_rolling_one_goes_on(integrator):
    scenario = Scenario(
        Trajectory.circle(period=30),
        initial_velocity=(0.3, 0.5),
        integrator=integrator,
        feedforward=False,
        coulomb_scrub=0.1,
        divergence_distance=1e3,
        rng=0,
    )
    columns = nfopidn.simulate(scenario, IDLE).columns
    stop = 0.5 * Robot().inertia / 0.1  # of omega, at a constant rate [s]
    late = columns["t"] > stop + 0.2
    assert np.all(columns["omega"][late] == 0)
    assert np.all(columns["omega"][columns["t"] < stop - 0.2] > 0)
    assert np.all(columns["v"] == pytest.approx(0.3, abs=1e-15))


@pytest.mark.parametrize("integrator", ["semi-implicit-euler", "exact"])
def test_searches_have_it(integrator):
    """In lanes; a tuned cost is that of a single run."""
    scenario = Scenario.published(rng=0, integrator=integrator, **SCRUB)
    result = nfopidn.tune(scenario, structure="tracking", maxfev=300, rng=1, robustness=None)
    assert result.fun < 0.1
    single = nfopidn.simulate(scenario, result.controller)
    assert single.cost == pytest.approx(result.fun, rel=1e-9)
    plain = scenario.replace(viscous_scrub=0.0, coulomb_scrub=0.0)
    assert nfopidn.simulate(plain, result.controller).cost != pytest.approx(result.fun, rel=1e-6)


def test_margins_leave_coulomb_scrub_out_and_have_viscous_scrub():
    controller = Controller.tuned_nominal()
    margins = [
        nfopidn.stability.margins(controller, Scenario.published(rng=0, **changes), speed=0.3)
        for changes in ({}, {"coulomb_scrub": 0.1}, {"viscous_scrub": 0.5})
    ]
    assert np.array_equal(margins[0].poles, margins[1].poles)
    assert not np.allclose(margins[0].poles, margins[2].poles)


def test_wheels_add_to_mass_and_inertia():
    """By the kinetic energy of the wheels, which roll at (v +- L omega / 2) / r."""
    robot = Robot.eddie_datasheet()
    loaded = robot.with_wheels(0.01)
    v, omega = 0.4, 1.3
    wheels = (v + np.array([0.5, -0.5]) * robot.track_width * omega) / robot.wheel_radius
    energy = [0.5 * (one.mass * v**2 + one.inertia * omega**2) for one in (robot, loaded)]
    assert energy[1] - energy[0] == pytest.approx(0.5 * 0.01 * (wheels**2).sum(), rel=1e-12)
    assert (loaded.track_width, loaded.wheel_radius) == (robot.track_width, robot.wheel_radius)
    assert robot.with_wheels(0.0) == robot


@pytest.mark.parametrize("bad", [-1e-9, 1001.0, np.nan, np.inf])
def test_bad_wheels_are_refused(bad):
    with pytest.raises(ValueError, match=r"wheel_inertia is .*must be.*1000\] kg m\^2|must be fin"):
        Robot().with_wheels(bad)


def test_wheels_that_make_no_robot_are_refused():
    with pytest.raises(ValueError, match=r"with_wheels: mass is 2000000011.5; must be in"):
        Robot(wheel_radius=1e-3).with_wheels(1000.0)
