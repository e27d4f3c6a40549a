"""A kill at any moment leaves a file as it was or as it was to be: 50 kills at random moments."""

import random
import signal
import subprocess
import sys
import time

import pytest
from nfopidn import Controller

OLD = "precious\n"
RUN = ["--period", "800", "--out", "run.csv", "--save-controller", "controller.json", "--quiet"]
FILES = ["run.csv", "controller.json"]

# Saves two controllers over each other for ever in a process that is killed after a while. Long
# taps make long files.
SAVE = """
import os, random, signal, sys, time
from pathlib import Path
from nfopidn import Controller
target = Path("controller.json")
controllers = [Controller.load(path) for path in sys.argv[1:]]
whole = [Path(path).read_bytes() for path in sys.argv[1:]]
draw = random.Random(2)
controllers[0].save(target)
for _ in range(15):
    child = os.fork()
    while child == 0:
        for controller in controllers:
            controller.save(target)
    time.sleep(draw.uniform(0, 0.05))
    os.kill(child, signal.SIGKILL)
    assert os.WTERMSIG(os.waitpid(child, 0)[1]) == signal.SIGKILL
    assert target.read_bytes() in whole
"""


def kill(process, seconds):
    time.sleep(seconds)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    return process.returncode == -signal.SIGKILL


def test_a_killed_run_leaves_whole_files(executable, tmp_path):
    command = [executable, *RUN]
    begun = time.monotonic()
    subprocess.run(command, cwd=tmp_path, check=True)
    duration = time.monotonic() - begun
    new = {name: (tmp_path / name).read_text() for name in FILES}
    draw = random.Random(1)
    killed = 0
    for _ in range(35):
        for name in FILES:
            (tmp_path / name).write_text(OLD)
        process = subprocess.Popen(command, cwd=tmp_path)
        killed += kill(process, draw.uniform(0, 1.1 * duration))
        for name in FILES:
            assert (tmp_path / name).read_text() in (OLD, new[name])
    assert killed > 0


@pytest.fixture
def two_files(tmp_path):
    """Two controllers of a thousand taps each, as they are saved."""
    paths = [tmp_path / "a.json", tmp_path / "b.json"]
    for path, tap in zip(paths, (0.1, 0.7), strict=True):
        Controller.from_taps([[tap / (j + 3) for j in range(1000)]] * 3).save(path)
    return paths


def test_a_killed_save_leaves_a_whole_file(two_files, tmp_path):
    subprocess.run([sys.executable, "-c", SAVE, *two_files], cwd=tmp_path, check=True)
