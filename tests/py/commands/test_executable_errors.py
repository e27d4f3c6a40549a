"""What the executable refuses: one line on standard error, exit code 2, and no file touched."""

import json
import signal
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path

import nfopidn
import pytest
from nfopidn import Controller, Scenario

# Arguments and what the line must say.
FAULTS = {
    "unknown option": (["--masss", "3"], ["--masss", "--help"]),
    "stray word": (["ranunculoid"], ["ranunculoid"]),
    "no value": (["--mass"], ["--mass"]),
    "twice": (["--mass", "3", "--mass", "4"], ["--mass"]),
    "out of range": (["--mass", "-1"], ["mass is -1", "in [1e-06, 1e+06] kg"]),
    "zero": (["--dt", "0"], ["dt is 0", "in [1e-06, 1000] s"]),
    "NaN": (["--inertia", "nan"], ["inertia is nan", "in [1e-09, 1e+09] kg m^2"]),
    "infinite": (["--viscous", "inf"], ["viscous_friction is inf", "in [0, 1000] N m s/rad"]),
    "beyond every float": (["--mass", "1e400"], ["mass", "1e400"]),
    "text": (["--mass", "heavy"], ['mass is "heavy"', "a number"]),
    "empty": (["--mass", ""], ['mass is ""', "a number"]),
    "hexadecimal": (["--mass", "0x10"], ['mass is "0x10"', "a number"]),
    "text behind": (["--mass", "10kg"], ['mass is "10kg"', "a number"]),
    "fraction": (["--memory", "2.5"], ["memory is 2.5", "a whole number"]),
    "memory": (["--memory", "1000001"], ["memory is 1000001", "in [0, 1e+06] samples, or"]),
    "order": (["--alpha", "2.5"], ["alpha is 2.5", "in [-2, 2]"]),
    "order of a channel": (["--sigma", "1,1,-3"], ["sigma[2] is -3", "in [-2, 2]"]),
    "two orders": (["--alpha", "1,2"], ["alpha is [1.0,2.0]", "3"]),
    "gains": (["--gains", "1,2,3,4"], ["gains is", "3 lists of 3 numbers"]),
    "pose": (["--pose", "1,2"], ["pose is [1.0,2.0]", "3 numbers"]),
    "pose text": (["--pose", "1,2,x"], ['pose[2] is "x"', "a number"]),
    "pose too far": (["--pose", "40,0,0"], ["pose is 37 m", "10 m"]),
    "velocity": (["--velocity", "fast"], ['velocity is ["fast"]', "2 numbers"]),
    "noise": (["--noise", "-1,0"], ["noise[0] is -1", "in [0, 1000] m, rad"]),
    "choice": (["--form", "Positional"], ['form is "Positional"', '"positional"', '"incremental"']),
    "path": (["--traj", "square"], ['"square"', "ranunculoid", "rounded_square"]),
    "path of samples": (["--traj", "samples"], ["--trajectory samples", "give a file"]),
    "another form than the structure's": (
        ["--tune", "--structure", "incremental", "--form", "positional"],
        ['form is "positional"; must be "incremental"'],
    ),
    "orders of each channel in a structure with one pair": (
        ["--tune", "--structure", "decoupled", "--controller", "by_channel.json"],
        ["alpha and sigma must be one for all channels"],
    ),
    "few samples": (["--period", "0.3"], ["samples is 2", "in [3, 1e+07]"]),
    "many samples": (["--period", "1e9"], ["samples is 5000000001", "in [3, 1e+07]"]),
    "missing table": (["--traj", "none.csv"], ["none.csv", "No such file"]),
    "period of a table": (["--traj", "path.csv", "--period", "3"], ["--period", "path.csv"]),
    "cusps of a table": (["--traj", "path.csv", "--cusps", "3"], ["--cusps", "path.csv"]),
    "step of a table with times": (
        ["--traj", "timed.csv", "--dt", "0.3"],
        ["timed.csv:3: ", "equal steps of the dt given, 0.3 s", "their mean step is 0.2 s"],
    ),
    "a table without times": (["--traj", "path.csv"], ["path.csv:1: ", "give dt"]),
    "a missing file of another kind": (["--traj", "none.txt"], ["none.txt", "No such file"]),
    "a directory as a path": (["--traj", "./"], ["./", "directory"]),
    "closed without a file": (["--closed"], ["--closed", "--trajectory FILE"]),
    "wind of another step": (
        ["--disturbance", "timed_wind.csv"],
        ["timed_wind.csv:3: ", "equal steps of the dt given, 0.2 s", "their mean step is 1 s"],
    ),
    "cusps of a circle": (["--traj", "circle", "--cusps", "4"], ["--cusps", "circle"]),
    "laps of an open table": (["--traj", "timed.csv", "--laps", "2"], ["laps is 2", "must be 1"]),
    "disturbance": (["--disturbance", "1"], ["disturbance is [1.0]", "2 numbers"]),
    "short disturbance": (["--disturbance", "wind.csv"], ["disturbance has 3", "751"]),
    "disturbance columns": (["--disturbance", "path.csv"], ["path.csv:1:", "force and moment"]),
    "missing disturbance": (["--disturbance", "none.csv"], ["none.csv", "No such file"]),
    "missing scenario": (["--scenario", "none.json"], ["none.json", "No such file"]),
    "wrong document": (["--controller", "scenario.json"], ["scenario.json", "nfopidn-controller"]),
    "no name of a scenario": (["--scenario", ""], ["--scenario"]),
    "no name of an output": (["--out", ""], ["--out"]),
    "no directory": (["--out", "none/run.csv"], ["none/run.csv", "No such file"]),
    "a directory": (["--save-scenario", "."], [".", "directory"]),
    "full disk": (["--out", "/dev/full"], ["/dev/full", "No space left"]),
    "one name for two files": (["--out", "same", "--save-scenario", "same"], ["same"]),
    "two names for one file": (["--out", "same", "--save-scenario", "./same"], ["two files"]),
    "a text for a flag": (["--no-feedforward=maybe"], ["--no-feedforward takes no value"]),
    "a value for json": (["--json=false"], ["--json takes no value"]),
    "a value for tune": (["--tune=0"], ["--tune takes no value"]),
    "too long a memory to tune": (["--tune", "--memory", "inf"], ["memory is inf", "[0, 1024]"]),
    "the table overwritten": (
        ["--traj", "timed.csv", "--out", "timed.csv"],
        ["timed.csv is to be"],
    ),
    "the wind overwritten": (
        ["--traj", "timed.csv", "--disturbance", "wind.csv", "--out", "wind.csv"],
        ["wind.csv is to be read"],
    ),
    "the scenario overwritten": (
        ["--scenario", "scenario.json", "--save-scenario", "./scenario.json"],
        ["would be overwritten"],
    ),
    "a hard link to the scenario": (
        ["--scenario", "scenario.json", "--out", "hard.json"],
        ["hard.json is to be read"],
    ),
    "a value for a flag": (["--feedforward=false"], ["--feedforward takes no value"]),
    "a number for a flag": (["--no-feedforward=0"], ["--no-feedforward takes no value"]),
}


