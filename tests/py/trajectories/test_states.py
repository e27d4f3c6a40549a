"""Logs of states: uneven and repeated stamps, headings, outliers, positions far away."""

from math import inf, nan, pi

import numpy as np
import pytest
from nfopidn import Trajectory
from nfopidn.trajectories import from_states

N = 200
DT = 0.05
EVEN = DT * np.arange(N)


def circle(t):
    angle = 0.4 * np.asarray(t)
    return 2 * np.cos(angle), 2 * np.sin(angle), angle + pi / 2


RNG = np.random.default_rng(3)
STAMPS = {
    "even": EVEN,
    "rounded to ms": np.round(EVEN * 1.0003, 3),
    "jittered by 10 %": EVEN + DT * RNG.uniform(-0.1, 0.1, N),
    "since the epoch": EVEN + 1.7e9,
    "gaps": np.delete(EVEN, [20, 21, 22, 80]),
}


@pytest.mark.parametrize("name", STAMPS)
def test_stamps_are_resampled(name):
    stamps = STAMPS[name]
    since = stamps - (stamps[0] if stamps[0] > 1e9 else 0)
    made = from_states(stamps, *circle(since), dt=DT)
    x, y, theta = circle(made.t + since[0])
    np.testing.assert_allclose(made.x, x, atol=6e-4)
    np.testing.assert_allclose(made.y, y, atol=6e-4)
    np.testing.assert_allclose(made.theta, theta, atol=1e-6)
    np.testing.assert_allclose(made.v[2:-2], 0.8, rtol=0.01)
    error = next(note for note in made.notes if note.startswith("error of resampling"))
    told = float(error.split("at most ")[1].split(" m")[0])
    assert np.hypot(made.x - x, made.y - y).max() <= told * 1.01 + 1e-9


def test_the_step_is_the_median_of_the_stamps():
    made = from_states(STAMPS["gaps"], *circle(STAMPS["gaps"]))
    assert made.dt == pytest.approx(DT)
    assert made.notes[0] == "dt is 0.05 s, the median step of the stamps"
    assert made.notes[1] == "stamps are 0.05 to 0.2 s apart; resampled to 0.05 s"
    assert Trajectory.from_states(STAMPS["gaps"], *circle(STAMPS["gaps"])) == made


def test_repeated_stamps_are_averaged():
    stamps = np.repeat(EVEN, 2)
    x, y, theta = circle(stamps)
    x[1::2] += 0.002
    made = from_states(stamps, x, y, theta)
    assert made.notes[0].startswith(
        "200 of 400 stamps repeat the one before; the mean of their samples is taken (at most "
        "0.002 m apart, at t["
    )
    np.testing.assert_allclose(made.x, circle(EVEN)[0] + 0.001, atol=1e-9)


def test_reversing_and_turning_keep_their_meaning():
    """Ahead, a half turn on the spot, and on in reverse: the motion's direction never changes."""
    t = np.arange(301) * 0.02
    x = np.interp(t, [0, 2, 4, 6], [0, 1, 1, 2])
    theta = np.interp(t, [0, 2, 4, 6], [0, 0, pi, pi])
    v = np.where(t < 2, 0.5, np.where(t <= 4, 0, -0.5))
    omega = np.where((t > 2) & (t < 4), pi / 2, 0)
    y = np.zeros(len(t))
    given = from_states(t, x, y, theta, dt=0.02)
    derived = from_states(t, x, y, v=v, omega=omega, dt=0.02)
    for made in (given, derived):
        assert made.v[50] == pytest.approx(0.5)
        assert made.v[250] == pytest.approx(-0.5)
        assert made.reverse[250]
        assert not made.reverse[50]
        assert made.omega[150] == pytest.approx(pi / 2, rel=0.02)
        assert made.theta[-1] == pytest.approx(pi, abs=0.05)
    blind = from_states(t, x, y, dt=0.02, standstill_speed=0.01)
    assert not blind.reverse.any()
    assert "nothing tells reversing from it" in blind.notes[-1]


