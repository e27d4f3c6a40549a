"""Reference trajectories against NumPy."""

import numpy as np
import pytest
from nfopidn import Robot, Scenario, Trajectory

NAMED_PATHS = ["ranunculoid", "circle", "lemniscate", "eight", "line", "sine", "rounded_square"]
HEADINGS = ["forward", "continuous"]


def make(name, **settings):
    return getattr(Trajectory, name)(**settings)


def square_residue(x, y):
    """Distance from the square of side 4 with corners of radius 1."""
    outside = np.maximum(np.abs([x, y]) - 1, 0)
    return np.hypot(*outside) - 1


EQUATIONS = {
    "circle": lambda x, y: x**2 + y**2 - 4,
    "lemniscate": lambda x, y: (x**2 + y**2) ** 2 - 4 * (x**2 - y**2),
    "eight": lambda x, y: x**4 - 4 * (x**2 - y**2),
    "line": lambda x, y: y,
    "sine": lambda x, y: y - np.sin(2 * np.pi * x / 6),
    "rounded_square": square_residue,
}


@pytest.mark.parametrize("cusps", [3, 5])
def test_epicycloid(cusps):
    path = Trajectory.ranunculoid(cusps=cusps, scale=1.5, laps=2)
    phase = 2 * np.pi * path.t / 150
    n = cusps + 1
    np.testing.assert_allclose(path.x, 1.5 * (n * np.cos(phase) - np.cos(n * phase)), atol=1e-12)
    np.testing.assert_allclose(path.y, 1.5 * (n * np.sin(phase) - np.sin(n * phase)), atol=1e-12)
    assert np.array_equal(path.t, np.arange(1501) * 0.2)


@pytest.mark.parametrize("name", EQUATIONS)
def test_points_lie_on_the_curve_and_go_all_the_way_round(name):
    path = make(name)
    np.testing.assert_allclose(EQUATIONS[name](path.x, path.y), 0, atol=1e-12)
    ends = np.array([path.x[-1] - path.x[0], path.y[-1] - path.y[0]])
    expected = [6, 0] if name in ("line", "sine") else [0, 0]
    np.testing.assert_allclose(ends, expected, atol=1e-12)
    length = np.hypot(np.diff(path.x), np.diff(path.y)).sum()
    assert length > 5.9


@pytest.mark.parametrize("name", NAMED_PATHS)
def test_scale_and_laps(name):
    once, twice = make(name), make(name, scale=2.5, laps=2)
    assert len(twice) == 2 * (len(once) - 1) + 1
    np.testing.assert_allclose(twice.x[:751], 2.5 * once.x, atol=1e-12)
    np.testing.assert_allclose(np.diff(twice.y[750:]), 2.5 * np.diff(once.y), atol=1e-12)


@pytest.mark.parametrize("name", NAMED_PATHS)
def test_sampled_derivatives_are_central_differences(name):
    path = make(name)
    dx, dy = np.gradient(path.x, 0.2), np.gradient(path.y, 0.2)
    theta = np.unwrap(np.arctan2(dy, dx))
    v = np.hypot(dx, dy)
    omega = np.gradient(theta, 0.2)
    expected = [theta, v, omega, np.gradient(v, 0.2), np.gradient(omega, 0.2)]
    names = ["theta", "v", "omega", "acceleration", "turn_acceleration"]
    for member, values in zip(names, expected, strict=True):
        np.testing.assert_allclose(getattr(path, member), values, atol=1e-11, err_msg=member)
    assert not path.reverse.any()


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("name", NAMED_PATHS)
def test_the_robot_never_slips_sideways(name, heading):
    path = make(name, heading=heading, derivatives="analytic", period=20, dt=1e-3)
    dx, dy = np.gradient(path.x, 1e-3), np.gradient(path.y, 1e-3)
    inner = slice(2, -2)
    forward = dx * np.cos(path.theta) + dy * np.sin(path.theta)
    sideways = dy * np.cos(path.theta) - dx * np.sin(path.theta)
    np.testing.assert_allclose(forward[inner], path.v[inner], atol=2e-3)
    np.testing.assert_allclose(sideways[inner], 0, atol=2e-3)


