"""Trajectories through waypoints: every limit at every sample, the path, the stops, the time."""

import inspect
from math import inf, nan, pi

import nfopidn
import numpy as np
import pytest
from nfopidn import Robot, Scenario, Trajectory
from nfopidn.trajectories import Limits, from_waypoints, plan_waypoints, uses
from nfopidn.trajectories.path import fit_curve
from nfopidn.trajectories.pieces import measure
from nfopidn.trajectories.timing import Motion, fastest, times

EDDIE = Robot()
ALL = Limits(
    speed=1.0,
    acceleration=0.8,
    deceleration=0.6,
    lateral_acceleration=0.6,
    turn_rate=1.5,
    turn_acceleration=4.0,
    wheel_speed=15.0,
    wheel_torque=1.0,
    no_load_speed=60.0,
    coulomb_friction=0.1,
    viscous_friction=0.01,
)
SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])


def random_waypoints(seed):
    """Arguments of from_waypoints(): any of what waypoints can have."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 11))
    points = np.cumsum(rng.normal(size=(n, 2)), axis=0)
    return points, {
        "closed": bool(rng.integers(2)) and n > 2,
        "theta": np.where(rng.random(n) < 0.2, rng.uniform(-3, 3, n), nan),
        "reverse": rng.random(n) < 0.15,
        "dwell": np.where(rng.random(n) < 0.1, 0.3, 0.0),
        "tolerance": float(rng.choice([0.0, 0.05])),
        "smoothing": rng.choice([None, 0.0]),
    }


def asked(trajectory):
    """The largest of each limited quantity, by formulas of its own from x, y and theta alone."""
    dt = trajectory.dt
    dx, dy = np.gradient(trajectory.x, dt), np.gradient(trajectory.y, dt)
    v = np.hypot(dx, dy) * np.where(trajectory.reverse, -1, 1)
    omega = np.gradient(trajectory.theta, dt)
    a, alpha = np.gradient(np.abs(v), dt), np.gradient(omega, dt)
    drive = EDDIE.mass * EDDIE.wheel_radius * np.gradient(v, dt)
    steer = 2 * EDDIE.inertia * EDDIE.wheel_radius / EDDIE.track_width * alpha
    wheels = np.stack([v + 0.226 * omega, v - 0.226 * omega]) / 0.076
    torque = 0.5 * np.abs(np.stack([drive + steer, drive - steer]))
    moving = np.abs(wheels) > 1e-6
    return {
        "speed": np.abs(v).max(),
        "acceleration": a.max(),
        "deceleration": -a.min(),
        "lateral_acceleration": np.abs(v * omega).max(),
        "turn_rate": np.abs(omega).max(),
        "turn_acceleration": np.abs(alpha).max(),
        "wheel_speed": np.abs(wheels).max(),
        "wheel_torque": (torque + (1 / 60 + 0.01) * np.abs(wheels) + 0.1 * moving).max(),
    }


@pytest.mark.parametrize("seed", range(50))
def test_every_limit_holds_at_every_sample(seed):
    points, settings = random_waypoints(seed)
    plan = plan_waypoints(points, ALL, 0.02, EDDIE, **settings)
    for name, value in asked(plan.trajectory).items():
        assert value <= getattr(ALL, name) * (1 + 1e-6), name
    assert max(plan.use.values()) > 0.97  # and the motion is as fast as one of them
    path = np.column_stack([plan.trajectory.x, plan.trajectory.y])
    apart = np.hypot(*(path[:, None] - points[None]).transpose(2, 0, 1)).min(axis=0)
    assert apart.max() <= settings["tolerance"] + 0.02  # a sample may lie half a step from it
    assert plan.trajectory.v[0] == plan.trajectory.v[-1] == 0
    assert plan.trajectory.omega[0] == plan.trajectory.omega[-1] == 0
    scenario = Scenario(plan.trajectory, EDDIE, torque_limit=1.0, rng=0)
    assert np.abs(scenario.reference[:, 5:7]).max() <= 1.0


def test_a_straight_line_takes_the_textbook_s_time():
    limits = Limits(speed=0.5, acceleration=0.25)
    plan = plan_waypoints([[0, 0], [3, 0]], limits, 0.01, smoothing=0)
    assert plan.fastest == pytest.approx(3 / 0.5 + 0.5 / 0.25, rel=1e-3)
    assert plan.trajectory.t[-1] == pytest.approx(plan.fastest + 0.02, abs=0.011)
    torque = Limits(speed=0.5, wheel_torque=0.2)
    plan = plan_waypoints([[0, 0], [3, 0]], torque, 0.01, EDDIE, smoothing=0)
    a = 2 * 0.2 / (EDDIE.mass * EDDIE.wheel_radius)
    assert plan.fastest == pytest.approx(3 / 0.5 + 0.5 / a, rel=1e-3)
    short = plan_waypoints([[0, 0], [0.1, 0]], limits, 0.01, smoothing=0)
    assert short.fastest == pytest.approx(2 * np.sqrt(0.1 / 0.25), rel=1e-3)


def test_a_motor_s_torque_falls_with_speed():
    """Full voltage: v' = (2 tau0/(m r)) (1 - v/v0), whose distance over time is known."""
    limits = Limits(
        no_load_speed=10.0, wheel_torque=0.3, speed=0.5, deceleration=50, acceleration=50
    )
    plan = plan_waypoints([[0, 0], [20, 0]], limits, 0.02, EDDIE, smoothing=0)
    v0 = 10 * EDDIE.wheel_radius
    rate = 2 * 0.3 / (EDDIE.mass * EDDIE.wheel_radius) / v0
    until = -np.log(1 - 0.45 / v0) / rate
    covered = v0 * (until - (1 - np.exp(-rate * until)) / rate)
    k = np.searchsorted(plan.trajectory.v, 0.45)
    assert plan.trajectory.t[k] - 0.02 == pytest.approx(until, rel=0.03)  # a sample at rest first
    assert plan.trajectory.x[k] == pytest.approx(covered, rel=0.03)


