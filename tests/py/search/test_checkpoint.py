"""A search that is killed goes on from its checkpoint, to the last bit."""

import json
import os
import random
import signal
import subprocess
import sys
import time

import nfopidn
import nominal
import numpy as np
import pytest
from checkpoints import sealed
from nfopidn import _core
from refusal import refused
from results import same, watcher

BOX = [(-2.0, 3.0), (0.0, 1.0)]
EVALUATIONS = 480_000
PROGRAM = f"""
import sys, nfopidn
print("begun", flush=True)
result = nfopidn.tune(
    robustness=None, structure="extended", rng=5, maxfev={EVALUATIONS}, checkpoint=sys.argv[1]
)
result.to_json(sys.argv[2])
"""


def bowl(x):
    return float(((x - 0.25) ** 2).sum())


def cliff(x):
    return np.inf if x[0] < 0.1 else bowl(x)


class Counted:
    """A function that counts its calls."""

    def __init__(self, func=bowl):
        self.func, self.calls = func, 0

    def __call__(self, x):
        self.calls += 1
        return self.func(x)


def stop_at(step):
    """A callback that ends the search at a step."""
    calls = []

    def callback(result):
        calls.append(result.nfev)
        if len(calls) == step:
            raise StopIteration

    return callback


def search(func=bowl, **arguments):
    return nfopidn.bfoa(func, BOX, **({"rng": 1, "maxfev": 600} | arguments))


@pytest.fixture
def path(tmp_path):
    return tmp_path / "search.checkpoint"


@pytest.mark.parametrize("seed", [1])
def test_a_killed_search_goes_on_to_the_same_result(seed, path, tmp_path):
    """Killed at random moments, mostly after its first save, which comes at half a second."""
    moments = random.Random(seed)
    result = tmp_path / "result.json"
    command = [sys.executable, "-c", PROGRAM, str(path), str(result)]
    killed, records = 0, []
    for _ in range(10):
        with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
            assert process.stdout.readline() == "begun\n"
            try:
                process.wait(timeout=moments.uniform(0.3, 1.2))
                assert process.returncode == 0
                break
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGKILL)
                killed += 1
        if path.exists():  # a whole document, whatever was being written
            records.append(len(json.loads(path.read_text())["record"]))
    else:
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=120)
    assert killed > 0
    assert len(set(records)) > 1  # it went on, not only from the start
    assert records == sorted(records)
    same(
        nfopidn.TuneResult.from_json(result),
        nominal.tune(structure="extended", rng=5, maxfev=EVALUATIONS),
    )


@pytest.mark.parametrize("func", [bowl, cliff])
@pytest.mark.parametrize("method", ["bfoa+", "bfoa", "cma"])
def test_a_stopped_search_goes_on_without_asking_again(method, func, path):
    arguments = {"method": method, "checkpoint": path}
    first, second, whole = Counted(func), Counted(func), Counted(func)
    stopped = search(first, callback=stop_at(4), **arguments)
    assert stopped.message == "The callback asked to stop."
    seen = []
    result = search(second, callback=watcher(seen), **arguments)
    assert second.calls > 0
    assert first.calls + second.calls == 600
    uninterrupted = search(whole, method=method)
    same(result, uninterrupted)
    assert min(step.nfev for step in seen) >= stopped.nfev


def test_a_search_with_several_scenarios_and_a_start_goes_on(path):
    arguments = {
        "scenario": [nfopidn.Scenario.published(rng=0, delay=k) for k in (0, 1)],
        "structure": "incremental",
        "start": nfopidn.Controller.tuned_nominal(),
        "worst_share": 0.5,
        "frozen": {"kp_x": 0.0},
        "rng": 1,
        "maxfev": 1500,
    }
    stopped = nominal.tune(**arguments, checkpoint=path, callback=stop_at(5))
    assert stopped.nfev < 1500
    same(nominal.tune(**arguments, checkpoint=path), nominal.tune(**arguments))


@pytest.mark.parametrize("structure", ["paper", "taps"])
@pytest.mark.parametrize("rng", [None, 0, 7])
def test_a_tuning_goes_on(structure, rng, path):
    arguments = {"structure": structure, "maxfev": 1500}
    stopped = nominal.tune(**arguments, rng=rng, checkpoint=path, callback=stop_at(3))
    result = nominal.tune(**arguments, rng=rng, checkpoint=path)
    assert result.seed == stopped.seed
    same(result, nominal.tune(**arguments, rng=stopped.seed))


