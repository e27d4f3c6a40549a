"""The firmware example in the emulator, and the gates on its control object."""

import json
import shutil
import subprocess
import sys

import pytest

TOOLS = ("cmake", "ninja", "arm-none-eabi-g++", "arm-none-eabi-nm", "qemu-system-arm")


@pytest.fixture(scope="module")
def report(repository):
    """Figures of examples/firmware/run.py, which builds and runs."""
    missing = [tool for tool in TOOLS if shutil.which(tool) is None]
    if missing:
        pytest.fail(f"no {', '.join(missing)}: ./dev firmware installs what it needs")
    figures = repository / "build" / "firmware" / "figures.json"
    figures.unlink(missing_ok=True)
    done = subprocess.run(
        [sys.executable, repository / "examples/firmware/run.py", "--json", figures],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    print(done.stdout)
    if not figures.exists():
        pytest.fail(done.stdout + done.stderr)
    return json.loads(figures.read_text())


def test_every_torque_has_the_hosts_bits(report):
    assert report["torques"] == 2 * (751 + 600)
    assert report["bits_differ"] == 0


def test_float_stays_by_double(report):
    assert 0 < report["error_run"] <= 1e-4
    assert 0 < report["error_step"] <= 1e-6


def test_instructions(report):
    assert report["steps_counted"] == 2 * 751 + 600
    assert 150 < report["instructions_worst_recorded"] <= report["instructions_worst"] <= 280
    # Two ways of counting: one by one, and by the timer, with the call and the loop around it.
    overhead = report["instructions_by_icount"] - report["instructions_mean_recorded"]
    assert 0 <= overhead <= 12


def test_the_tracking_law(report):
    assert report["tracking_torques"] == 2 * (751 + 600)
    assert report["tracking_bits_differ"] == 0
    assert 0 < report["tracking_error_run"] <= 1e-4
    assert 0 < report["tracking_error_step"] <= 1e-6
    assert report["instructions_worst"] < report["tracking_instructions_worst"] <= 520
    # The logarithm is a function of its own, and counts too.
    mean = report["tracking_instructions_mean_recorded"]
    assert 0 <= report["tracking_instructions_by_icount"] - mean <= 12
    assert report["tracking_flash_step"] <= 2300
    assert report["tracking_ram_all"] <= 320
    assert report["tracking_stack"]["control_step"] <= 128
    assert report["tracking_symbols"] == 0
    assert set(report["tracking_undefined"]) <= {"memset", "memcpy", "memmove"}


def test_memory(report):
    assert report["flash_step"] <= 1200
    assert report["ram_memory"] <= 192
    assert report["ram_all"] <= 240
    assert report["ram_any_structure"] <= 240
    assert report["stack"]["control_step"] <= 64
    assert report["stack"]["control_reset"] <= 64


def test_control_object_needs_nothing_but_memory_functions(report):
    assert report["symbols"] == 0
    assert set(report["undefined"]) <= {"memset", "memcpy", "memmove"}


@pytest.mark.parametrize(
    "symbol",
    ["malloc", "_Znwj", "_ZdlPvj", "__aeabi_dadd", "__aeabi_f2d", "__cxa_throw", "__aeabi_d2f"],
)
def test_the_gate_knows_what_is_forbidden(repository, monkeypatch, symbol):
    monkeypatch.syspath_prepend(repository / "examples" / "firmware")
    import run  # noqa: PLC0415

    assert run.FORBIDDEN.search(symbol)
    assert not run.FORBIDDEN.search("memset")
    assert not run.FORBIDDEN.search("control_step")