def test_a_turn_on_the_spot():
    limits = Limits(speed=1, acceleration=1, turn_rate=1.0, turn_acceleration=2.0)
    plan = plan_waypoints([[0, 0], [1, 0], [0, 0]], limits, 0.01, smoothing=0)
    assert plan.stops == ((1, "corner of 3.14 rad"),)
    still = np.hypot(np.diff(plan.trajectory.x), np.diff(plan.trajectory.y)) < 1e-12
    assert still.sum() * 0.01 == pytest.approx(pi / 1.0 + 1.0 / 2.0, abs=0.05)
    assert abs(plan.trajectory.theta[-1]) == pytest.approx(pi, abs=1e-9)
    assert not plan.trajectory.reverse.any()


def test_reversing_keeps_the_heading():
    t = from_waypoints([[0, 0], [1, 0], [0, 0]], ALL, 0.02, EDDIE, reverse=[0, 1])
    np.testing.assert_allclose(t.theta, 0, atol=1e-12)
    assert t.reverse[-10]
    assert t.v.min() < -0.3
    assert t.v.max() > 0.3


def test_headings_are_kept():
    points = [[0, 0], [2, 1], [4, 0]]
    t = from_waypoints(points, ALL, 0.02, EDDIE, theta=[1.0, 0.2, -0.5])
    for point, heading in zip(points, [1.0, 0.2, -0.5], strict=True):
        k = np.argmin(np.hypot(t.x - point[0], t.y - point[1]))
        assert t.theta[k] == pytest.approx(heading, abs=0.05)
    off = plan_waypoints(points, ALL, 0.02, EDDIE, theta=[nan, 3.0, nan])
    assert off.stops[0][1] == "heading off the path"
    k = np.flatnonzero(np.abs(off.trajectory.theta - 3.0) < 1e-9)
    assert k.size
    np.testing.assert_allclose(off.trajectory.x[k], 2)


def test_dwell_and_speed():
    t = from_waypoints([[0, 0], [1, 0], [2, 0]], ALL, 0.02, EDDIE, dwell=[0, 0.5, 0])
    assert np.sum(np.abs(t.x - 1) < 1e-9) in range(25, 29)
    slow = from_waypoints([[0, 0], [2, 0], [4, 0]], ALL, 0.02, EDDIE, speed=[nan, 0.3, 0.3])
    assert np.abs(slow.v[slow.x > 2]).max() <= 0.3 + 1e-9
    assert slow.v.max() > 0.7


def test_speeds_may_be_lowered():
    wanted = [nan, 2.0, 0.3, nan]
    plan = plan_waypoints(SQUARE, ALL, 0.02, EDDIE, speed=wanted, lower_speeds=True)
    assert plan.trajectory.notes[1].startswith(
        "slower than asked at 1 points; most: speed[1] is 2 m/s; cannot be driven"
    )
    slower = from_waypoints(SQUARE, ALL, 0.02, EDDIE, speed=[nan, nan, 0.3, nan])
    assert plan.trajectory.t[-1] <= slower.t[-1] + 0.5
    assert max(plan.use.values()) <= 1 + 1e-9


