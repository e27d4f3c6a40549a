"""Random paths and plants that no search has seen."""

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, families
from nfopidn.families.unseen import periodic_spline
from nfopidn.robustness.reference_limits import beyond_the_robot
from scipy import interpolate

FAMILY = families.unseen(8, rng=3)
PLANTS = 7


def test_the_seed_makes_the_family():
    assert families.unseen(8, rng=3) == FAMILY
    assert families.unseen(5, rng=3) == FAMILY[: 5 * PLANTS]
    assert families.unseen(1, rng=4).scenarios[0] != FAMILY.scenarios[0]
    assert len(FAMILY) == 8 * PLANTS
    paths = [name.split("/")[0] for name in FAMILY.names[::PLANTS]]
    assert paths == [
        *("spline 1", "cusps 2", "spline 3", "curve 4"),
        *("spline 5", "cusps 6", "spline 7", "curve 8"),
    ]


def test_the_plants_are_those_that_are_named():
    nominal, heavy, delayed, finer, noisy, pushed, viscous = FAMILY[:PLANTS]
    eddie = nfopidn.Robot.eddie()
    assert (nominal.robot, nominal.delay, nominal.substeps) == (eddie, 0, 1)
    assert (nominal.coulomb_friction, nominal.viscous_friction) == (0, 0)
    assert (heavy.robot, heavy.coulomb_friction) == (eddie.replace(mass=13.8), 0.15)
    assert (delayed.delay, delayed.substeps) == (1, 4)
    assert (finer.delay, finer.substeps, finer.robot.inertia) == (1, 20, 0.294)
    assert (noisy.pose_noise, noisy.coulomb_friction) == ((0.005, 0.005), 0.1)
    assert pushed.disturbance == (-2.0, -0.2)
    assert viscous.viscous_friction == 0.03
    assert {one.integrator for one in FAMILY} == {"semi-implicit-euler"}
    assert {one.model for one in FAMILY} == {None}
    for one in FAMILY[:PLANTS]:
        assert one.trajectory == nominal.trajectory
        assert one.initial_pose == nominal.initial_pose
    assert {name.split("/")[1] for name in FAMILY.names} == {
        name.split("/")[1] for name in FAMILY.names[:PLANTS]
    }


def test_each_path_can_be_driven():
    for seed in (0, 1, 2):
        for name, one in families.unseen(16, rng=seed).items():
            path = one.trajectory
            assert beyond_the_robot(one) == (), name
            wheel = (np.abs(path.v) + 0.5 * one.robot.track_width * np.abs(path.omega)) / (
                one.robot.wheel_radius
            )
            friction = one.coulomb_friction + one.viscous_friction * wheel
            torques = np.abs(one.reference[:, 5:7]).max(axis=1)
            assert (torques + friction).max() <= 0.9 * one.torque_limit, name
            if not name.startswith("cusps"):
                assert np.abs(path.omega).max() <= 1.25, name
                assert np.abs(path.turn_acceleration).max() <= 1.5, name
            assert path.peak_speed < 0.9, name
            assert len(path) * path.dt >= 19.9, name


def test_it_starts_at_rest_beside_the_path():
    starts = set()
    for one in families.unseen(16)[::PLANTS]:
        path = one.trajectory
        x, y, theta = one.initial_pose
        ahead = (x - path.x[0]) * np.cos(theta) + (y - path.y[0]) * np.sin(theta)
        beside = (y - path.y[0]) * np.cos(theta) - (x - path.x[0]) * np.sin(theta)
        assert theta == path.theta[0]
        assert abs(ahead) < 1e-12
        assert 0.1 - 1e-12 <= abs(beside) <= 0.3 + 1e-12
        assert one.initial_velocity == (0, 0)
        starts.add(bool(beside > 0))
    assert starts == {True, False}


def test_its_splines_are_those_of_another_implementation():
    draw = np.random.default_rng(5)
    knots = draw.uniform(-1, 1, (6, 2))
    closed = np.vstack([knots, knots[:1]])
    length = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(closed, axis=0).T))])
    there = interpolate.CubicSpline(length, closed, bc_type="periodic")
    count = 97
    expected = there(length[-1] * np.arange(count) / count)
    assert np.allclose(
        np.column_stack(periodic_spline(*knots.T, count)), expected, rtol=0, atol=1e-12
    )


def test_it_prints_what_each_member_is():
    first, second = str(FAMILY).splitlines()[:2]
    assert first.startswith("spline 1/nominal ")
    assert " closed spline through " in first
    assert first.endswith("m/s")
    assert "Coulomb friction 0.15 N m a wheel, mass 13.8 kg" in second


def test_recommended_gains_stay_on_all_of_it():
    runs = nfopidn.simulate_many(FAMILY[:PLANTS], Controller.recommended().replace(robot=None))
    assert runs.worst_cost < 0.2


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"count": 0}, r"count is 0; must be .*1"),
        ({"count": 2.5}, r"count is 2.5"),
        ({"count": 1001}, r"count is 1001"),
        ({"rng": -1}, r"rng is -1"),
        ({"rng": None}, r"rng is None"),
    ],
)
def test_what_is_no_family_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        families.unseen(**{"count": 1, **given})