@pytest.mark.parametrize("rng", [0, 7])
def test_no_seed_is_the_checkpoint_s(rng, path):
    search(rng=rng, checkpoint=path, callback=stop_at(3))
    same(search(rng=None, checkpoint=path), search(rng=rng))


@pytest.mark.parametrize("method", ["bfoa+", "bfoa", "cma"])
def test_a_finished_search_gives_the_same_result_again(method, path):
    once = search(method=method, checkpoint=path)
    text = path.read_text()
    again = Counted()
    same(search(again, method=method, checkpoint=path), once)
    assert again.calls == 0
    assert json.loads(path.read_text())["record"] == json.loads(text)["record"]
    tuned = nominal.tune(rng=1, maxfev=300, checkpoint=path.with_suffix(".tune"))
    same(nominal.tune(rng=1, maxfev=300, checkpoint=path.with_suffix(".tune")), tuned)


def test_a_name_may_be_text_or_a_path(path):
    once = search(checkpoint=str(path))
    assert path.exists()
    same(search(checkpoint=path), once)
    # The state before, and nothing half written.
    assert sorted(os.listdir(path.parent)) == [path.name, path.name + ".previous"]


def test_ctrl_c_in_func_loses_nothing_that_was_saved(path):
    search(checkpoint=path, callback=stop_at(3))

    def interrupt(x):
        raise KeyboardInterrupt

    result = search(interrupt, checkpoint=path)
    assert result.message == "The search was interrupted; this is the best so far."
    same(search(checkpoint=path), search())


@pytest.mark.parametrize(
    "change",
    [
        {"rng": 2},
        {"maxfev": 601},
        {"stopval": 0.1},
        {"method": "bfoa"},
        {"options": {"cells": 20}},
        {"bounds": [(-2.0, 3.0), (0.0, 1.5)]},
        {"bounds": [(-2.0, 3.0)]},
    ],
)
def test_the_checkpoint_of_another_search_is_refused(change, path):
    arguments = {"bounds": BOX, "rng": 1, "maxfev": 600, "checkpoint": path}
    nfopidn.bfoa(bowl, **arguments)
    text = path.read_text()
    func = Counted()
    with refused(str(path), "is the checkpoint of another search"):
        nfopidn.bfoa(func, **(arguments | change))
    assert func.calls == 0
    assert path.read_text() == text


@pytest.mark.parametrize(
    "change",
    [
        {"scenario": nfopidn.Scenario.published(rng=0, delay=1)},
        {"scenario": [nfopidn.Scenario.published(rng=0)] * 2},
        {"structure": "decoupled"},
        {"structure": {"parameters": "orders-by-channel"}},
        {"frozen": {"kp_x": 0.5}},
        {"tied": {"kp_x": "kp_y"}},
        {"bounds": {"kp_x": (0, 1)}},
        {"worst_share": 0.5},
        {"start": nfopidn.Controller.published()},
    ],
)
def test_the_checkpoint_of_another_tuning_is_refused(change, path):
    arguments = {"rng": 1, "maxfev": 60, "checkpoint": path}
    nominal.tune(**arguments)
    with refused(str(path), "is the checkpoint of another search"):
        nominal.tune(**(arguments | change))


def test_what_does_not_decide_the_course_may_change(path):
    once = nominal.tune(rng=1, maxfev=300, checkpoint=path)
    same(nominal.tune(rng=1, maxfev=300, checkpoint=path, workers=2, maxtime=1e6), once)


def spoilt(**changes):
    return lambda document: sealed(document | changes)


@pytest.mark.parametrize(
    ("spoil", "part"),
    [
        (lambda d: "", ""),
        (lambda d: json.dumps(d)[:-9], ""),
        (lambda d: "[]", ""),
        (lambda d: "\x00" * 100, ""),
        (spoilt(format="nfopidn-controller"), "nfopidn-checkpoint"),
        (spoilt(version=2), "version"),
        (spoilt(version=None), "version"),
        (spoilt(record=3), "record"),
        (spoilt(record=["a"]), "record"),
        (spoilt(record=[None]), "record"),
        (spoilt(record=["nan"]), "record"),
        (spoilt(elapsed="long"), "elapsed"),
        (spoilt(problem=None), "another search"),
        (json.dumps, "digest"),
        (lambda d: sealed({k: v for k, v in d.items() if k != "record"}), "record"),
        (lambda d: sealed({k: v for k, v in d.items() if k != "problem"}), "problem"),
    ],
)
def test_a_broken_checkpoint_is_refused(spoil, part, path):
    search(checkpoint=path)
    text = spoil(json.loads(path.read_text()))
    path.write_text(text)
    func = Counted()
    with refused("checkpoint", str(path), part):
        search(func, checkpoint=path)
    assert func.calls == 0
    assert path.read_text() == text


