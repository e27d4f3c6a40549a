"""`nfopidn trajectory`: from files to trajectories."""

import json

import nfopidn
import numpy as np
import pytest
from nfopidn import Robot, Scenario, Trajectory, formats
from nfopidn.commands.entry import main
from nfopidn.trajectories import Limits, from_waypoints

POINTS = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]])
LIMIT = [
    "--limit",
    "speed=1",
    "--limit",
    "acceleration=0.5",
    "--limit",
    "turn_acceleration=2",
    "--dt",
    "0.05",
]
LIMITS = Limits(speed=1, acceleration=0.5, turn_acceleration=2)


@pytest.fixture
def waypoints(tmp_path):
    path = tmp_path / "waypoints.csv"
    rows = "".join(f"{x},{y},0.4\n" for x, y in POINTS)
    path.write_text("x_m,y_m,vx_mps\n" + rows)
    return str(path)


@pytest.fixture
def log(tmp_path):
    path = tmp_path / "log.tum"
    formats.write_tum(Trajectory.circle(period=10, dt=0.1), path)
    return str(path)


def test_waypoints_become_a_table(waypoints, tmp_path, capsys):
    out = tmp_path / "path.csv"
    assert main(["trajectory", waypoints, "-o", str(out), *LIMIT]) == 0
    told = capsys.readouterr()
    expected = from_waypoints(POINTS, LIMITS, 0.05)
    assert told.out == (
        f"{len(expected)} samples, {expected.t[-1]:.6g} s, peak speed {expected.peak_speed:.4g} "
        f"m/s: {out}\n"
    )
    assert "x from column x_m" in told.err
    assert "from waypoints: " in told.err
    read = Trajectory.from_csv(out)
    np.testing.assert_array_equal(read.x, expected.x)
    np.testing.assert_allclose(read.v, expected.v, atol=1e-9)


CHANGES = {
    "closed": (["--closed"], {"closed": True}),
    "laps": (["--closed", "--laps", "2"], {"closed": True, "laps": 2}),
    "tolerance": (["--tolerance", "0.1"], {"tolerance": 0.1}),
    "corner": (["--corner", "1"], {"corner": 1.0}),
    "smoothing": (["--smoothing", "0"], {"smoothing": 0.0}),
    "use speed": (["--use-speed"], {"speed": [0.4] * 4}),
}


@pytest.mark.parametrize("name", CHANGES)
def test_options_are_arguments(name, waypoints, tmp_path):
    words, arguments = CHANGES[name]
    out = tmp_path / "scenario.json"
    assert main(["trajectory", waypoints, "-o", str(out), *LIMIT, *words, "--quiet"]) == 0
    expected = from_waypoints(POINTS, LIMITS, 0.05, **arguments)
    assert Scenario.load(out).trajectory == expected
    assert expected != from_waypoints(POINTS, LIMITS, 0.05)


def test_quiet_prints_nothing(waypoints, tmp_path, capsys):
    assert main(["trajectory", waypoints, "-o", str(tmp_path / "a.csv"), *LIMIT, "--quiet"]) == 0
    assert capsys.readouterr().out == ""


def test_the_robot_is_the_scenario_s(waypoints, tmp_path):
    given, out = tmp_path / "given.json", tmp_path / "out.json"
    robot = Robot(mass=30.0)
    Scenario(Trajectory.line(), robot, torque_limit=2.0, rng=0).save(given)
    words = ["--limit", "wheel_torque=0.3", "--limit", "speed=1", "--dt", "0.05"]
    run = ["trajectory", waypoints, "-o", str(out), *words]
    assert main(run) == 2  # a wheel needs a robot
    assert main([*run, "--scenario", str(given)]) == 0
    made = Scenario.load(out)
    assert made.robot == robot
    assert made.torque_limit == 2.0
    limits = Limits(wheel_torque=0.3, speed=1)
    assert made.trajectory == from_waypoints(POINTS, limits, 0.05, robot)


