"""Tables that are refused: the message names file and line."""

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory
from refusal import refused

TABLES = {
    "text cell": ("t,x,y\n0,0,0\n1,one,0\n2,2,0\n", [":3: ", '"one"', "column x"]),
    "empty cell": ("t,x,y\n0,0,0\n1,,0\n2,2,0\n", [":3: ", '""', "column x"]),
    "NaN cell": ("x,y\n0,0\n1,1\n2,nan\n", [":4: ", '"nan"', "column y", "finite"]),
    "infinite cell": ("x,y\n0,0\n-inf,1\n2,1\n", [":3: ", '"-inf"', "column x", "finite"]),
    "beyond every float": ("x,y\n0,0\n1e400,1\n2,1\n", [":3: ", '"1e400"', "column x"]),
    "bad UTF-8": (b"x,y\n0,0\n\xff,1\n2,1\n", [":3: ", "column x"]),
    "row too short": ("t,x,y\n0,0,0\n\n1,1\n2,2,0\n", [":4: ", "2 cells", "3: t, x, y"]),
    "row too long": ("x,y\n0,0\n1,1,1\n2,2\n", [":3: ", "3 cells", "2"]),
    "decimal commas": ("x;y\n0,5;0\n1;1\n2;2\n", [":2: ", '"0,5"', "decimals need a point"]),
    "UTF-16": ("x,y\n0,0\n".encode("utf-16"), ["is text in UTF-16", "must be in UTF-8"]),
    "two times": (
        "time,stamp,x,y\n0,0,0,0\n1,1,1,1\n2,2,2,2\n",
        [":1: ", "time and stamp both stand for t"],
    ),
    "two of x": ("X,x_m,y\n0,0,0\n", [":1: ", "X and x_m both stand for x", "rename one"]),
    "feet": ("x_ft,y_ft\n0,0\n", [":1: ", "x and y", "its columns are x_ft, y_ft"]),
    "no time": ("x,y,speed\n0,0,1\n1,1,1\n2,2,1\n", [":1: ", "give dt", "are x, y, speed"]),
    "reverse": ("t,x,y,reverse\n0,0,0,2\n1,1,1,0\n2,2,2,0\n", [":2: ", "reverse", "0 or 1"]),
    "no header": ("0,0,0\n1,1,1\n2,2,0\n", [":1: ", "no header"]),
    "a comment and no header": ("# a\n0,0\n1,1\n", [":1: ", "x and y", "its columns are a"]),
    "empty file": ("", [":1: ", "empty"]),
    "blank file": ("\n \n\t\n", [":1: ", "empty"]),
    "no x": ("t,y\n0,0\n1,1\n2,2\n", [":1: ", "x and y"]),
    "no y": ("t,x\n0,0\n1,1\n2,2\n", [":1: ", "x and y"]),
    "column twice": ("x,y,x\n0,0,0\n", [":1: ", "x and x both stand for x"]),
    "no rows": ("t,x,y\n", ["0 samples", "at least 3"]),
    "too few rows": ("t,x,y\n0,0,0\n1,1,1\n", ["2 samples", "at least 3"]),
    "t jumps": ("t,x,y\n0,0,0\n1,1,0\n2,2,0\n3,3,0\n5,4,0\n", ["equal steps of 1.25 s", "off"]),
    "t stands": ("t,x,y\n0,0,0\n0,1,0\n0,2,0\n", [":3: ", "rise"]),
    "t falls": ("t,x,y\n2,0,0\n1,1,0\n0,2,0\n", [":3: ", "rise"]),
    "t too fast": ("t,x,y\n0,0,0\n1e-9,1,0\n2e-9,2,0\n", ["is 1e-09", "in [1e-06, 1000] s"]),
    "t too slow": ("t,x,y\n0,0,0\n2000,1,0\n4000,2,0\n", ["is 2000", "in [1e-06, 1000] s"]),
    "x too far": ("x,y\n0,0\n2e9,1\n0,2\n", ["2e+09", "in [-1e+09, 1e+09] m"]),
}


@pytest.fixture
def table(tmp_path):
    def write(content):
        path = tmp_path / "path.csv"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    return write


@pytest.mark.parametrize("name", TABLES)
def test_tables(name, table, sim):
    content, parts = TABLES[name]
    path = table(content)
    dt = [0.2] if content[:2] == "x," and name != "no time" else []
    with refused(str(path), *parts):
        Trajectory.from_csv(path, **dict.fromkeys(["dt"] * len(dt), 0.2))
    run = sim("--traj", path, *(["--dt", "0.2"] if dt else []))
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.count("\n") == 1
    assert all(part in run.stderr for part in [str(path), *parts]), run.stderr


@pytest.mark.parametrize(
    ("settings", "parts"),
    [
        ({"dt": 0}, ["dt is 0", "in [1e-06, 1000] s"]),
        ({"dt": float("nan")}, ["dt is nan", "in [1e-06, 1000] s"]),
        ({"heading": "back"}, ['heading is "back"', '"forward"', '"continuous"']),
        ({"laps": 0}, ["laps is 0", "in [1, 1e+06]"]),
        ({"laps": 2}, ["path.csv", "laps is 2", "must be 1"]),
        ({"laps": 1.5}, ["laps is 1.5", "a whole number"]),
    ],
)
def test_settings(settings, parts, table):
    with refused(*parts):
        Trajectory.from_csv(table("x,y\n0,0\n1,1\n2,1\n"), **({"dt": 0.2} | settings))


def test_missing_file_and_directory(tmp_path):
    for path, reason in [(tmp_path / "none.csv", "No such file"), (tmp_path, "directory")]:
        with pytest.raises((ValueError, OSError), match=reason) as caught:
            Trajectory.from_csv(path)
        assert str(path) in str(caught.value)


@pytest.mark.parametrize("path", [None, 3, ["path.csv"]])
def test_what_is_no_path(path):
    for call in (
        Trajectory.from_csv,
        Controller.load,
        Scenario.load,
        Controller.published().save,
        nfopidn.simulate().to_csv,
    ):
        with pytest.raises(TypeError, match="PathLike"):
            call(path)


def test_a_path_ends_at_no_nul(tmp_path, published):
    """Were it cut there, another file than the one named would be read or written."""
    path = tmp_path / "run.csv"
    published.to_csv(path)
    before = path.read_bytes()
    for call in (Trajectory.from_csv, Controller.published().save):
        with pytest.raises(ValueError, match=r"null|NUL"):
            call(f"{path}\0.bak")
    assert path.read_bytes() == before


@pytest.mark.parametrize("write", [Controller.published().save, Scenario.published().save, None])
def test_what_cannot_be_written(write, published, tmp_path):
    write = write or published.to_csv
    for path, reason in [(tmp_path / "none" / "file", "No such file"), (tmp_path, "directory")]:
        with pytest.raises((ValueError, OSError), match=reason) as caught:
            write(path)
        assert str(path) in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_full_disk_is_noticed(published):
    with pytest.raises((ValueError, OSError), match="No space left"):
        published.to_csv("/dev/full")


def test_a_link_stays_a_link(published, tmp_path):
    target, link = tmp_path / "target.csv", tmp_path / "link.csv"
    target.write_text("old")
    link.symlink_to(target)
    published.to_csv(link)
    assert link.is_symlink()
    assert np.loadtxt(target, delimiter=",", skiprows=1).shape == (751, 18)
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["link.csv", "target.csv"]
