"""Tables, TUM files, FIRST's JSON: what is read, what is refused and what is said."""

import json
from math import pi

import nfopidn
import numpy as np
import pytest
from nfopidn import Robot, Scenario, Trajectory, formats, simulate
from nfopidn.trajectories import Limits, from_waypoints

COUNT = 41
T = np.arange(COUNT) * 0.1
ANGLE = 0.5 * T
X, Y = 2 * np.cos(ANGLE), 2 * np.sin(ANGLE)
THETA = ANGLE + pi / 2


def table(names, *columns, separator=",", before="", quote=""):
    head = separator.join(f"{quote}{name}{quote}" for name in names)
    rows = [separator.join(f"{float(v):.12g}" for v in row) for row in zip(*columns, strict=True)]
    return before + head + "\n" + "\n".join(rows) + "\n"


KAPPA = np.full(COUNT, 0.5)
ZERO = np.zeros(COUNT)
# Made by ourselves, with the headers and separators of files from public repositories.
DIALECTS = {
    "plain": table(["t", "x", "y", "theta"], T, X, Y, THETA),
    "semicolons": table(["t", "x", "y", "theta"], T, X, Y, THETA, separator=";"),
    "semicolons and blanks": table(["t", "x", "y", "theta"], T, X, Y, THETA, separator="; "),
    "tabs": table(["t", "x", "y", "theta"], T, X, Y, THETA, separator="\t"),
    "blanks": table(["t", "x", "y", "theta"], T, X, Y, THETA, separator="  "),
    "NumPy": table(["t", "x", "y", "theta"], T, X, Y, THETA, before="# "),
    "MATLAB": table(["t", "x", "y", "theta"], T, X, Y, THETA, before="% "),
    "quoted": table(["t", "x", "y", "theta"], T, X, Y, THETA, quote='"'),
    "units in brackets": table(["t [s]", "x [m]", "y [m]", "theta [rad]"], T, X, Y, THETA),
    "units in parentheses": table(["t (s)", "x (m)", "y (m)", "yaw (rad)"], T, X, Y, THETA),
    "units behind": table(["t_s", "x_m", "y_m", "theta_rad"], T, X, Y, THETA),
    "degrees": table(["t", "x", "y", "yaw_deg"], T, X, Y, np.degrees(THETA)),
    "millimetres": table(["t_ms", "x_mm", "y_mm", "yaw"], 1e3 * T, 1e3 * X, 1e3 * Y, THETA),
    "upper case": table(["TIME", "X", "Y", "YAW"], T, X, Y, THETA),
    "timestamps": table(["timestamp", "x", "y", "yaw"], T + 1.7e9, X, Y, THETA),
    "pandas": table(["", "time", "x", "y", "yaw"], range(COUNT), T, X, Y, THETA),
    "positions": table(["stamp", "pos_x", "pos_y", "theta"], T, X, Y, THETA),
    "Windows": table(["t", "x", "y", "theta"], T, X, Y, THETA).replace("\n", "\r\n"),
    "byte order mark": "\ufeff" + table(["t", "x", "y", "theta"], T, X, Y, THETA),
    "comments": table(["t", "x", "y", "theta"], T, X, Y, THETA, before="# by hand\n#\n"),
    "order": table(["theta", "y", "t", "x", "z"], THETA, Y, T, X, ZERO),
}