@pytest.mark.parametrize("rng", [1, None])
def test_a_directory_is_refused(rng, tmp_path):
    func = Counted()
    with refused("checkpoint", str(tmp_path), "directory"):
        search(func, rng=rng, checkpoint=tmp_path)
    assert func.calls == 0


@pytest.mark.parametrize("name", ["none/search.checkpoint", "n" * 300])
def test_an_unwritable_path_is_refused(name, tmp_path):
    func = Counted()
    with refused("checkpoint", name):
        search(func, checkpoint=tmp_path / name)
    assert func.calls == 0


def test_a_pipe_is_refused(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    with refused("checkpoint", "must be a file"):
        search(checkpoint=tmp_path / "pipe")


def long_tuning(**arguments):
    return nominal.tune(rng=3, maxfev=10**7, **arguments)


def test_a_time_that_is_over_does_not_undo_what_was_found(path):
    first = long_tuning(maxtime=0.6, checkpoint=path)
    assert first.message == "The time is up."
    record = json.loads(path.read_text())["record"]
    again = long_tuning(maxtime=0.6, checkpoint=path)
    assert again.nfev == first.nfev
    assert again.fun == first.fun
    assert json.loads(path.read_text())["record"] == record
    longer = long_tuning(maxtime=1.2, checkpoint=path)
    assert longer.nfev > first.nfev
    assert longer.fun <= first.fun


def test_ctrl_c_while_a_search_is_repeated_keeps_the_checkpoint(path, monkeypatch):
    """The core hears of it at its first step, long before the end of the repetition."""

    def ctrl_c(*_):
        raise KeyboardInterrupt

    def soon(*arguments):  # within the core: reading the checkpoint alone takes longer
        signal.setitimer(signal.ITIMER_REAL, 0.005)
        return core(*arguments)

    long_tuning(maxtime=1.0, checkpoint=path)
    text = path.read_text()
    core = _core.run_plan
    monkeypatch.setattr(_core, "run_plan", soon)
    before = signal.signal(signal.SIGALRM, ctrl_c)
    try:
        result = long_tuning(checkpoint=path)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert result.message == "The search was interrupted; this is the best so far."
    assert path.read_text() == text


@pytest.mark.parametrize("workers", [1, 2])
def test_what_a_slow_function_answers_is_saved_before_the_first_step(workers, path):
    """An hour of 10 s calls is not lost: saved within the Latin hypercube's block."""
    slow = SlowAndFinite()
    with pytest.raises(RuntimeError) as caught:
        search(slow, checkpoint=path, workers=workers)
    assert caught.value.best.nfev < 300
    assert len(json.loads(path.read_text())["record"]) >= 20


class SlowAndFinite:
    """Takes long enough for a save to fall due, and fails within the first block of 300."""

    def __init__(self):
        self.end = time.time() + 1.2

    def __call__(self, x):
        until = time.perf_counter() + 0.015
        while time.perf_counter() < until:
            pass
        if time.time() > self.end:
            raise RuntimeError("enough")
        return bowl(x)


def test_a_search_of_another_course_is_refused(path):
    search(checkpoint=path)
    document = json.loads(path.read_text())
    path.write_text(sealed(document | {"course": document["course"] + 1}))
    with refused(str(path), "another course"):
        search(checkpoint=path)


def test_costs_that_are_not_the_objective_s_are_found_out(path):
    nominal.tune(rng=1, maxfev=400, checkpoint=path)
    document = json.loads(path.read_text())
    document["record"][100] = 0.001
    text = sealed(document)
    path.write_text(text)
    with refused(str(path), "0.001"):
        nominal.tune(rng=1, maxfev=400, checkpoint=path)
    assert path.read_text() == text


def test_the_seed_of_a_later_stage_s_checkpoint_is_found(path):
    arguments = {
        "structure": "taps",
        "maxfev": 3000,
        "start": nfopidn.Controller.tuned_nominal(),
    }
    stopped = nominal.tune(**arguments, checkpoint=path, callback=stop_at(2))
    assert not path.exists()  # it was stopped in the stage before the last
    result = nominal.tune(**arguments, checkpoint=path)
    assert result.seed == stopped.seed
    same(result, nominal.tune(**arguments, rng=stopped.seed))
