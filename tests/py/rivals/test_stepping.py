"""Every controller stepped by hand, sample by sample, is the one that simulate() runs."""

import numpy as np
import pytest
from nfopidn import (
    Controller,
    Rival,
    Robot,
    Scenario,
    Trajectory,
    _core,
    odometry,
    simulate,
    to_rep103,
)

DRIVERS = [
    *(Rival(law) for law in Rival.laws()),
    Rival("samson", speeds="differenced", integral=True, k_i_v=0.1),
    Controller.recommended(),
    Controller.published(lateral="speed", memory=30),
    Controller.published(memory=200, form="incremental"),
]


@pytest.fixture(scope="module", params=["rest", "moving"])
def scenario(request):
    return Scenario.published(
        period=30.0,
        rng=1,
        pose_noise=(0.003, 0.002),
        torque_limit=0.4,
        initial_velocity="reference" if request.param == "moving" else (0.0, 0.0),
    )


def seen(run, k, noise):
    pose = run.pose[k] + noise[k]
    return [*pose, run.columns["v"][k], run.columns["omega"][k]]


@pytest.mark.parametrize("driver", DRIVERS, ids=lambda d: getattr(d, "law", d.__class__.__name__))
def test_steps_are_those_of_simulate(scenario, driver):
    """Bit for bit, with the scenario's limit, sample time and peak speed not said again."""
    run = simulate(scenario, driver)
    noise = _core.noise_rows(scenario)
    law = driver.replace()
    law.start(scenario)
    for k, row in enumerate(scenario.reference[: len(run)]):
        assert law.step(seen(run, k, noise), row) == tuple(run.torque[k])
        assert law.feedback() == (run.columns["tau_fb_left"][k], run.columns["tau_fb_right"][k])


def test_a_step_before_the_start_is_refused(scenario):
    rival = Rival("samson")
    with pytest.raises(ValueError, match=r"Rival.step: the sample time .* call start\(scenario\)"):
        rival.step([0, 0, 0], scenario.reference[0])
    assert rival.feedback() == (0.0, 0.0)
    rival.reset()
    with pytest.raises(ValueError, match="speed_scale"):
        Controller.published(lateral="speed").step([0, 0, 0], scenario.reference[0])


def test_a_start_forgets_and_copies_are_not_started(scenario):
    rival = Rival("samson", integral=True, k_i_v=1.0)
    rows = scenario.reference
    pose = [*rows[0, :3], 0.02, 0.0]
    rival.start(scenario)
    first = [rival.step(pose, row) for row in rows[:5]]
    assert [rival.step(pose, row) for row in rows[:5]] != first
    for again in (lambda: rival.start(scenario), rival.reset):
        again()
        assert [rival.step(pose, row) for row in rows[:5]] == first
    with pytest.raises(ValueError, match="start"):
        rival.replace().step([0, 0, 0], rows[0])


def test_the_limit_of_a_step(scenario):
    """None is the scenario's; another one holds from then on and keeps the memory."""
    for driver in (Rival("samson"), Controller.published()):
        driver.start(scenario.replace(torque_limit=0.05))
        far = [5.0, 5.0, 2.0, 0.0, 0.0]
        assert max(map(abs, driver.step(far, scenario.reference[0]))) == 0.05
        assert max(map(abs, driver.step(far, scenario.reference[0], 0.03))) == 0.03
        for bad in (0.0, -1.0, np.nan, np.inf):
            with pytest.raises(ValueError, match="torque_limit"):
                driver.step(far, scenario.reference[0], bad)
        with pytest.raises(TypeError, match="torque_limit"):
            driver.step(far, scenario.reference[0], "a lot")


def test_the_integral_stays_within_the_limit_that_holds(scenario):
    """What a law with integral action has summed up is bounded by the limit of the step."""
    rival = Rival("samson", integral=True, k_i_v=5.0, k_i_omega=0.0)
    rival.start(scenario)
    for _ in range(200):
        rival.step([-3.0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0], 0.01)
    held = rival.step([0, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 0, 0], 0.01)
    assert held == (0.01, 0.01)
    # Of each wheel half of what 2 x 0.01 N m can do: the sum does not exceed the limit.
    assert max(map(abs, rival.feedback())) <= 0.01 * (1 + 1e-12)


@pytest.mark.parametrize(
    ("measurement", "message"),
    [([0, 0], "has 2 numbers"), ([0, np.nan, 0], r"measurement\[1\]"), ("abc", "measurement")],
)
def test_bad_measurements_leave_the_memory(scenario, measurement, message):
    rival = Rival("lqr", speeds="differenced")
    twin = Rival("lqr", speeds="differenced")
    for one in (rival, twin):
        one.start(scenario)
        one.step([0, 0, 0], scenario.reference[0])
    with pytest.raises((ValueError, TypeError), match=message):
        rival.step(measurement, scenario.reference[1])
    pose = [0.1, 0, 0]
    assert rival.step(pose, scenario.reference[1]) == twin.step(pose, scenario.reference[1])


def test_a_controller_starts_only_for_its_sample_time():
    other = Scenario(Trajectory.circle(dt=0.1), rng=0)
    with pytest.raises(ValueError, match="sample_time"):
        Controller.recommended().start(other)
    with pytest.warns(UserWarning, match="Controller.start: .*mass"):
        Controller.recommended().start(Scenario.published(robot=Robot(mass=20.0), rng=0))


def test_wheels_change_places():
    assert to_rep103((1.0, -2.0)) == (-2.0, 1.0)
    with pytest.raises(ValueError, match="two numbers"):
        to_rep103([1.0])


def test_odometry_follows_an_arc():
    """Half a circle of radius 1 about (0, 1): by the right wheel's longer way."""
    track = 0.4
    left, right = np.pi * (1 - track / 2), np.pi * (1 + track / 2)
    np.testing.assert_allclose(
        odometry([0.0, 0.0, 0.0], left, right, track)[:2], [0.0, 2.0], atol=1e-12
    )
    for bad in ((np.inf, 0.1, 0.4), (0.1, np.nan, 0.4), (0.1, 0.1, 0.0)):
        with pytest.raises(ValueError, match=r"odometry: (left|right|track_width)"):
            odometry([0, 0, 0], *bad)
    with pytest.raises(ValueError, match=r"pose\[2\]"):
        odometry([0, 0, np.nan], 0.1, 0.1, 0.4)
    with pytest.raises(ValueError, match="three numbers"):
        odometry([0, 0], 0.1, 0.1, 0.4)
