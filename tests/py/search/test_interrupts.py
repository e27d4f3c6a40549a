"""Signals while a search is at work: nothing that was found is lost, and no process is left."""

import os
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager, suppress
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory, TuneResult, bfoa, simulate, tune
from nfopidn.search.interrupts import heeded_signals, user_code
from nfopidn.search.optimise import MESSAGES

BOX = [(-1.0, 1.0)] * 2
INTERRUPTED = MESSAGES["interrupted"]


def bowl(x):
    return float((x**2).sum())


def sender(started, delay):
    """A thread that sends Ctrl-C to the main thread, a time after something has started."""

    def send():
        started.wait()
        threading.Event().wait(delay)
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    return threading.Thread(target=send, daemon=True)


def search_for(kind, started):
    """Run a short search that tells when it has begun."""

    def callback(_):
        started.set()

    if kind == "bfoa":
        return bfoa(bowl, BOX, rng=1, maxfev=3000, callback=callback)
    structure = "taps" if kind == "tune taps" else None
    return tune(rng=1, maxfev=600, structure=structure, callback=callback)


@pytest.mark.parametrize(("kind", "count"), [("tune", 500), ("tune taps", 60), ("bfoa", 200)])
def test_no_interrupt_within_a_call_loses_what_was_found(kind, count):
    """Sent from the first step on until a little after the call has returned."""
    times = [time.perf_counter()]
    for _ in range(3):
        whole = search_for(kind, threading.Event())
        times.append(time.perf_counter())
    span = 1.2 * min(end - begin for begin, end in pairwise(times))
    ended = {"interrupted": 0, "complete": 0, "raised": 0}
    for i in range(count):
        started = threading.Event()
        thread = sender(started, span * i / count)
        thread.start()
        result = None
        try:
            result = search_for(kind, started)
            thread.join()
        except KeyboardInterrupt as interrupt:
            thread.join()
            if result is None:
                result = interrupt.best
                ended["raised"] += 1
        assert 0 < result.nfev <= whole.nfev
        assert result.fun >= whole.fun
        if result.message == INTERRUPTED:
            assert not result.success
            ended["interrupted"] += 1
        else:
            assert result.fun == whole.fun
            ended["complete"] += 1
    assert ended["interrupted"] > count / 20, ended
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_interrupt_before_any_answer_is_passed_on_with_the_empty_result():
    def func(x):
        signal.raise_signal(signal.SIGINT)
        return bowl(x)

    with pytest.raises(KeyboardInterrupt) as caught:
        bfoa(func, BOX, rng=1, maxfev=100)
    best = caught.value.best
    assert (best.nfev, best.fun, best.success) == (0, float("inf"), False)
    assert best.message == "KeyboardInterrupt was raised; nothing was answered before."


def test_an_interrupt_before_tunes_first_cost_has_no_best():
    """The first run of a path of a million samples lasts longer than a first answer is given."""
    t = np.linspace(0, 100, 1_000_000)
    path = Trajectory.from_samples(np.cos(t), np.sin(t), 0.01)
    scenario = Scenario(path, substeps=1000, initial_velocity="reference")
    started = threading.Event()
    thread = sender(started, 0.05)
    thread.start()
    started.set()
    with pytest.raises(KeyboardInterrupt) as caught:
        tune(scenario, rng=1, maxfev=100)
    thread.join()
    assert caught.value.best is None


def test_an_interrupt_that_func_swallows_ends_the_search_all_the_same():
    calls = []

    def func(x):
        calls.append(x)
        if len(calls) == 30:
            with suppress(KeyboardInterrupt):
                signal.raise_signal(signal.SIGINT)
        return bowl(x)

    result = bfoa(func, BOX, rng=1, maxfev=10**6)
    assert result.message == INTERRUPTED
    assert len(calls) < 10**6


def test_an_interrupt_in_an_inner_search_ends_the_outer_one_too():
    inner = []

    def func(x):
        def own(y):
            if len(inner) == 5:
                signal.raise_signal(signal.SIGINT)
            return bowl(y)

        inner.append(bfoa(own, BOX, rng=1, maxfev=30).nfev)
        return bowl(x)

    result = bfoa(func, BOX, rng=1, maxfev=10**6)
    assert (result.message, result.nfev) == (INTERRUPTED, 5)
    assert inner == [30] * 5


def test_a_handler_of_the_program_s_own_stays():
    heard = []
    before = signal.signal(signal.SIGINT, lambda *_: heard.append(1))
    try:
        with heeded_signals() as requests:
            signal.raise_signal(signal.SIGINT)
            assert (heard, requests.asked) == ([1], False)
        assert tune(rng=1, maxfev=200).message != INTERRUPTED
    finally:
        signal.signal(signal.SIGINT, before)


def test_signals_are_noted_in_the_library_and_raised_in_the_user_s_code():
    with heeded_signals() as requests:
        signal.raise_signal(signal.SIGINT)
        assert requests.is_asked()
        with heeded_signals() as inner, pytest.raises(KeyboardInterrupt), user_code(inner):
            signal.raise_signal(signal.SIGINT)
        assert inner is requests
        signal.raise_signal(signal.SIGINT)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_other_threads_have_no_signals():
    found = []
    thread = threading.Thread(target=lambda: found.append(tune(rng=1, maxfev=200)))
    thread.start()
    thread.join()
    assert found[0].fun == tune(rng=1, maxfev=200).fun


