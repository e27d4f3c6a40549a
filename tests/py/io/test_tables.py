"""Tables as people have them: what is read from which column, and what a path's times are."""

import json
import pickle

import nfopidn
import numpy as np
import pytest
from conftest import GOLDEN
from nfopidn import Controller, Scenario, Trajectory

X, Y = [0.0, 1.0, 2.0, 2.5], [0.0, 0.5, 2.0, 4.0]
EXPECTED = Trajectory.from_samples(X, Y, 0.5)
TIMES = [0.0, 0.5, 1.0, 1.5]


def rows(separator, *columns):
    return "".join(separator.join(map(str, row)) + "\n" for row in zip(*columns, strict=True))


def table(header, separator=",", *, begin="", columns=(TIMES, X, Y), end=""):
    return begin + header + "\n" + rows(separator, *columns) + end


MILLISECONDS = [int(1000 * t) for t in TIMES]
DIALECTS = {
    "plain": table("t,x,y"),
    "numpy's comment": table("# t,x,y"),
    "blanks": table("t x y", " "),
    "aligned": "   t    x    y\n" + rows("     ", TIMES, X, Y).replace("0.0", "  0.0"),
    "semicolons": table("time;x_m;y_m", ";"),
    "tabs and quotes": table('"timestamp"\t"x"\t"y"', "\t"),
    "racelines": table(
        "s_m; t_s; x_m; y_m", "; ", begin="# made by hand\n# ", columns=(X, TIMES, X, Y)
    ),
    "pandas": table(",stamp,x,y", columns=(range(4), TIMES, X, Y)),
    "upper case": table("T,X,Y"),
    "units": table("t [s], x [m], y [m]"),
    "other units": table(
        "t (ms),x (cm),y_mm", columns=(MILLISECONDS, [100 * x for x in X], [1000 * y for y in Y])
    ),
    "texts, gaps and NaN elsewhere": table(
        "name,t,x,speed,y", columns=("abcd", TIMES, X, ["", "nan", "-", "1"], Y)
    ),
    "names with separators": table('t,"a,b",x,y', columns=(TIMES, ['"1,2"'] * 4, X, Y)),
    "ends in separators": "t,x,y,\n" + rows(",", TIMES, X, Y, [""] * 4),
    "only rows end in separators": "t,x,y\n" + rows(",", TIMES, X, Y, [""] * 4),
    "comments between": table("t,x,y", end="# the end\n").replace(
        "1.0,2.0", "# half\n% way\n1.0,2.0"
    ),
    "old Mac": table("t,x,y").replace("\n", "\r"),
    "Windows": table("t,x,y").replace("\n", "\r\n"),
    "TUM": table("timestamp tx ty tz", " ", begin="# ", columns=(TIMES, X, Y, X)),
    "signs": table("t,x,y").replace("1.0,2.0", "+1.0,+2.0e0"),
    "epoch": table("t,x,y", columns=([1.7e9 + t for t in TIMES], X, Y)),
    "other x": table("t,x_ref,x,y_ref,y", columns=(TIMES, Y, X, X, Y)),
}


@pytest.mark.parametrize("name", DIALECTS)
@pytest.mark.parametrize("file", ["path.csv", "path.txt", "PATH.CSV", "path.tum", "path"])
def test_dialects(name, file, sim, tmp_path):
    path = tmp_path / file
    path.write_text(DIALECTS[name], newline="")
    loaded = Trajectory.from_csv(path)
    assert loaded.dt == pytest.approx(0.5, rel=1e-12)
    for member in ("x", "y", "theta", "v"):
        np.testing.assert_allclose(getattr(loaded, member), getattr(EXPECTED, member), rtol=1e-12)
    if file == "path.csv":
        return
    saved = tmp_path / "scenario.json"
    run = sim("--traj", file, "--save-scenario", saved, "--json", cwd=tmp_path)
    assert run.returncode in (0, 3), run.stderr
    assert Scenario.load(saved).trajectory == loaded
    assert run.stderr == f"nfopidn_sim: {loaded.notes[0].replace(str(path), file)}\n"


