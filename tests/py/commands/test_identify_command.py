"""`nfopidn identify`: from a table to a robot."""

import json

import numpy as np
import pytest
from identification_logs import DT, drive, log_of, steps
from nfopidn import Motor, Robot, Scenario, Trajectory, identify
from nfopidn.commands.entry import main
from nfopidn.identification.table import read_columns

ROBOT = Robot()


@pytest.fixture(scope="module")
def log():
    torque = steps(601)
    columns = log_of(torque, drive(torque, delay=1))
    columns["x"][100:500:40] += 0.4
    return columns


def write(path, log, separator=",", names=None):
    rows = zip(*(column.tolist() for column in log.values()), strict=True)
    text = "".join(separator.join(map(repr, row)) + "\n" for row in rows)
    path.write_text(separator.join(names or log) + "\n" + text)
    return str(path)


@pytest.fixture(scope="module")
def table(log, tmp_path_factory):
    return write(tmp_path_factory.mktemp("log") / "log.csv", log)


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("robot") / "scenario.json"
    motor = Motor(back_emf_constant=0)
    Scenario(Trajectory.circle(), ROBOT, motor=motor, rng=0).save(path)
    return str(path)


def result_of(words, tmp_path):
    out = tmp_path / "result.json"
    assert main(["identify", *words, "--result", str(out), "--quiet"]) == 0
    return json.loads(out.read_text())


def test_a_table_becomes_a_scenario(table, scenario, log, tmp_path, capsys):
    out = tmp_path / "found.json"
    assert main(["identify", table, "--scenario", scenario, "-o", str(out)]) == 0
    told = capsys.readouterr()
    expected = identify(log, robot=ROBOT)
    assert told.out == f"{expected}\n"
    assert "10 of" in told.err
    assert Scenario.load(out) == expected.scenario
    assert Scenario.load(out).delay == 1


CHANGES = {
    "free": (["--free", "mass", "--free", "inertia"], {"free": ["mass", "inertia"]}),
    "known": (
        ["--free", "mass", "--known", "coulomb_friction=0.15"],
        {"free": ["mass"], "known": {"coulomb_friction": 0.15}},
    ),
    "delay": (["--delay", "2"], {"delay": 2}),
    "max delay": (["--max-delay", "0"], {"max_delay": 0}),
    "window": (["--window", "2.5"], {"window": 2.5}),
    "loss": (["--loss", "squares"], {"loss": "squares"}),
    "validation": (["--validation", "0.4"], {"validation": 0.4}),
}


@pytest.mark.parametrize("name", CHANGES)
def test_options_are_arguments(name, table, scenario, log, tmp_path):
    words, arguments = CHANGES[name]
    told = result_of([table, "--scenario", scenario, *words], tmp_path)
    expected = identify(log, robot=ROBOT, **arguments)
    assert told == json.loads(expected.to_json())


def test_fractional(table, scenario, tmp_path):
    told = result_of([table, "--scenario", scenario, "--delay", "fractional"], tmp_path)
    assert told["delay"] == pytest.approx(1, abs=0.05)


def test_signs_and_columns(log, scenario, tmp_path):
    names = ["stamp", "x", "y", "theta", "right", "left"]
    path = write(tmp_path / "real.csv", log, ";", names)
    words = ["--column", "t=stamp", "--column", "tau_left=left", "--column", "tau_right=right"]
    told = result_of([path, "--scenario", scenario, *words, "--signs", "rep103"], tmp_path)
    assert told["parameters"] == pytest.approx(dict(identify(log, robot=ROBOT).parameters))


def test_voltages(log, scenario, tmp_path):
    motor = Motor(back_emf_constant=0)
    volts = dict(log)
    for side in ("left", "right"):
        per_volt = motor.gear_ratio * motor.torque_constant / motor.resistance
        volts[f"voltage_{side}"] = volts.pop(f"tau_{side}") / per_volt
    path = write(tmp_path / "volts.csv", volts)
    told = result_of([path, "--model", "voltage", "--scenario", scenario], tmp_path)
    assert told["parameters"]["mass"] == pytest.approx(9.3, rel=0.02)