def test_smoothed_torques_are_continuous():
    """What changes at once without smoothing changes in steps in proportion to 1/window."""
    jumps = []
    for smoothing in (0.0, 0.2, 0.4):
        t = from_waypoints(SQUARE, ALL, 0.01, EDDIE, closed=True, smoothing=smoothing)
        torque = Scenario(t, EDDIE, rng=0).reference[:, 5:7]
        jumps.append(np.abs(np.diff(torque, axis=0)).max())
    assert jumps[1] < jumps[0] / 5
    assert jumps[2] == pytest.approx(jumps[1] / 2, rel=0.05)


def test_closed_laps():
    one = plan_waypoints(SQUARE, ALL, 0.02, EDDIE, closed=True)
    two = plan_waypoints(np.vstack([SQUARE, SQUARE[:1]]), ALL, 0.02, EDDIE, closed=True, laps=2)
    assert one.stops == two.stops == ()
    assert two.length == pytest.approx(2 * one.length, rel=1e-6)
    assert two.fastest < 2 * one.fastest
    t = one.trajectory
    assert (t.x[0], t.y[0]) == pytest.approx((t.x[-1], t.y[-1]), abs=1e-9)
    assert t.theta[-1] - t.theta[0] == pytest.approx(2 * pi, abs=1e-6)


def test_far_points_are_moved():
    far = np.array([4.0e6, -1.0e6])
    near = from_waypoints(SQUARE, ALL, 0.02, EDDIE)
    t = from_waypoints(SQUARE + far, ALL, 0.02, EDDIE)
    assert t.origin == tuple(far)
    np.testing.assert_array_equal(t.x, near.x)
    assert near.origin == (0, 0)
    assert "moved by (-4e+06, 1e+06) m" in t.notes[1]
    again = Scenario.from_json(Scenario(t, rng=0).to_json()).trajectory
    assert again == t
    assert again.origin == t.origin
    assert again != near


def test_the_methods_are_the_functions():
    for name in ("from_waypoints", "from_states"):
        function = getattr(nfopidn.trajectories, name)
        text = getattr(Trajectory, name).__text_signature__
        shown = str(inspect.signature(function).replace(return_annotation=inspect.Signature.empty))
        bare = [
            p.replace(annotation=inspect.Parameter.empty)
            for p in inspect.signature(function).parameters.values()
        ]
        shown = str(inspect.Signature(bare))
        assert text == shown
    arguments = (SQUARE, ALL, 0.02, EDDIE)
    assert Trajectory.from_waypoints(*arguments) == from_waypoints(*arguments)


def test_a_curve_is_smooth_and_passes_its_points():
    points = np.cumsum(np.random.default_rng(5).normal(size=(9, 2)), axis=0)
    curve = fit_curve(points)
    np.testing.assert_allclose(curve(curve.u), points, atol=1e-12)
    for order in range(5):  # across the points
        left, right = curve(curve.u[1:-1] - 1e-9, order), curve(curve.u[1:-1] + 1e-9, order)
        np.testing.assert_allclose(left, right, atol=1e-4)
    near = fit_curve(points, tolerance=0.1)
    off = np.hypot(*(near(near.u) - points).T)
    assert 0.099 < off.max() <= 0.1
    assert off[0] < 1e-12
    assert off[-1] < 1e-12
    tangents = np.full((9, 2), nan)
    tangents[4] = [0.6, 0.8]
    d = fit_curve(points, tangents)(curve.u[[4]], 1)[0]
    np.testing.assert_allclose(d / np.hypot(*d), [0.6, 0.8], atol=1e-9)


def test_curvature_of_a_circle():
    angle = np.linspace(0, 2 * pi, 41)
    points = 2 * np.column_stack([np.cos(angle), np.sin(angle)])
    points[-1] = points[0]
    piece, _, kappa, change = measure(fit_curve(points, closed=True), False)
    assert piece.length == pytest.approx(4 * pi, rel=1e-6)
    np.testing.assert_allclose(kappa, 0.5, atol=1e-5)
    np.testing.assert_allclose(change, 0, atol=1e-3)