@pytest.mark.parametrize(
    ("name", "note"),
    [
        ("plain", "t from column t, x from column x, y from column y"),
        (
            "texts, gaps and NaN elsewhere",
            "t from column t, x from column x, y from column y; not used: name, speed",
        ),
        ("pandas", "t from column stamp, x from column x, y from column y; not used: (no name)"),
    ],
)
def test_every_columns_use_is_said(name, note, tmp_path):
    path = tmp_path / "path.csv"
    path.write_text(DIALECTS[name])
    assert Trajectory.from_csv(path).notes == (f"{path}: {note}",)
    assert Trajectory.circle().notes == EXPECTED.notes == ()


def test_without_times_the_step_is_asked_for(sim, tmp_path):
    path = tmp_path / "path.csv"
    path.write_text(rows(",", ["x", *X], ["y", *Y]))
    with pytest.raises(ValueError, match=r"path.csv:1: no column of times .* give dt.*are x, y"):
        Trajectory.from_csv(path)
    assert Trajectory.from_csv(path, dt=0.5) == EXPECTED
    assert sim("--traj", path).returncode == 2
    assert sim("--traj", path, "--dt", "0.5", "--quiet").returncode in (0, 3)


RATE = 30
COUNT = 200
ROUNDED = {
    "milliseconds": [f"{k / RATE:.3f}" for k in range(COUNT)],
    "cut off": [f"{int(1000 * k / RATE) / 1000:.3f}" for k in range(COUNT)],
    "milliseconds without zeros": [f"{round(k / RATE, 3):g}" for k in range(COUNT)],
    "unix epoch": [f"{1700000000 + k / RATE:.3f}" for k in range(COUNT)],
    "unix epoch in full": [repr(1700000000.123 + k / RATE) for k in range(COUNT)],
    "nanoseconds": [str(1700000000 * 10**9 + round(k * 1e9 / RATE)) for k in range(COUNT)],
    "exponents": [f"{k / RATE:.6e}" for k in range(COUNT)],
}


@pytest.mark.parametrize("name", ROUNDED)
def test_times_are_equal_steps_to_within_their_text(name, sim, tmp_path):
    path = tmp_path / "log.csv"
    angle = np.linspace(0, 3, COUNT)
    unit = "t_ns" if name == "nanoseconds" else "t"
    path.write_text(f"{unit},x,y\n" + rows(",", ROUNDED[name], np.cos(angle), np.sin(angle)))
    assert Trajectory.from_csv(path).dt == pytest.approx(1 / RATE, rel=2e-4)
    known = Trajectory.from_csv(path, dt=1 / RATE)
    assert known == Trajectory.from_samples(np.cos(angle), np.sin(angle), 1 / RATE)
    assert sim("--traj", path, "--dt", repr(1 / RATE), "--quiet").returncode in (0, 3)
    with pytest.raises(ValueError, match=r"equal steps of the dt given, 0\.033 s: this stamp is"):
        Trajectory.from_csv(path, dt=0.033)