@pytest.fixture
def folder(tmp_path):
    """A folder to run in, with some good files."""
    (tmp_path / "path.csv").write_text("x,y\n0,0\n1,1\n2,1\n")
    (tmp_path / "timed.csv").write_text("t,x,y\n0,0,0\n0.2,1,1\n0.4,2,1\n")
    (tmp_path / "timed_wind.csv").write_text("t,force,moment\n0,0,0\n1,1,1\n2,2,1\n")
    (tmp_path / "wind.csv").write_text("force,moment\n0,0\n1,1\n2,1\n")
    Scenario.published().save(tmp_path / "scenario.json")
    by_channel = Controller.published(allocation="decoupled", alpha=[0.1, 0.2, 0.3])
    by_channel.save(tmp_path / "by_channel.json")
    (tmp_path / "run.csv").write_text("precious")
    (tmp_path / "hard.json").hardlink_to(tmp_path / "scenario.json")
    return tmp_path


def contents(folder):
    return {file.name: file.read_bytes() for file in folder.iterdir()}


@pytest.mark.parametrize(("arguments", "parts"), FAULTS.values(), ids=FAULTS.keys())
def test_faults(arguments, parts, sim, folder):
    before = contents(folder)
    for others in (["--json"], ["--save-controller", "run.csv"]):
        run = sim(*others, *arguments, cwd=folder)
        assert run.returncode == 2
        assert run.stdout == ""
        assert run.stderr.startswith("nfopidn_sim: ")
        assert run.stderr.endswith("\n")
        assert run.stderr.count("\n") == 1
        assert all(part in run.stderr for part in parts), run.stderr
        if arguments != ["--out", "/dev/full"]:
            assert contents(folder) == before


