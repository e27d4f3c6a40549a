"""What the tests share: the golden data, the published run, the executable."""

import json
import os
import signal
import subprocess
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before NumPy: its threads spin on busy cores

import numpy as np
import pytest

os.environ["MPLBACKEND"] = "Agg"  # before any import of Matplotlib

import matplotlib.pyplot as plt
import nfopidn
from nfopidn import Controller, Scenario

# Where the tests themselves were started in the background of a script, or under nohup, signals are
# ignored, and so they would be in every program that a test starts.
for number, usual in (
    (signal.SIGINT, signal.default_int_handler),
    (signal.SIGTERM, signal.SIG_DFL),
    (signal.SIGHUP, signal.SIG_DFL),
):
    if signal.getsignal(number) is signal.SIG_IGN:
        signal.signal(number, usual)

REPOSITORY = Path(__file__).resolve().parents[2]
GOLDEN = REPOSITORY / "tests" / "golden"


@pytest.fixture(autouse=True)
def _close_figures():
    yield
    plt.close("all")


@pytest.fixture(scope="session")
def repository():
    return REPOSITORY


@pytest.fixture(scope="session")
def golden_run():
    """Columns of the published run by name, from the independent implementation."""
    path = GOLDEN / "published_run.csv"
    with path.open() as lines:
        names = lines.readline().strip().split(",")
    return dict(zip(names, np.loadtxt(path, delimiter=",", skiprows=1).T, strict=True))


@pytest.fixture(scope="session")
def golden_costs():
    return json.loads((GOLDEN / "costs.json").read_text())


@pytest.fixture(scope="session")
def published():
    """The published run. Its scenario has seed 0, as the executable's has."""
    return nfopidn.simulate(Scenario.published(rng=0))


@pytest.fixture
def controller():
    return Controller.published()


@pytest.fixture
def scenario():
    return Scenario.published(rng=0)


@pytest.fixture(scope="session")
def executable():
    path = Path(os.environ.get("NFOPIDN_SIM", REPOSITORY / "build" / "nfopidn_sim"))
    if not os.access(path, os.X_OK):
        pytest.fail(f"no executable {path}: build the project, or set NFOPIDN_SIM to where it is")
    return path


@pytest.fixture(scope="session")
def sim(executable):
    """Run nfopidn_sim. A run that hangs fails; none here takes two seconds."""

    def run(*arguments, **options):
        command = [str(argument) for argument in (executable, *arguments)]
        settings = {"capture_output": True, "text": True, "errors": "replace", "timeout": 60}
        return subprocess.run(command, check=False, **(settings | options))

    return run