@pytest.mark.parametrize(
    "stamps",
    [
        [0, 1, 2, 3.02, 4, 5],  # one late
        [0, 1, 2, 4, 5, 6],  # one missing
        [*np.cumsum([0] + [1.0005**k for k in range(200)])],  # drifts, a little each
    ],
)
def test_uneven_times_are_refused(stamps, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text("t,x,y\n" + rows(",", stamps, stamps, stamps))
    with pytest.raises(ValueError, match=r"log.csv:\d+: column t does not rise in equal steps"):
        Trajectory.from_csv(path)


def test_headings_and_directions_of_a_table(sim, tmp_path):
    """A robot that backs off: without its heading it would be turned by half a turn."""
    path, saved = tmp_path / "path.csv", tmp_path / "scenario.json"
    x = [-0.1 * k for k in range(8)]
    times = [0.1 * k for k in range(8)]
    path.write_text("t,x,y,yaw_deg\n" + rows(",", times, x, [0] * 8, [0] * 8))
    given = Trajectory.from_csv(path)
    assert np.array_equal(given.theta, np.zeros(8))
    np.testing.assert_allclose(given.v, -1, rtol=1e-12)
    assert given.reverse.all()
    assert "theta from column yaw_deg" in given.notes[0]
    sim("--traj", path, "--save-scenario", saved, "--quiet")
    assert Scenario.load(saved).trajectory == given
    turned = Trajectory.from_csv(path, heading="forward")
    np.testing.assert_allclose(np.abs(turned.theta), np.pi)
    assert "not used: yaw_deg" in turned.notes[0]
    sim("--traj", path, "--heading", "forward", "--save-scenario", saved, "--quiet")
    assert Scenario.load(saved).trajectory == turned
    path.write_text("t,x,y,reverse\n" + rows(",", times, x, [0] * 8, [1] * 8))
    np.testing.assert_allclose(Trajectory.from_csv(path).v, -1, rtol=1e-12)


def test_a_given_heading_is_part_of_the_value(tmp_path):
    angle = np.linspace(0, 2 * np.pi, 60)
    x, y = np.cos(angle), np.sin(angle)
    path = Trajectory.from_samples(x, y, 0.1, laps=2, theta=angle - np.pi / 2, reverse=[True] * 60)
    assert np.all(path.v[1:-1] < 0)
    assert path.reverse.all()
    np.testing.assert_allclose(np.diff(path.theta), 2 * np.pi / 59, rtol=1e-9)
    assert pickle.loads(pickle.dumps(path)) == path
    assert path != Trajectory.from_samples(x, y, 0.1, laps=2)
    scenario = Scenario(path, rng=0)
    scenario.save(tmp_path / "s.json")
    again = Scenario.load(tmp_path / "s.json")
    assert again == scenario
    for member in ("theta", "v", "omega", "acceleration", "turn_acceleration", "reverse"):
        assert np.array_equal(getattr(again.trajectory, member), getattr(path, member)), member
    with pytest.raises(ValueError, match="reverse contradicts theta"):
        Trajectory.from_samples(x, y, 0.1, theta=angle - np.pi / 2, reverse=[False] * 60)
    for name, value in (("theta", [0.0]), ("reverse", [True])):
        with pytest.raises(ValueError, match=f"{name} has 1 numbers; must have as many as x, 60"):
            Trajectory.from_samples(x, y, 0.1, **{name: value})
    with pytest.raises(ValueError, match=r"reverse\[0\] is 2; must be 0 or 1"):
        Trajectory.from_samples(x, y, 0.1, reverse=[2] * 60)
    with pytest.raises(ValueError, match=r"theta\[0\] is nan"):
        Trajectory.from_samples(x, y, 0.1, theta=[np.nan] * 60)


def test_a_closed_path_need_not_say_its_first_point_twice(sim, tmp_path):
    angle = np.linspace(0, 2 * np.pi, 61)
    x, y = np.cos(angle), np.sin(angle)
    x[-1], y[-1] = x[0], y[0]
    expected = Trajectory.from_samples(x, y, 0.1, laps=2)
    for count in (60, 61):  # with the last point there already nothing is added
        assert Trajectory.from_samples(x[:count], y[:count], 0.1, laps=2, closed=True) == expected
    path, saved = tmp_path / "lap.csv", tmp_path / "scenario.json"
    path.write_text("x,y\n" + rows(",", x[:60].tolist(), y[:60].tolist()))
    assert Trajectory.from_csv(path, laps=2, dt=0.1, closed=True) == expected
    run = sim(
        *("--traj", path, "--dt", "0.1", "--laps", "2", "--closed", "--quiet"),
        *("--save-scenario", saved),
    )
    assert run.returncode in (0, 3)
    assert Scenario.load(saved).trajectory == expected
    with pytest.raises(ValueError, match="laps is 2; must be 1"):
        Trajectory.from_csv(path, laps=2, dt=0.1)


def noisy_standstill(noise=1e-9):
    way = np.concatenate([np.zeros(50), 0.05 * np.arange(50)])
    draw = np.random.default_rng(0)
    return (
        np.cos(0.7) * way + noise * draw.normal(size=100),
        np.sin(0.7) * way + noise * draw.normal(size=100),
    )


def test_a_standstill_is_told_from_motion(tmp_path, sim):
    """A nanometre of noise would turn the reference by 20 rad and more."""
    x, y = noisy_standstill()
    with pytest.warns(
        UserWarning, match=r"heading holds at \d+ of 100 samples, slower than"
    ) as said:
        path = Trajectory.from_samples(x, y, 0.2)
    assert said[0].filename == __file__
    assert np.ptp(path.theta) < 1e-6
    reference = Scenario(path, rng=0).reference
    assert np.abs(reference[:48, 5:7]).max() < 1e-5
    spun = Trajectory.from_samples(x, y, 0.2, standstill_speed=0)
    assert np.ptp(spun.theta) > 6
    chosen = Trajectory.from_samples(x, y, 0.2, standstill_speed=0.01)  # silent: it was asked for
    assert (chosen.standstill_speed, path.standstill_speed) == (0.01, None)
    for one in (path, spun, chosen):
        assert pickle.loads(pickle.dumps(one)) == one
        np.testing.assert_array_equal(pickle.loads(pickle.dumps(one)).theta, one.theta)
    file = tmp_path / "log.csv"
    file.write_text("x,y\n" + rows(",", x.tolist(), y.tolist()))
    run = sim("--traj", file, "--dt", "0.2", "--json")
    assert "the heading holds at" in run.stderr
    assert (
        "the heading holds"
        not in sim("--traj", file, "--dt", "0.2", "--json", "--standstill-speed", "0.01").stderr
    )
    with pytest.raises(ValueError, match=r"standstill_speed is -1; must be in \[0, 1000\] m/s"):
        Trajectory.from_samples(x, y, 0.2, standstill_speed=-1)


def test_what_is_no_array_of_real_numbers():
    masked = np.ma.masked_array([0.0, 1, 2], mask=[False, True, False])
    reference = Scenario.published(rng=0).reference
    for call, name in [
        (lambda bad: Trajectory.from_samples(bad, [0, 1, 3], 0.1), "x"),
        (lambda bad: Trajectory.from_samples([0, 1, 3], bad, 0.1), "y"),
        (lambda bad: Trajectory.from_samples([0, 1, 3], [0, 1, 3], 0.1, theta=bad), "theta"),
        (lambda bad: Controller.published().step(bad, reference[0]), "measurement"),
        (Controller.from_vector, "x"),
    ]:
        with pytest.raises(ValueError, match=rf"{name}\[1\] is masked; must be a number"):
            call(masked)
        for bad in (np.array([0j, 1, 2]), [0, 1j, 2]):
            with pytest.raises(ValueError, match=rf"{name} is complex; must be real numbers"):
                call(bad)
        with pytest.raises(TypeError, match=f"{name} must be an array of numbers"):
            call(["0", "1", "2"])
    unmasked = np.ma.masked_array([0.0, 1, 3])
    assert Trajectory.from_samples(unmasked, unmasked, 0.1).x.tolist() == [0, 1, 3]


@pytest.mark.parametrize("memory", [5, 2000])
def test_a_copy_may_go_on_where_the_controller_is(memory, published):
    controller = Controller.published(memory, form="incremental", sigma=0.5)
    reference = published.scenario.reference
    for k in range(20):
        controller.step(published.pose[k], reference[k])
    twin, afresh = controller.copy(state=True), controller.copy()
    assert twin == afresh == controller
    assert twin.feedback() == controller.feedback() != afresh.feedback()
    for k in range(20, 30):
        expected = controller.step(published.pose[k], reference[k])
        assert twin.step(published.pose[k], reference[k]) == expected
    twin.reset()
    assert controller.feedback() != (0, 0)
    first = published.pose[0], reference[0]
    assert afresh.step(*first) == twin.step(*first)


def test_a_disturbance_may_have_times_and_units(sim, tmp_path):
    pairs = np.random.default_rng(2).normal(size=(751, 2))
    path = tmp_path / "wind.txt"
    times = [f"{0.2 * k:.1f}" for k in range(751)]
    path.write_text("time;force [N];moment [N m];note\n" + rows(";", times, *pairs.T, ["a"] * 751))
    run = sim("--disturbance", path, "--json")
    expected = nfopidn.simulate(Scenario.published(disturbance=pairs, rng=0))
    assert json.loads(run.stdout)["cost"] == expected.cost


def test_a_file_may_not_hide_a_path_of_that_name(sim, tmp_path):
    (tmp_path / "circle").write_text(DIALECTS["plain"])
    (tmp_path / "square").write_text(DIALECTS["plain"])
    assert sim("--traj", "circle", cwd=tmp_path).stdout.startswith("circle, 751 samples")
    for name in ("./circle", "square"):
        assert sim("--traj", name, cwd=tmp_path).stdout.startswith("samples, 4 samples")


def test_the_golden_run_reads_back():
    path = Trajectory.from_csv(GOLDEN / "published_run.csv", heading="forward")
    assert (len(path), path.dt) == (751, pytest.approx(0.2, rel=1e-12))