ENDLESS_SEARCH = ["--tune", "--maxfev", "1000000000000", "--json"]


@contextmanager
def endless_search(*words):
    """An endless search, once it looks after signals."""
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([*words, *ENDLESS_SEARCH], text=True, **pipes) as search:
        try:
            while not caught(search.pid) >> (signal.SIGTERM - 1) & 1:
                assert search.poll() is None
            yield search
        finally:
            search.kill()


def caught(pid):
    """The signals that a process has a handler for, a bit each."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("SigCgt:")[1].split()[0], 16)


@pytest.fixture(params=["nfopidn_sim", "nfopidn simulate"])
def program(request, executable):
    """How the program is started that has this name in its messages, and the name."""
    if request.param == "nfopidn_sim":
        return [executable], request.param
    return [sys.executable, "-m", "nfopidn", "simulate"], request.param


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_search_writes_the_best_so_far(sent, program, tmp_path):
    words, name = program
    found = tmp_path / "found.json"
    with endless_search(*words, "--save-controller", found) as search:
        search.send_signal(sent)
        printed, said = search.communicate()
    assert search.returncode == 130
    assert said.startswith(f"{name}: interrupted after ")
    assert [path.name for path in tmp_path.iterdir()] == ["found.json"]
    run = nfopidn.simulate(Scenario.published(rng=0), Controller.load(found))
    assert json.loads(printed)["cost"] == pytest.approx(run.metrics["cost"], rel=1e-9)


@pytest.mark.parametrize(
    "both", [(signal.SIGINT, signal.SIGTERM), (signal.SIGTERM, signal.SIGINT)], ids=["int", "term"]
)
def test_a_second_signal_of_either_kind_ends_the_program(both, program, tmp_path):
    words = [
        *program[0],
        "--period",
        "1e6",
        "--dt",
        "0.5",
    ]  # one evaluation takes a tenth of a second
    with endless_search(*words, "--out", tmp_path / "run.csv") as search:
        search.send_signal(both[0])
        while caught(search.pid) >> (both[1] - 1) & 1:
            assert search.poll() is None
        search.send_signal(both[1])
        search.wait()
    assert search.returncode == -both[1]
    assert not list(tmp_path.iterdir())


def test_a_search_in_the_background_lets_ctrl_c_pass(program):
    with endless_search("env", "--ignore-signal=INT", *program[0]) as search:
        assert not caught(search.pid) >> (signal.SIGINT - 1) & 1
        search.send_signal(signal.SIGINT)
        search.send_signal(signal.SIGTERM)
        _, said = search.communicate()
    assert search.returncode == 130
    assert "interrupted" in said


ENDLESS = ["--period", "1e5", "--substeps", "10000", "--integrator", "exact"]  # for many minutes


@pytest.mark.parametrize("option", ["--out", "--save-scenario", "--save-controller"])
def test_what_cannot_be_written_shows_before_the_run(option, sim, tmp_path):
    run = sim(*ENDLESS, option, tmp_path / "none" / "file")
    assert run.returncode == 2
    assert "cannot be written" in run.stderr


def test_what_cannot_be_written_counts_before_divergence(sim, tmp_path):
    run = sim("--frame", "world", "--out", tmp_path)
    assert (run.returncode, run.stdout) == (2, "")


@pytest.mark.parametrize("arguments", [[], ["--json"], ["--help"]])
def test_a_full_standard_output_is_noticed(arguments, sim):
    with Path("/dev/full").open("w") as full:
        run = sim(*arguments, capture_output=False, stdout=full, stderr=subprocess.PIPE)
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert "No space left" in run.stderr


def test_a_written_file_keeps_its_mode_and_a_link_its_place(sim, tmp_path):
    private = tmp_path / "private.csv"
    private.write_text("old")
    private.chmod(0o600)
    link = tmp_path / "link.json"
    link.symlink_to("there.json")
    (tmp_path / "there.json").write_text("old")
    run = sim("--quiet", "--traj", "circle", "--out", private, "--save-scenario", link)
    assert (run.returncode, run.stderr) == (0, "")
    assert private.stat().st_mode & 0o777 == 0o600
    assert link.is_symlink()
    assert (tmp_path / "there.json").read_text().startswith("{")
