"""Input without an end is refused before it fills the memory."""

import subprocess

import nfopidn
import pytest
from nfopidn import Controller, Rival, Scenario, Trajectory, TuneResult
from nfopidn import files as _files
from refusal import refused

READERS = {
    "scenario": Scenario.load,
    "controller": Controller.load,
    "rival": Rival.load,
    "trajectory": Trajectory.from_csv,
    "result": TuneResult.from_json,
    "controller or rival": _files.load_controller,
}


@pytest.mark.parametrize("read", READERS.values(), ids=READERS.keys())
def test_a_device_of_zeros_is_refused(read):
    with refused("/dev/zero", "holds a byte 0; must be text"):
        read("/dev/zero")


@pytest.mark.parametrize(
    "words",
    [
        ["--scenario", "/dev/zero"],
        ["--controller", "/dev/zero"],
        ["--traj", "zero.csv"],
        ["--disturbance", "zero.csv"],
    ],
    ids=lambda words: words[0],
)
def test_the_executable_refuses_it(words, sim, tmp_path):
    (tmp_path / "zero.csv").symlink_to("/dev/zero")
    run = sim(*words, cwd=tmp_path)
    assert run.returncode == 2
    assert "holds a byte 0; must be text" in run.stderr
    assert run.stderr.count("\n") == 1


def test_a_pipe_without_an_end_is_refused(sim):
    """Spaces are text, and there are ever more of them: the file may not be larger than 1 GiB."""
    with subprocess.Popen(["yes", " "], stdout=subprocess.PIPE) as spaces:
        run = sim("--scenario", "/dev/stdin", stdin=spaces.stdout)
        spaces.kill()
    assert run.returncode == 2
    assert "is larger than 1073741824 bytes" in run.stderr


def test_a_pipe_with_an_end_is_read(sim, scenario):
    run = sim("--scenario", "/dev/stdin", "--json", input=scenario.to_json())
    assert run.returncode == 0
    assert nfopidn.simulate(scenario).cost == pytest.approx(
        float(run.stdout.split('"cost":')[1].split(",")[0]), rel=1e-12
    )
