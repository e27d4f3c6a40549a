"""Ctrl-C and maxtime end native work of any length; without them each of these takes hours."""

import os
import signal
import subprocess
import sys
import threading

import nfopidn
import nominal
import numpy as np
import pytest
from nfopidn import Scenario, Trajectory, _core

#: A run that takes hours, a gradient that takes days.
ENDLESS = """
import os, signal, sys, threading, time
import numpy as np
import nfopidn
from nfopidn import Controller, Objective, Rival, Scenario, Trajectory, _core, stability
path = Trajectory.ranunculoid(period=40000.0, laps=20)
long = Scenario(path, substeps=10000, rng=0, **OPTIONS)
paper = Controller.published().to_vector()  # others diverge, which ends a run at once
timer = threading.Timer(0.8, os.kill, (os.getpid(), signal.SIGINT))
timer.start()
try:
    BODY
    print("ended")
except KeyboardInterrupt:
    print("KeyboardInterrupt")
"""
BODIES = {
    "simulate": "nfopidn.simulate(long)",
    "simulate a rival": "nfopidn.simulate(long, Rival('samson'))",
    "simulate a long memory": "nfopidn.simulate(long, Controller.published(memory=5000))",
    "play": "_core.play(long, np.zeros((len(path), 2)))",
    "costs": "Objective(long).costs(np.tile(paper, (400, 1)))",
    "costs in threads": "Objective([long, long], workers=2).costs(np.tile(paper, (400, 1)))",
    "gradient": "Objective(long).gradient(paper)",
    "gradient of taps": "Objective(long, structure={'memory': 40}).gradient(paper)",
    "tune": "nfopidn.tune(long, robustness=None, rng=1)",
    "tune bfoa": "nfopidn.tune(long, robustness=None, rng=1, method='bfoa', workers=2)",
    "tune taps": "nfopidn.tune(long, robustness=None, rng=1, structure='taps')",
    "tune a rival": "nfopidn.tune(long, robustness=None, rng=1, structure='samson')",
    "compare": "nfopidn.compare([Controller.published()], {'long': long}, seeds=20000)",
    "compare in threads": (
        "nfopidn.compare([Controller.published(), Rival('lqr')], {'long': long, 'same': long},"
        " workers=2)"
    ),
    "basin": "stability.basin(long, Controller.published())",
}


def interrupted(body, options="{}"):
    """Run a program that interrupts itself while the core is at work."""
    program = ENDLESS.replace("BODY", body).replace("OPTIONS", options)
    run = subprocess.run(
        [sys.executable, "-c", program], check=False, capture_output=True, text=True, timeout=120
    )
    assert run.stderr == ""
    return run.stdout


@pytest.mark.parametrize("body", BODIES.values(), ids=BODIES.keys())
def test_ctrl_c_ends_it(body):
    assert interrupted(body) == "KeyboardInterrupt\n"


@pytest.mark.parametrize("name", ["simulate", "costs", "gradient", "tune"])
def test_ctrl_c_ends_it_with_the_exact_integrator(name):
    assert interrupted(BODIES[name], "{'integrator': 'exact'}") == "KeyboardInterrupt\n"


def test_ctrl_c_ends_the_searches_of_contenders():
    body = "print(nfopidn.tune_contenders(['samson', 'paper'], long, seeds=2, workers=2))"
    assert interrupted(body) == "{}\nended\n"


def test_compare_of_many_short_runs_ends():
    body = (
        "noisy = Scenario.published(pose_noise=(0.001, 0.001), rng=0)\n"
        "    nfopidn.compare([Controller.published()], {'noisy': noisy}, seeds=10**7, workers=2)"
    )
    assert interrupted(body) == "KeyboardInterrupt\n"


def endless():
    path = Trajectory.ranunculoid(period=40000.0, laps=20)
    return Scenario(path, substeps=10000, rng=0)


@pytest.mark.parametrize("method", ["bfoa+", "bfoa"])
@pytest.mark.parametrize("structure", ["paper", "taps", "samson"])
def test_a_time_that_is_over_before_the_first_cost_is_said(method, structure, tmp_path):
    path = tmp_path / "search"
    with pytest.raises(ValueError, match="maxtime was over before the first cost was known"):
        nominal.tune(
            endless(), structure=structure, method=method, rng=1, maxtime=0.2, checkpoint=path
        )


def test_a_context_that_ends_the_work_of_a_thread():
    event = threading.Event()
    raised = []

    def work():
        try:
            with _core.StopIf(event.is_set):
                nfopidn.simulate(endless())
        except KeyboardInterrupt as error:
            raised.append(error)
        raised.append(nfopidn.simulate().cost)  # not the work after it

    thread = threading.Thread(target=work)
    thread.start()
    event.set()
    thread.join()
    assert len(raised) == 2
    assert raised[1] == nfopidn.simulate().cost


def test_what_a_signal_s_handler_raises_comes_through():
    class WishError(Exception):
        pass

    def handler(*_):
        raise WishError

    before = signal.signal(signal.SIGALRM, handler)
    signal.setitimer(signal.ITIMER_REAL, 0.2)
    try:
        with pytest.raises(WishError):
            nfopidn.simulate(endless())
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def test_an_interrupted_filter_is_as_before():
    half, other = (nfopidn.fractional.FractionalFilter(0.5, 0.01, memory=1000) for _ in range(2))
    start = np.linspace(0, 1, 100)
    np.testing.assert_array_equal(half.stream(start), other.stream(start))
    with pytest.raises(KeyboardInterrupt), _core.StopIf(lambda: True):
        half.stream(np.ones(200_000))
    np.testing.assert_array_equal(half.stream(start), other.stream(start))


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_the_executable_ends_a_search_before_its_first_cost(sent, executable, tmp_path):
    words = ["--tune", "--period", "40000", "--substeps", "10000", "--out", tmp_path / "run.csv"]
    with subprocess.Popen([executable, *words], stderr=subprocess.PIPE, text=True) as process:
        while not caught(process.pid) >> (sent - 1) & 1:
            assert process.poll() is None
        process.send_signal(sent)
        _, said = process.communicate()
    assert process.returncode == 130
    assert said == "nfopidn_sim: interrupted after 0 evaluations\n"
    assert os.listdir(tmp_path) == []


def caught(pid):
    """The signals that a process has a handler for, a bit each."""
    with open(f"/proc/{pid}/status", encoding="ascii") as status:
        return int(status.read().split("SigCgt:")[1].split()[0], 16)