@pytest.mark.parametrize("k", [0, 1, 77, N - 1])
def test_outliers_are_named(k):
    x, y, theta = circle(EVEN)
    x[k] += 3
    with pytest.raises(ValueError, match=rf"sample {k} is an outlier: .* m from its neigh.* m/s"):
        from_states(EVEN, x, y, theta)


def test_jumps_are_named():
    x, y, theta = circle(EVEN)
    x[100:] += 5
    with pytest.raises(ValueError, match=r"sample 100 is an outlier: the position jumps by 4\.963"):
        from_states(EVEN, x, y, theta)
    made = from_states(EVEN[:100], x[:100], y[:100], theta[:100])
    assert len(made) == 100


def test_a_speed_limit_is_kept():
    with pytest.raises(
        ValueError, match=r"sample 1 lies .* a speed of 0\.8 m/s; speed_limit is 0.7"
    ):
        from_states(EVEN, *circle(EVEN), speed_limit=0.7)
    assert from_states(EVEN, *circle(EVEN), speed_limit=0.9)


def test_starts_and_stops_are_no_outliers():
    t = 0.05 * np.arange(120)
    x = np.where(t < 2, 0, np.minimum(1.0, t - 2))
    made = from_states(t, x, 0 * t, 0 * t)
    assert made.peak_speed == pytest.approx(1.0, rel=1e-6)


def test_far_positions_are_moved():
    x, y, theta = circle(EVEN)
    made = from_states(EVEN, x + 5e6, y - 1e6, theta, dt=DT)
    assert made.origin == (5000002.0, -1e6)
    np.testing.assert_allclose(made.x + made.origin[0], x + 5e6, atol=1e-8)
    assert "moved by (-5e+06, 1e+06) m" in made.notes[0]


def test_given_speeds_are_compared():
    x, y, theta = circle(EVEN)
    made = from_states(EVEN, x, y, theta, np.full(N, 0.7), np.full(N, 0.4), dt=DT)
    assert made.notes[-2].startswith("v is that of the positions, 0.0999")
    assert made.notes[-1].startswith("omega is that of the headings, ")


FLIPPED = circle(EVEN)[2].copy()
FLIPPED[50:] += pi
BACK = EVEN.copy()
BACK[60] -= 0.2
REFUSED = [
    ({"t": BACK}, r"t\[60\] is 2\.8.* s, before t\[59\].*two clocks"),
    ({"t": np.zeros(N)}, "t has 1 different stamps; a trajectory needs 3"),
    ({"t": EVEN[:-1]}, r"x has 200 numbers; must have as many as t, 199"),
    ({"t": 1.7e18 + 1e9 * EVEN}, r"t\[0\] is 1\.7e\+18; must be in s"),
    ({"t": np.where(np.arange(N) == 3, nan, EVEN)}, r"t\[3\] is nan; must be finite"),
    ({"x": np.where(np.arange(N) == 3, inf, 0)}, r"x\[3\] is inf; must be finite"),
    ({"x": None}, "x is None; must be"),
    ({"y": np.zeros((N, 2))}, "y has 2 dimensions"),
    ({"theta": FLIPPED}, r"sample 50 is an outlier: the heading turns by 3\.1"),
    ({"dt": 0}, r"dt is 0; must be in"),
    ({"dt": 100}, r"dt is 100 s; the stamps last 9\.95 s"),
    ({"speed_limit": 0}, r"speed_limit is 0; must be in"),
    ({"theta": None, "v": np.zeros(N)}, "v: the robot never moves faster than 0.001 m/s"),
]


@pytest.mark.parametrize(("changes", "message"), REFUSED)
def test_bad_states_are_refused(changes, message):
    x, y, theta = circle(EVEN)
    with pytest.raises(ValueError, match=message):
        from_states(**({"t": EVEN, "x": x, "y": y, "theta": theta} | changes))
