"""`nfopidn simulate` does what nfopidn_sim does from the same words."""

import os
import re
import shutil
import signal
import subprocess
import sys

import nfopidn
import pytest
from nfopidn import commands
from test_executable_errors import FAULTS, contents, folder  # noqa: F401  # a fixture

OUTPUTS = ["--out", "r.csv", "--save-scenario", "s.json", "--save-controller", "c.json"]
TUNE = ["--tune", "--maxfev", "150", "--tune-seed", "3"]
# What is done, and what is said without being a fault.
RUNS = {
    "the published run": [],
    "help": ["--help"],
    "json": ["--json"],
    "quiet": ["--quiet"],
    "files": ["--traj", "circle", "--period", "60", *OUTPUTS],
    "diverging": ["--frame", "world", "--json", *OUTPUTS],
    "a table": ["--traj", "timed.csv", "--disturbance", "wind.csv", *OUTPUTS],
    "a file's scenario": ["--scenario", "scenario.json", "--mass", "10", "--memory=7", *OUTPUTS],
    "without a sample time": ["--controller", "by_channel.json"],
    "noise": ["--noise", "0.01,0.02", "--seed", "5"],
    "tuned": [*TUNE, "--json", *OUTPUTS],
    "tuned by a method": [*TUNE, "--method", "cma", "--option", "population=9", *OUTPUTS],
    "a diverging search": ["--tune", "--maxfev", "1", "--structure", "incremental", "--quiet"],
    "no ASCII": ["--traj", "circle", "--out", "Länge.csv"],
    "no UTF-8": ["--traj", "circle", "--out", os.fsdecode(b"r\xe4.csv")],
    "a missing file without UTF-8": ["--traj", os.fsdecode(b"r\xe4.csv")],
}


@pytest.fixture
def simulate(capfd):
    """Run `nfopidn simulate` in this process: exit code, standard output, standard error."""

    def run(*words):
        capfd.readouterr()
        return (commands.main(["simulate", *words]), *capfd.readouterr())

    return run


@pytest.mark.parametrize(
    "words",
    [*RUNS.values(), *(arguments for arguments, _ in FAULTS.values())],
    ids=[*RUNS, *FAULTS],
)
def test_both_do_the_same(words, sim, simulate, folder, tmp_path_factory, monkeypatch):  # noqa: F811
    twin = tmp_path_factory.mktemp("twin")
    shutil.copytree(folder, twin, dirs_exist_ok=True)
    (twin / "hard.json").unlink()
    (twin / "hard.json").hardlink_to(twin / "scenario.json")
    run = sim(*words, cwd=folder)
    monkeypatch.chdir(twin)
    said = run.stderr.replace("nfopidn_sim: ", "nfopidn simulate: ")
    assert simulate(*words) == (
        run.returncode,
        run.stdout.replace("nfopidn_sim", "nfopidn simulate"),
        said,
    )
    assert contents(twin) == contents(folder)


def test_the_version_names_the_command(simulate):
    assert simulate("--version") == (0, f"nfopidn simulate {nfopidn.__version__}\n", "")


def test_the_command_is_listed(capsys):
    with pytest.raises(SystemExit):
        commands.main(["--help"])
    assert re.search(
        r"^    simulate +run a scenario under a controller", capsys.readouterr().out, re.M
    )


def run_python(program, **options):
    settings = {"capture_output": True, "text": True, "timeout": 120}
    line = [sys.executable, "-c", "from nfopidn.commands import main\n" + program]
    return subprocess.run(line, check=False, **(settings | options))


def test_what_python_printed_before_comes_first(tmp_path):
    run = run_python("print('before', end=' ')\nmain(['simulate', '--json'])", cwd=tmp_path)
    assert (run.returncode, run.stderr) == (0, "")
    assert run.stdout.startswith('before {"cost":')


def test_python_s_own_handlers_are_back_afterwards(simulate):
    before = signal.signal(signal.SIGTERM, lambda *_: None)
    try:
        own = {one: signal.getsignal(one) for one in (signal.SIGINT, signal.SIGTERM)}
        assert simulate(*TUNE, "--json")[0] == 0
        assert {one: signal.getsignal(one) for one in own} == own
        signal.raise_signal(signal.SIGTERM)  # would end the process
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)
        reader, writer = os.pipe()
        os.close(reader)
        with pytest.raises(BrokenPipeError):  # would end the process, too
            os.write(writer, b"x")
        os.close(writer)
    finally:
        signal.signal(signal.SIGTERM, before)


# Sends this process Ctrl-C once it catches a signal, or once it no longer does.
INTERRUPTION = """
import os, signal, threading
from pathlib import Path
def interrupt():
    while caught() != WANTED:
        pass
    os.kill(os.getpid(), signal.SIGINT)
def caught():
    status = Path("/proc/self/status").read_text()
    return int(status.split("SigCgt:")[1].split()[0], 16) >> (signal.WHICH - 1) & 1
threading.Thread(target=interrupt).start()
"""


def test_a_run_after_an_interrupted_one_is_not_interrupted():
    searches = """
for budget in ("1000000000000", "50"):
    print(main(["simulate", "--tune", "--maxfev", budget, "--quiet"]), flush=True)
"""
    # Python itself has no handler for SIGTERM.
    run = run_python(INTERRUPTION.replace("WHICH", "SIGTERM").replace("WANTED", "1") + searches)
    assert run.stdout.split() == ["130", "0"], run.stderr
    assert run.stderr.startswith("nfopidn simulate: interrupted after ")


def test_ctrl_c_ends_a_run_at_once():
    """As it ends the executable: by the signal, whose handler Python would call much later."""
    endless = """
main(["simulate", "--period", "1e5", "--substeps", "10000", "--integrator", "exact"])
"""
    run = run_python(INTERRUPTION.replace("WHICH", "SIGINT").replace("WANTED", "0") + endless)
    assert (run.returncode, run.stdout, run.stderr) == (-signal.SIGINT, "", "")


def test_a_reader_that_has_gone_ends_the_command():
    reader, writer = os.pipe()
    os.close(reader)
    with os.fdopen(writer, "w") as pipe:
        run = run_python(
            "main(['simulate', '--help'])",
            capture_output=False,
            stdout=pipe,
            stderr=subprocess.PIPE,
        )
    assert (run.returncode, run.stderr) == (-signal.SIGPIPE, "")