def test_the_robot_is_the_urdf_s(waypoints, tmp_path, capsys):
    pytest.importorskip("yourdfpy")
    urdf, out = tmp_path / "robot.urdf", tmp_path / "out.json"
    wheel = (
        '<link name="{0}"><visual><geometry><sphere radius="0.1"/></geometry></visual></link>'
        '<joint name="{0}_joint" type="continuous"><parent link="base"/><child link="{0}"/>'
        '<origin xyz="0 {1} 0"/></joint>'
    )
    body = (
        '<link name="base"><inertial><mass value="20"/><inertia ixx="1" iyy="1" izz="0.5" '
        'ixy="0" ixz="0" iyz="0"/></inertial></link>'
    )
    text = body + wheel.format("left", 0.3) + wheel.format("right", -0.3)
    urdf.write_text(f'<robot name="r">{text}</robot>')
    run = ["trajectory", waypoints, "-o", str(out), *LIMIT, "--urdf", str(urdf)]
    assert main(run) == 0
    assert Scenario.load(out).robot == Robot(20, 0.5, 0.6, 0.1)
    assert "wheels left_joint (left)" in capsys.readouterr().err
    assert main([*run, "--scenario", str(out)]) == 2
    assert "give one" in capsys.readouterr().err


@pytest.mark.parametrize("suffix", [".csv", ".tum", ".wpilib.json", ".mcap"])
def test_logs_are_resampled(suffix, log, tmp_path):
    if suffix == ".mcap":
        pytest.importorskip("mcap")
        pytest.importorskip("rosbags")
    out = tmp_path / f"out{suffix}"
    assert main(["trajectory", log, "-o", str(out), "--dt", "0.05"]) == 0
    expected = formats.read_tum(log).trajectory(dt=0.05)
    again = tmp_path / "again.csv"
    more = ["--topic", "/reference", "--stamps", "header"] if suffix == ".mcap" else []
    assert main(["trajectory", str(out), "-o", str(again), *more]) == 0
    read = Trajectory.from_csv(again)
    np.testing.assert_allclose(read.x, expected.x, atol=1e-6)


def test_tables_are_told_what_they_hold(tmp_path):
    path, out = tmp_path / "log.txt", tmp_path / "out.csv"
    t = np.arange(50)
    np.savetxt(path, np.column_stack([t, t, 0 * t, 0 * t]), header="when east north up")
    words = ["--column", "t=when", "--column", "x=east", "--column", "y=2", "--unit", "x=cm"]
    assert main(["trajectory", str(path), "-o", str(out), *words, "--format", "csv"]) == 0
    assert Trajectory.from_csv(out).x[-1] == pytest.approx(0.49)


def test_choreo(tmp_path):
    path, out = tmp_path / "a.traj", tmp_path / "out.csv"
    samples = [
        {"t": 0.1 * k, "x": 0.1 * k, "y": 0, "heading": 0, "vl": 1, "vr": 1} for k in range(9)
    ]
    path.write_text(json.dumps({"trajectory": {"samples": samples}}))
    assert main(["trajectory", str(path), "-o", str(out)]) == 0
    np.testing.assert_allclose(Trajectory.from_csv(out).v, 1)


def test_frames(tmp_path, capsys):
    """Options of bags reach the reader, which refuses what is no bag."""
    path = tmp_path / "a.bag"
    path.write_text("no bag")
    assert main(["trajectory", str(path), "--child-frame", "base_link"]) == 2
    assert f"nfopidn: {path}: " in capsys.readouterr().err


REFUSED = [
    (["{log}", "-o", "a.xyz"], "--output a.xyz: must end in one of .csv, .json, .tum, .mcap"),
    (["{log}", "--closed"], "--closed is of waypoints, which need --limit"),
    (["{log}", "--laps", "2"], "--laps is of waypoints, which need --limit"),
    (["{log}", "--topic", "/odom"], "are of bags"),
    (["{log}", "--column", "x=y"], "--column and --unit are of tables"),
    (["{log}", "--speed-limit", "0.01"], "speed_limit is 0.01 m/s"),
    (["{way}", "--limit", "speed=1"], "nothing limits the acceleration"),
    (["{way}", "--limit", "sped=1"], "--limit sped: no limit (did you mean 'speed'?)"),
    (["{way}", "--limit", "speed=1", "--limit", "acceleration=1"], "--limit needs --dt"),
    (["{way}", *LIMIT, "--speed-limit", "1"], "--speed-limit is of a log's outliers"),
    (["{way}"], "no times; Trajectory.from_waypoints"),
    (["somewhere"], "--format says which of csv, tum, bag, pathweaver, choreo it is"),
]


@pytest.mark.parametrize(("words", "message"), REFUSED)
def test_bad_usage_is_refused(words, message, waypoints, log, capsys):
    words = [word.format(log=log, way=waypoints) for word in words]
    assert main(["trajectory", *words]) == 2
    assert message in capsys.readouterr().err


def test_the_command_is_listed(capsys):
    with pytest.raises(SystemExit):
        main(["--help"])
    assert "trajectory" in capsys.readouterr().out
    assert nfopidn.trajectories.Limits is Limits