@pytest.mark.parametrize("name", DIALECTS)
def test_tables(name, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(DIALECTS[name], newline="", encoding="utf-8")
    log = formats.read_csv(path)
    np.testing.assert_allclose(log.t, T, atol=1e-6)
    for member, wanted in (("x", X), ("y", Y), ("theta", THETA)):
        np.testing.assert_allclose(getattr(log, member), wanted, atol=1e-9)
    made = log.trajectory(dt=0.1)
    assert len(made) == COUNT
    np.testing.assert_allclose(made.x, X, atol=1e-6)
    assert made.notes[0].startswith(f"{path}: t from column")


def test_a_raceline(tmp_path):
    """As f1tenth's and TUMFTM's: psi is not taken, as its zero differs; vx has its unit."""
    names = ["s_m", "x_m", "y_m", "psi_rad", "kappa_radpm", "vx_mps", "ax_mps2"]
    path = tmp_path / "raceline.csv"
    before = "# 7b0f\n# 1a2b\n# "
    text = table(
        names, 2 * ANGLE, X, Y, ANGLE, KAPPA, ZERO + 3, ZERO, separator="; ", before=before
    )
    path.write_text(text)
    log = formats.read_csv(path)
    assert log.t is None
    assert log.theta is None
    assert set(log.v) == {3.0}
    assert "psi_rad (TUMFTM's programs count it from the y axis" in log.notes[1]
    with pytest.raises(ValueError, match=r"raceline.csv: no times; Trajectory.from_waypoints"):
        log.trajectory()
    made = from_waypoints(log.points, Limits(speed=1, acceleration=1), 0.05, speed=log.v / 3)
    assert made.peak_speed == pytest.approx(1, rel=1e-3)
    taken = formats.read_csv(path, columns={"theta": "psi_rad"})
    np.testing.assert_allclose(taken.theta, ANGLE)


def test_autoware_waypoints(tmp_path):
    """Degrees without a unit, and km/h, are not taken for radians and m/s."""
    names = ["x", "y", "z", "yaw", "velocity", "change_flag"]
    path = tmp_path / "waypoints.csv"
    yaw = np.degrees((THETA + pi) % (2 * pi) - pi)
    path.write_text(table(names, X, Y, ZERO, yaw, ZERO + 36, ZERO))
    with pytest.raises(
        ValueError, match=r"column yaw reaches .* no unit; units=\{'theta': 'deg'\}"
    ):
        formats.read_csv(path)
    log = formats.read_csv(path, units={"theta": "deg"})
    np.testing.assert_allclose(np.unwrap(log.theta), THETA, atol=1e-9)
    assert log.v is None
    assert "velocity (its name has no unit, and Autoware.ai writes km/h" in " ".join(log.notes)
    fast = formats.read_csv(path, columns={"v": "velocity"}, units={"v": "km/h", "theta": "deg"})
    assert set(fast.v) == {10.0}


def test_a_left_handed_yaw_is_refused(tmp_path):
    """As CARLA's: clockwise."""
    path = tmp_path / "carla.csv"
    path.write_text(table(["x", "y", "yaw"], X, Y, -THETA))
    with pytest.raises(ValueError, match=r"column yaw is .* rad off the direction of motion"):
        formats.read_csv(path)
    assert formats.read_csv(path, columns={"theta": "yaw"}).theta[0] == pytest.approx(-THETA[0])


REFUSED = [
    ("a,b\n1,2\n", {}, r"no column x nor y; the columns are a, b"),
    ("t,x,y\n0,1,2\n0,one,2\n", {}, r"log.csv:3: 'one' in column x is no finite number"),
    ("t,x,y\n0,1,nan\n", {}, r"log.csv:2: 'nan' in column y"),
    ("t,x,y\n", {}, "no rows; the columns are t, x, y"),
    ("t,x,y,z\n0,1,2,3\n", {"columns": {"x": "q"}}, r"columns\['x'\] is 'q'.*no column"),
    ("t,x,y,z\n0,1,2,3\n", {"columns": {"xx": "x"}}, r"columns has 'xx'"),
    ("t,x,y,z\n0,1,2,3\n", {"columns": {"x": 4}}, r"columns\['x'\] is 4; the table has 4"),
    ("t,x,y,z\n0,1,2,3\n", {"units": {"x": "rad"}}, r"units\['x'\] is 'rad'; must be one of m"),
    ("t,x,y,z\n0,1,2,3\n", {"units": {"q": "m"}}, r"units has 'q'"),
    ("time,stamp,x,y\n0,0,1,2\n", {}, "columns time and stamp both stand for t"),
    ("t,x,y,reverse\n0,1,2,7\n", {}, r"reverse\[0\] is 7; must be 0 or 1"),
]


@pytest.mark.parametrize(("text", "arguments", "message"), REFUSED)
def test_bad_tables_are_refused(text, arguments, message, tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        formats.read_csv(path, **arguments)


def test_columns_are_named(tmp_path):
    path = tmp_path / "log.csv"
    path.write_text(table(["when", "east", "north", "note"], 1000 * T, 100 * X, 100 * Y, ZERO))
    log = formats.read_csv(
        path, {"t": "when", "x": "east", "y": 2}, units={"t": "ms", "x": "cm", "y": "cm"}
    )
    np.testing.assert_allclose(log.t, T, atol=1e-12)
    np.testing.assert_allclose(log.x, X, atol=1e-9)
    assert log.notes[0].endswith(
        "t from column when (ms), x from column east (cm), y from column north (cm)"
    )
    assert log.notes[1] == "not used: note"


def test_nanoseconds_since_the_epoch_keep_their_digits(tmp_path):
    path = tmp_path / "log.csv"
    stamps = [1_700_000_000_000_000_001 + 50_000_000 * k for k in range(4)]
    path.write_text("stamp_ns,x,y\n" + "".join(f"{s},{k},0\n" for k, s in enumerate(stamps)))
    np.testing.assert_allclose(np.diff(formats.read_csv(path).t), 0.05, atol=3e-7)


def quaternion_rows(order):
    half = THETA / 2
    parts = {"x": ZERO, "y": ZERO, "z": np.sin(half), "w": np.cos(half)}
    return np.column_stack([T + 1.3e9, X, Y, ZERO, *(parts[name] for name in order)])


def test_tum(tmp_path):
    path = tmp_path / "log.tum"
    np.savetxt(path, quaternion_rows("xyzw"), fmt="%.9f", header="timestamp tx ty tz qx qy qz qw")
    log = formats.read_tum(path)
    assert log.start == 1.3e9
    np.testing.assert_allclose(np.unwrap(log.theta), THETA, atol=1e-6)
    np.testing.assert_allclose(log.t, T, atol=1e-6)
    np.savetxt(path, quaternion_rows("wxyz"), fmt="%.9f")
    with pytest.raises(ValueError, match=r"sample 0 lies on its side.*w first\?"):
        formats.read_tum(path)
    for text, message in [
        ("0 0 0 0 0 0 0\n", "log.tum:1: 7 numbers"),
        ("0 0 0 0 0 0 0 0\n", r"quaternion of sample 0, .* is 0 long; must be 1"),
        ("a 0 0 0 0 0 0 1\n", "log.tum:1: 'a 0"),
        ("nan 0 0 0 0 0 0 1\n", "log.tum:1: .*not finite"),
        ("# nothing\n", "no poses"),
        ("1700000000000000000 0 0 0 0 0 0 1\n", "a TUM file's are seconds"),
    ]:
        path.write_text(text)
        with pytest.raises(ValueError, match=message):
            formats.read_tum(path)


def a_run():
    path = Trajectory.eight(period=20, dt=0.1)
    far = Trajectory.from_samples(path.x, path.y, 0.1, origin=(3e5, -2e6))
    return simulate(Scenario(far, rng=0))


def test_evo_scores_a_run_as_we_do(tmp_path):
    evo = pytest.importorskip("evo.tools.file_interface")
    metrics = pytest.importorskip("evo.core.metrics")
    run = a_run()
    formats.write_tum(run, tmp_path / "run.tum", start=1.7e9)
    formats.write_tum(run, tmp_path / "reference.tum", reference=True, start=1.7e9)
    read = [evo.read_tum_trajectory_file(str(tmp_path / f"{n}.tum")) for n in ("reference", "run")]
    error = metrics.APE(metrics.PoseRelation.translation_part)
    error.process_data(read)
    rms = error.get_statistic(metrics.StatisticsType.rmse)
    assert rms == pytest.approx(run.metrics["position_rms"], rel=1e-7)
    angle = metrics.APE(metrics.PoseRelation.rotation_angle_rad)
    angle.process_data(read)
    heading = angle.get_statistic(metrics.StatisticsType.rmse)
    assert heading == pytest.approx(run.metrics["heading_rms"], rel=1e-6)


def test_tum_comes_back(tmp_path):
    run = a_run()
    formats.write_tum(run, tmp_path / "run.tum")
    log = formats.read_tum(tmp_path / "run.tum")
    np.testing.assert_allclose(log.x, run.columns["x"] + 3e5, rtol=1e-15)
    made = log.trajectory(dt=0.1)
    assert made.origin == (round(log.x[0]), round(log.y[0]))
    np.testing.assert_allclose(made.x + made.origin[0], log.x, atol=1e-6)


def backing():
    """Out and back in reverse, without a turn on the spot."""
    limits = Limits(speed=0.5, acceleration=0.5)
    return from_waypoints([[0, 0], [1, 0.2], [0, 0]], limits, 0.02, reverse=[0, 1], corner=3.1)


def test_pathweaver_comes_back(tmp_path):
    given = Trajectory.eight(period=30, dt=0.1)
    path = tmp_path / "eight.wpilib.json"
    formats.write_pathweaver(given, path)
    log = formats.read_pathweaver(path)
    np.testing.assert_allclose(log.x, given.x)
    np.testing.assert_allclose(log.v, given.v)
    np.testing.assert_allclose(log.omega, given.omega, atol=1e-9)
    made = log.trajectory(dt=0.1)
    np.testing.assert_allclose(made.theta, given.theta, atol=1e-9)
    state = json.loads(path.read_text())[3]
    assert set(state) == {"time", "velocity", "acceleration", "pose", "curvature"}


def test_pathweaver_is_wpilib_s(tmp_path):
    trajectory = pytest.importorskip("wpimath.trajectory")
    given = Trajectory.eight(period=30, dt=0.1)
    path = tmp_path / "eight.wpilib.json"
    formats.write_pathweaver(given, path)
    read = trajectory.TrajectoryUtil.fromPathweaverJson(str(path))
    assert read.totalTime() == pytest.approx(given.t[-1])
    state = read.sample(given.t[30])
    assert state.pose.x == pytest.approx(given.x[30], rel=1e-5)
    assert state.velocity == pytest.approx(given.v[30], rel=1e-3)
    formats.write_pathweaver(backing(), path)
    read = trajectory.TrajectoryUtil.fromPathweaverJson(str(path))
    poses = [read.sample(t).pose for t in np.arange(0, read.totalTime(), 0.007)]
    assert np.isfinite([(pose.x, pose.y) for pose in poses]).all()


def test_reversing_keeps_its_sign(tmp_path):
    given = backing()
    assert given.v.min() < -0.3
    path = tmp_path / "backing.wpilib.json"
    formats.write_pathweaver(given, path)
    log = formats.read_pathweaver(path)
    assert log.start == pytest.approx(0.02)  # a sample at rest is left out
    assert "drives backwards at" in log.notes[1]
    made = log.trajectory(dt=0.02)
    np.testing.assert_allclose(made.v[1:-1], given.v[2:-2], atol=1e-6)
    by_sign = Trajectory.from_states(log.t, log.x, log.y, v=log.v, dt=0.02)
    moving = np.abs(given.v) > 0.1
    assert (np.sign(by_sign.v[moving[1:-1]]) == np.sign(given.v[moving])).all()


def test_turning_on_the_spot_is_no_pathweaver(tmp_path):
    limits = Limits(speed=0.5, acceleration=0.5, turn_rate=1, turn_acceleration=1)
    spot = from_waypoints([[0, 0], [1, 0], [0, 0]], limits, 0.05)
    with pytest.raises(ValueError, match=r"sample \d+, at .* turns on the spot"):
        formats.write_pathweaver(spot, tmp_path / "spot.json")
    waits = from_waypoints([[0, 0], [1, 0], [2, 0]], limits, 0.05, dwell=[0, 1, 0])
    with pytest.raises(ValueError, match=r"sample \d+, at .* s, waits, which WPILib's"):
        formats.write_pathweaver(waits, tmp_path / "waits.json")
    still = Trajectory.from_samples([0, 0, 0], [0, 0, 0], 0.1, theta=[0, 0, 0])
    with pytest.raises(ValueError, match="source stands at one place"):
        formats.write_pathweaver(still, tmp_path / "still.json")


def test_a_pathweaver_path(tmp_path):
    path = tmp_path / "out.path"
    path.write_text(
        "X,Y,Tangent X,Tangent Y,Fixed Theta,Reversed,Name\n"
        "0.0,0.0,1.0,0.0,true,false,\n2.0,1.0,0.0,1.0,true,true,\n"
    )
    log = formats.read_pathweaver(path)
    np.testing.assert_allclose(log.theta, [0, 1.5 * pi])
    assert log.reverse.tolist() == [False, True]
    path.write_text("X,Y\n0,0\n")
    with pytest.raises(ValueError, match="no column Tangent X"):
        formats.read_pathweaver(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "not JSON"),
        ("[]", "must be a list of states"),
        ('[{"time": 0}]', r"\[0\] has no velocity"),
        ('[{"time": true}]', r"\[0\].time is True; must be a finite number"),
        ('[{"time": 0, "velocity": 1, "curvature": 0, "pose": 3}]', "has no pose.translation.x"),
    ],
)
def test_bad_pathweaver_is_refused(text, message, tmp_path):
    path = tmp_path / "a.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        formats.read_pathweaver(path)