@pytest.mark.parametrize("derivatives", ["sampled", "analytic"])
def test_continuous_heading_reverses_on_alternate_arcs(derivatives):
    path = Trajectory.ranunculoid(heading="continuous", derivatives=derivatives)
    w = 2 * np.pi / 150
    np.testing.assert_allclose(path.theta, 2.5 * w * path.t, atol=1e-12)
    np.testing.assert_allclose(path.v, 8 * w * np.sin(1.5 * w * path.t), atol=1e-12)
    np.testing.assert_allclose(path.omega, 2.5 * w, atol=1e-12)
    moving = np.abs(path.v) > 1e-6
    assert np.array_equal(path.reverse[moving], path.v[moving] < 0)
    exact = 12 * w**2 * np.cos(1.5 * w * path.t)
    expected = exact if derivatives == "analytic" else np.gradient(path.v, 0.2)
    np.testing.assert_allclose(path.acceleration, expected, atol=1e-12)


def test_peak_speed():
    assert Trajectory.ranunculoid(derivatives="analytic").peak_speed == pytest.approx(
        16 * np.pi / 150, rel=1e-3
    )
    path = Trajectory.ranunculoid(heading="continuous")
    assert path.peak_speed == np.abs(path.v).max()


@pytest.mark.parametrize("heading", HEADINGS)
@pytest.mark.parametrize("name", ["circle", "sine"])
def test_samples_of_a_named_path_are_that_path(name, heading):
    named = make(name)
    path = Trajectory.from_samples(named.x, named.y, 0.2, heading=heading)
    for member in ("x", "y", "theta", "v", "omega", "acceleration", "turn_acceleration", "reverse"):
        assert np.array_equal(getattr(path, member), getattr(named, member)), member
    assert (path.name, path.period, len(path)) == ("samples", pytest.approx(150), 751)


@pytest.mark.parametrize("dt", [1e-6, 1e-5, 1e3])
def test_samples_may_be_as_close_and_as_far_apart_as_dt_may_be(dt):
    path = Trajectory.from_samples([0, 1, 2], [0, 0, 0], dt)
    np.testing.assert_allclose(path.v, 1 / dt, rtol=1e-15)
    assert Scenario(path, rng=0) == Scenario(path).replace(rng=0)


def test_samples_with_a_cusp():
    along = np.array([0, 1, 2, 1.5, 0.5, -0.5])
    path = Trajectory.from_samples(along, 0 * along, 1.0, heading="continuous")
    assert np.array_equal(path.theta, np.zeros(6))
    assert np.array_equal(path.v, np.gradient(along))
    assert path.reverse.tolist() == [False, False, False, True, True, True]
    forward = Trajectory.from_samples(along, 0 * along, 1.0)
    assert np.array_equal(np.abs(forward.theta) > 3, path.reverse)
    assert np.array_equal(forward.v, np.abs(path.v))


def test_laps_of_closed_samples():
    x, y = [0, 1, 1, 0, 0], [0, 0, 1, 1, 0]
    path = Trajectory.from_samples(x, y, 0.5, laps=3)
    assert np.array_equal(path.x, [*x, *x[1:], *x[1:]])
    assert np.array_equal(path.y, [*y, *y[1:], *y[1:]])


@pytest.mark.parametrize("with_time", [True, False])
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
@pytest.mark.parametrize("mark", ["", "\ufeff"], ids=["", "byte order mark"])
def test_csv_is_the_same_as_samples(with_time, ending, mark, tmp_path):
    x, y = [0.0, 0.1, 0.3, 0.2], [1.0, 1e-3, -2.5, 0.125]
    header = "speed,y,x,t" if with_time else "y, x"
    rows = [header]
    for k in range(4):
        row = f"{y[k]!r}, +{x[k]!r}"
        rows += [f"9,{row},{3 + 0.25 * k}" if with_time else row, ""]
    path = tmp_path / "path.csv"
    path.write_bytes((mark + ending.join(rows)).encode())
    loaded = Trajectory.from_csv(path, dt=0.25)
    assert loaded == Trajectory.from_samples(x, y, 0.25)


def test_a_run_table_is_a_trajectory(published, tmp_path):
    published.to_csv(tmp_path / "run.csv")
    path = Trajectory.from_csv(tmp_path / "run.csv")
    assert np.array_equal(path.x, published.columns["x"])
    assert path.dt == pytest.approx(0.2, rel=1e-15)


def test_reference_rows_are_the_trajectory_and_its_torques():
    robot = Robot(5.0, 0.2, 0.3, 0.04)
    path = Trajectory.ranunculoid(heading="continuous")
    reference = Scenario(path, robot).reference
    total = path.acceleration * robot.mass * robot.wheel_radius
    difference = path.turn_acceleration * 2 * robot.inertia * robot.wheel_radius / 0.3
    expected = [path.x, path.y, path.theta, path.v, path.omega]
    expected += [(total + difference) / 2, (total - difference) / 2, path.reverse]
    np.testing.assert_allclose(reference, np.transpose(expected), rtol=1e-14, atol=1e-15)