def test_counters(log, scenario, tmp_path):
    torque = steps(601)
    rows = drive(torque, delay=1)
    distance = np.concatenate([[0], np.cumsum(0.5 * (rows[1:, 3] + rows[:-1, 3]) * DT)])
    counts = {
        f"counts_{name}": np.round((distance + side * 0.226 * rows[:, 2]) / 0.076 * 1000) % 5000
        for name, side in (("left", 1), ("right", -1))
    }
    poses = {name: log[name] for name in ("t", "x", "y", "theta")}
    path = write(tmp_path / "counts.csv", {**poses, **counts})
    words = [path, "--model", "odometry", "--scenario", scenario]
    assert main(["identify", *words, "--counter-range", "5000"]) == 2  # of how many a turn?
    words += ["--counts-per-turn", repr(2000 * np.pi)]
    told = result_of([*words, "--counter-range", "5000"], tmp_path)
    assert told["parameters"]["wheel_radius_left"] == pytest.approx(0.076, rel=0.005)
    assert told["parameters"]["track_width"] == pytest.approx(0.452, rel=0.005)


def test_urdf(table, tmp_path, monkeypatch):
    seen = []

    def found(path):
        seen.append(path)
        return type("Found", (), {"robot": ROBOT, "notes": ("a note",)})()

    monkeypatch.setattr("nfopidn.commands.identify.read_urdf", found)
    (tmp_path / "robot.urdf").write_text("<robot/>")
    told = result_of([table, "--urdf", str(tmp_path / "robot.urdf")], tmp_path)
    assert told["robot"]["track_width"] == ROBOT.track_width
    assert seen == [str(tmp_path / "robot.urdf")]


def test_picture(table, scenario, tmp_path):
    for words in ([], ["--dark"]):
        picture = tmp_path / f"picture{len(words)}.png"
        plot = ["--plot", str(picture), *words, "--quiet"]
        assert main(["identify", table, "--scenario", scenario, *plot]) == 0
    pictures = [(tmp_path / f"picture{i}.png").read_bytes() for i in (0, 1)]
    assert all(one.startswith(b"\x89PNG") for one in pictures)
    assert pictures[0] != pictures[1]


REFUSED = {
    "no robot": ([], "robot is None"),
    "two robots": (["--scenario", "SCENARIO", "--urdf", "a.urdf"], "both have a robot"),
    "dark": (["--dark"], "--dark is of a picture"),
    "velocity": (["--model", "velocity", "-o", "a.json"], "does not find"),
    "column": (["--column", "x=there"], "of which name the table has no column; it has t, x"),
    "quantity": (["--column", "z=x"], "column 'z' is unknown"),
}


@pytest.mark.parametrize("name", REFUSED)
def test_bad_usage(name, table, scenario, capsys):
    words, message = REFUSED[name]
    words = [scenario if word == "SCENARIO" else word for word in words]
    assert main(["identify", table, *words]) == 2
    assert message in capsys.readouterr().err


TABLES = {
    "blanks": "t x\n0 1\n1 2\n",
    "tabs": "t\tx\n0\t1\n1\t2\n",
    "semicolons": "t; x\n0; 1\n1; 2\n",
    "comments": "# made by hand\n# t,x\n0,1\n# half\n1,2\n",
    "quotes": '"t","x"\n0,1\n1,2\n',
}


@pytest.mark.parametrize("name", TABLES)
def test_tables(name, tmp_path):
    path = tmp_path / "table.txt"
    path.write_text(TABLES[name])
    read = read_columns(str(path))
    assert {name: column.tolist() for name, column in read.items()} == {"t": [0, 1], "x": [1, 2]}


def test_a_cell_that_is_no_number(tmp_path):
    path = tmp_path / "table.csv"
    path.write_text("t,x\n0,1\n1\n")
    with pytest.raises(ValueError, match=r"table.csv:3: '' in column 2 is no number"):
        read_columns(str(path))
    path.write_text("t,x\n")
    with pytest.raises(ValueError, match="has 1 lines"):
        read_columns(str(path))