def test_the_time_is_toppra_s():
    """Within 3 % of TOPP-RA on the same path, grid and constraints, smoothing off."""
    pytest.importorskip("toppra").setup_logging("ERROR")
    duration = pytest.importorskip("toppra_yardstick").duration
    limits = Limits(
        speed=1.0,
        acceleration=0.8,
        lateral_acceleration=0.6,
        turn_rate=1.5,
        turn_acceleration=4.0,
        wheel_torque=0.6,
    )
    for seed in range(4):
        points = np.cumsum(np.random.default_rng(seed).normal(size=(6, 2)), axis=0)
        _, s, kappa, change = measure(fit_curve(points), False)
        motion = Motion(s, np.ones(len(s)), kappa, change, np.full(len(s), inf))
        own = times(motion, fastest(motion, limits, EDDIE))[-1]
        assert own == pytest.approx(duration(motion, limits, EDDIE), rel=0.03)


REFUSED = [
    ({"points": [[0, 0], [1, 0], [1, 0], [2, 0]]}, r"points\[1\] and points\[2\] are both at"),
    ({"points": [[0, 0], [1, nan]]}, r"points\[1\] is \(1, nan\); must be finite"),
    ({"points": [[0, 0, 1], [1, 0, 2]]}, r"points has shape \(2, 3\)"),
    ({"points": [[0, 0]]}, "points has 1 rows"),
    ({"points": [[0, 0], [2e9, 0]]}, r"points\[1\] is \(2e\+09, 0\); must be in"),
    ({"points": [[0, 0], [1, 0]], "closed": True}, "points has 2 places; a closed path"),
    ({"laps": 2}, "laps is 2; must be 1 for a path that is not closed"),
    ({"theta": [0, 1]}, r"theta has shape \(2,\); must have one number a point, 4"),
    ({"theta": [0, inf, 0, 0]}, r"theta\[1\] is inf"),
    ({"speed": [1, -1, 1, 1]}, r"speed\[1\] is -1; must be in \[0, 1e\+06\]"),
    (
        {"speed": [nan, 2, nan, nan]},
        r"speed\[1\] is 2 m/s; cannot be driven: at .* m along .*allows",
    ),
    ({"reverse": [0, 0.5, 0, 0]}, r"reverse\[1\] is 0\.5; must be 0 or 1"),
    ({"reverse": [0, 1]}, r"reverse has shape"),
    ({"dwell": [0, 0, 0, -1]}, r"dwell\[3\] is -1"),
    (
        {"corner": 1, "limits": Limits(speed=1, acceleration=1)},
        r"cannot be driven: at \(2, 0\) the robot turns on the spot by 1\.57 rad, and nothing",
    ),
    ({"dt": 0}, r"dt is 0; must be in"),
    ({"corner": 4}, r"corner is 4; must be in"),
    ({"tolerance": -1}, r"tolerance is -1"),
    ({"smoothing": -1}, r"smoothing is -1"),
    ({"limits": None}, "limits is None; must be a Limits"),
    ({"robot": None}, "robot is None; limits.wheel_speed is of a wheel and needs a Robot"),
    ({"robot": 3}, "robot is 3; must be a Robot"),
    ({"dwell": [0, 0, 0, 1e6], "dt": 1e-3}, "the motion takes .* samples of dt 0.001 s"),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED)
def test_bad_waypoints_are_refused(changes, message):
    arguments = {"points": SQUARE, "limits": ALL, "dt": 0.02, "robot": EDDIE} | changes
    with pytest.raises(ValueError, match=message):
        from_waypoints(**arguments)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"speed": 1}, "nothing limits the acceleration"),
        ({"acceleration": 1}, "nothing limits the speed"),
        ({"speed": 0, "acceleration": 1}, r"limits.speed is 0; must be in \[1e-06, inf\] m/s"),
        ({"speed": nan, "acceleration": 1}, r"limits.speed is nan"),
        ({"speed": 1, "acceleration": 1, "no_load_speed": 9}, "no_load_speed needs wheel_torque"),
        ({"speed": 1, "wheel_torque": 1, "coulomb_friction": 1}, "takes all of wheel_torque"),
        ({"speed": 1, "acceleration": 1, "viscous_friction": -1}, "limits.viscous_friction is -1"),
    ],
)
def test_bad_limits_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        Limits(**given)


def test_uses_tell_what_a_trajectory_asks():
    t = Trajectory.circle(period=10, dt=0.1, heading="continuous")
    found = {one.name: one for one in uses(t, Limits(speed=1, acceleration=1, turn_rate=1))}
    assert set(found) == {"speed", "acceleration", "deceleration", "turn_rate"}
    assert found["speed"].ratio.max() == pytest.approx(t.peak_speed, rel=1e-12)
