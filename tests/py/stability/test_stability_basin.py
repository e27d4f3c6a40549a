"""nfopidn.stability.basin against runs of simulate()."""

import numpy as np
import pytest
from nfopidn import Controller, Scenario, simulate, stability
from refusal import refused


def test_a_grid_of_poses_is_simulated():
    scenario = Scenario.published(initial_velocity=(0.1, 0.05))
    x, y = [1.0, 3.0, 4.5, 14.0], [-1.0, 0.0, 1.0]
    found = stability.basin(scenario, x=x, y=y, theta=0.7, last=4.0, tolerance=0.2)
    assert found.position_error.shape == found.converged.shape == (3, 4)
    for row, column in np.ndindex(3, 4):
        if column == 3:  # 11 m away: beyond the divergence distance
            assert np.isinf(found.position_error[row, column])
            continue
        run = simulate(scenario.replace(initial_pose=(x[column], y[row], 0.7)))
        if run.diverged_at is not None:
            assert np.isinf(found.position_error[row, column])
            continue
        table = {name: values[-20:] for name, values in run.columns.items()}
        position = np.sqrt(np.mean(table["e_x"] ** 2 + table["e_y"] ** 2))
        assert found.position_error[row, column] == pytest.approx(position, rel=1e-9)
        heading = np.sqrt(np.mean(table["e_theta"] ** 2))
        assert found.heading_error[row, column] == pytest.approx(heading, rel=1e-9)
        assert found.converged[row, column] == (position <= 0.2)
    assert 0 < found.share < 1
    assert found.share == np.mean(found.converged)
    assert "diverge" in str(found)


def test_the_heading_may_have_to_fit_too():
    axis = np.linspace(3, 5, 9)
    anyhow = stability.basin(x=axis, y=axis)
    bound = float(np.median(anyhow.heading_error[anyhow.converged]))
    strict = stability.basin(x=axis, y=axis, heading_tolerance=bound)
    assert strict.converged.sum() < anyhow.converged.sum()
    assert np.array_equal(strict.converged, anyhow.converged & (anyhow.heading_error <= bound))


def test_the_number_of_threads_changes_nothing():
    axis = np.linspace(1, 5, 9)
    one, three = (stability.basin(x=axis, y=axis, workers=workers) for workers in (1, 3))
    assert np.array_equal(one.position_error, three.position_error)
    assert np.array_equal(one.heading_error, three.heading_error)


def test_the_default_is_ten_thousand_poses_around_the_start():
    found = stability.basin(controller=Controller.tuned_nominal())
    assert found.converged.shape == (100, 100)
    assert (found.x[0], found.x[-1], found.y[0], found.y[-1]) == (0, 6, -3, 3)
    assert found.theta == 1.0472
    assert found.share == pytest.approx(0.578, abs=0.02)


def test_a_stable_loop_has_a_basin_and_an_unstable_one_has_none():
    axis = np.linspace(2.5, 3.5, 5)
    settings = {"x": axis, "y": axis - 3, "tolerance": 0.3}
    assert stability.basin(Scenario.published(laps=2), **settings).share > 0.5
    incremental = Controller.published(form="incremental")
    assert stability.basin(Scenario.published(laps=2), incremental, **settings).share == 0


def test_arguments_out_of_range_are_refused():
    for name in ("x", "y"):
        with refused(f"{name} has shape (1, 2)", "one-dimensional"):
            stability.basin(**{name: [[1, 2]]})
        with refused(f"{name} has shape (0,)", "not empty"):
            stability.basin(**{name: []})
        with refused(f"{name} has nan", "in [-1e+06, 1e+06] m"):
            stability.basin(**{name: [0, np.nan]})
    for value in (0, -1, np.nan, 2e6):
        with refused(f"tolerance is {value}", "in (0, 1e+06] m"):
            stability.basin(tolerance=value)
        with refused(f"heading_tolerance is {value}", "in (0, 1e+06] rad"):
            stability.basin(heading_tolerance=value)
    with refused("last is 151", "in (0, 150] s"):
        stability.basin(last=151)
    with refused("theta is nan", "rad"):
        stability.basin(theta=np.nan)
    for text in ("0.5", b"1", None, 10**400, 10**5000):
        with refused("y is ", "numbers [m]"):
            stability.basin(x=[0.0], y=[text])
    with refused("last is a whole number of about 5001 digits", "s"):
        stability.basin(x=[0.0], y=[0.0], last=10**5000)
    with refused("x is ['a']", "numbers [m]"):
        stability.basin(x=["a"])
    with refused("tolerance is x", "in (0, 1e+06] m"):
        stability.basin(tolerance="x")
    for workers in (0, 1025, 1.5):
        with refused(f"workers is {workers}", "in [1, 1024]"):
            stability.basin(workers=workers)


@pytest.mark.parametrize("call", [stability.basin, stability.loop, stability.margins])
def test_what_is_no_scenario_and_no_controller_is_refused(call):
    with refused("scenario is 'x'", "must be a Scenario"):
        call(scenario="x")
    with refused("controller is 'x'", "must be a Controller"):
        call(controller="x")