def choreo(**changes):
    samples = [
        {
            "t": float(t),
            "x": float(x),
            "y": float(y),
            "heading": float(h),
            "vl": -0.4,
            "vr": -0.6,
            "omega": -0.2,
            "al": 0.0,
            "ar": 0.0,
            "alpha": 123.0,
            "fl": 1.0,
            "fr": 2.0,
        }
        for t, x, y, h in zip(T, X, Y, THETA + pi, strict=True)
    ]
    inner = {"sampleType": "Differential", "waypoints": [0.0], "samples": samples, "splits": [0]}
    return {"name": "lap", "version": 1, "trajectory": inner | changes, "events": []}


def test_choreo(tmp_path):
    path = tmp_path / "lap.traj"
    path.write_text(json.dumps(choreo()))
    log = formats.read_choreo(path)
    assert set(log.v) == {-0.5}
    assert "not used: al, alpha, ar, fl, fr" in log.notes[0]
    assert "drives backwards at 41 of 41" in log.notes[1]
    made = log.trajectory(dt=0.1)
    assert made.reverse.all()
    assert any("m/s rms from the one given" in note for note in made.notes)
    for changes, message in [
        ({"sampleType": "Swerve"}, "a swerve trajectory"),
        ({"samples": []}, "no samples"),
        ({"samples": [{"t": 0, "vx": 1}]}, "a swerve trajectory"),
        ({"samples": [{"t": 0, "vl": 1}]}, r"samples\[0\] has no vr"),
    ]:
        path.write_text(json.dumps(choreo(**changes)))
        with pytest.raises(ValueError, match=message):
            formats.read_choreo(path)


def test_what_is_no_motion_is_refused(tmp_path):
    for write in (formats.write_tum, formats.write_pathweaver):
        with pytest.raises(ValueError, match="source is 3; must be a Trajectory"):
            write(3, tmp_path / "a")


def test_the_journey_of_a_table(tmp_path):
    """From waypoints to a run, whose files are read by others."""
    path = tmp_path / "waypoints.csv"
    path.write_text(table(["x_m", "y_m"], X[::8], Y[::8]))
    log = formats.read_csv(path)
    limits = Limits(speed=0.8, acceleration=0.5, wheel_torque=1.5)
    trajectory = Trajectory.from_waypoints(log.points, limits, 0.05, robot=Robot())
    run = simulate(Scenario(trajectory, rng=0))
    assert run.diverged_at is None
    assert nfopidn.trajectories.uses(trajectory, limits, Robot())