# Worker processes


class Slow:
    """Answers at once until so many calls of all processes, then never."""

    def __init__(self, folder, calls):
        self.folder, self.calls = folder, calls

    def __call__(self, x):
        (self.folder / f"pid {os.getpid()}").touch()
        with (self.folder / "calls").open("a") as calls:
            calls.write("x")
        if (self.folder / "calls").stat().st_size > self.calls:
            (self.folder / "slow").touch()
            threading.Event().wait()
        return bowl(x)


def workers_in(folder):
    return [int(path.name.split()[1]) for path in folder.glob("pid *")]


def is_running(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except (FileNotFoundError, ProcessLookupError):
        return False
    return state not in "ZX"  # a zombie is for its new parent to collect


def wait_until(condition):
    """A test that waits too long is ended by its time limit."""
    while not condition():
        threading.Event().wait(0.01)


def test_ctrl_c_twice_while_workers_are_busy_returns_the_best(tmp_path):
    """The workers never answer: they are ended, and none is left."""

    def send():
        wait_until((tmp_path / "slow").exists)
        for _ in range(2):
            signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
            threading.Event().wait(0.005)

    thread = threading.Thread(target=send, daemon=True)
    thread.start()
    result = None
    try:
        result = bfoa(Slow(tmp_path, 40), BOX, rng=1, workers=2, method="bfoa", maxfev=10**6)
        thread.join()
    except KeyboardInterrupt as interrupt:  # the second came when the call had returned, or did
        thread.join()
        result = interrupt.best if result is None else result
    assert result.message == INTERRUPTED
    assert result.nfev >= 20
    assert result.fun == bowl(result.x)
    assert not any(map(is_running, workers_in(tmp_path)))


PROGRAM = """
import sys
from pathlib import Path
sys.path[:0] = {folders!r}
from nfopidn import bfoa
from test_interrupts import BOX, Slow
bfoa(Slow(Path({folder!r}), 0), BOX, rng=1, workers=2)
"""


@pytest.mark.parametrize("sent", [signal.SIGKILL, signal.SIGTERM, signal.SIGHUP])
def test_workers_end_with_their_parent(sent, tmp_path):
    folders = [str(folder) for folder in Path(__file__).parents[:2]]
    program = PROGRAM.format(folders=folders, folder=str(tmp_path))
    with subprocess.Popen([sys.executable, "-c", program]) as parent:
        try:
            wait_until(lambda: len(workers_in(tmp_path)) == 2 or parent.poll() is not None)
            workers = workers_in(tmp_path)
            assert len(workers) == 2
            assert all(map(is_running, workers))
            parent.send_signal(sent)
            assert parent.wait() == -sent
        finally:
            parent.kill()
    wait_until(lambda: not any(map(is_running, workers)))


# nfopidn tune


def caught(pid):
    """The signals that a process has a handler for, a bit each."""
    status = Path(f"/proc/{pid}/status").read_text()
    return int(status.split("SigCgt:")[1].split()[0], 16)


@contextmanager
def endless_tuning(folder, *words):
    """`nfopidn tune` without an end, once it heeds SIGTERM."""
    command = [
        sys.executable,
        "-m",
        "nfopidn",
        "tune",
        "--maxfev",
        str(10**12),
        *words,
    ]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen(command, cwd=folder, text=True, **pipes) as search:
        try:
            while not caught(search.pid) >> (signal.SIGTERM - 1) & 1:
                assert search.poll() is None
            yield search
        finally:
            search.kill()


@pytest.mark.parametrize("structure", ["paper", "taps"])
@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_command_writes_the_best_so_far(sent, structure, tmp_path):
    words = ("--structure", structure, "--result", "result.json", "--seed", "1")
    with endless_tuning(tmp_path, *words) as search:
        search.send_signal(sent)
        printed, said = search.communicate()
    assert (search.returncode, said) == (130, "")
    assert INTERRUPTED in printed
    assert sorted(os.listdir(tmp_path)) == ["controller.json", "result.json"]
    result = TuneResult.from_json(tmp_path / "result.json")
    assert result.controller == Controller.load(tmp_path / "controller.json")
    cost = simulate(Scenario.published(rng=0), result.controller).cost
    assert cost == pytest.approx(result.fun, rel=1e-6)


def test_a_second_signal_of_either_kind_ends_the_command(tmp_path):
    with heeded_signals((signal.SIGINT, signal.SIGTERM), second_ends=True) as requests:
        signal.raise_signal(signal.SIGTERM)
        assert requests.asked
        for one in (signal.SIGINT, signal.SIGTERM):
            assert signal.getsignal(one) == signal.SIG_DFL
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_an_ignored_signal_stays_ignored(tmp_path):
    command = ["env", "--ignore-signal=INT", sys.executable, "-c"]
    program = (
        "import os, signal, nfopidn\n"
        "end = lambda _: os.kill(os.getpid(), signal.SIGINT)\n"
        "print(nfopidn.tune(rng=1, maxfev=600, callback=end).message)\n"
    )
    run = subprocess.run([*command, program], check=True, capture_output=True, text=True)
    assert run.stdout == "The budget of evaluations is used up.\n"
