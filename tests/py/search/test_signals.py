"""The tests themselves: what they start has signals as usual, and a hang is ended and named."""

import subprocess
import sys
from pathlib import Path

import pytest

IGNORED = ["env", "--ignore-signal=INT", "--ignore-signal=TERM", "--ignore-signal=HUP"]


def test_programs_that_tests_start_heed_signals():
    """Also where the tests were started in the background, with the signals ignored."""
    program = (
        "import signal, subprocess, sys\n"
        "{}\n"
        "inner = 'import signal; print([int(signal.getsignal(n) is signal.SIG_IGN)'"
        " ' for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)])'\n"
        "subprocess.run([sys.executable, '-c', inner], check=True)\n"
    )
    for text, expected in (("", "[1, 1, 1]"), ("import conftest", "[0, 0, 0]")):
        run = subprocess.run(
            [*IGNORED, sys.executable, "-c", program.format(text)],
            check=True,
            capture_output=True,
            text=True,
            cwd=Path(__file__).parents[1],
        )
        assert run.stdout.strip() == expected


HANG = """
import threading

def test_before():
    pass

def test_that_hangs():
    threading.Event().wait()
"""


def test_a_hang_is_ended_and_named(tmp_path, repository, pytestconfig):
    if not pytestconfig.pluginmanager.hasplugin("timeout"):
        pytest.fail("pytest-timeout is not installed: a test that hangs would hang the tests")
    (tmp_path / "test_hang.py").write_text(HANG)
    (tmp_path / "pyproject.toml").write_text((repository / "pyproject.toml").read_text())
    words = ["-o", "timeout=1", "-o", "testpaths=.", "-p", "no:cacheprovider", "test_hang.py"]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *words],
        check=False,
        capture_output=True,
        text=True,
        cwd=tmp_path,
    )
    assert run.returncode != 0
    assert "Timeout" in run.stdout + run.stderr
    assert "test_that_hangs" in run.stdout + run.stderr
