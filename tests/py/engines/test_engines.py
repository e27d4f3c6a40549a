"""What workers= takes, and that nothing depends on it: pools of Python's own, and functions."""

import functools
import multiprocessing
import os
import pickle
import resource
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing.pool import ThreadPool

import nfopidn
import numpy as np
import pytest
from nfopidn import Controller, Scenario, bfoa, monte_carlo, tune
from nfopidn.engines import (
    EngineError,
    Processes,
    Work,
    processors,
    read_threads,
    read_workers,
    serving,
    work,
)
from nfopidn.engines.pace import LONGEST, Pace
from nfopidn.montecarlo import Normal
from refusal import refused
from results import same

BOX = [(-2.0, 2.0)] * 3
SCENARIO = Scenario.published(pose_noise=(0.005, 0.005), rng=0)
CONTROLLER = Controller.published()


def bowl(x):
    return float(((x - 0.3) ** 2).sum())


def double(span):
    first, count = span
    return [2 * item for item in range(first, first + count)]


def cut(first, count):
    return first, count


def doubles(engine, count=100, function=double, **settings):
    """Every answer at its item's place, and the sizes of the blocks."""
    found = np.full(count, -1)
    with engine, Work(engine, function, "double", **settings) as started:
        put(found, started.blocks(count, cut))
    return found


def put(found, blocks):
    for block in blocks:
        found[block.first : block.first + block.size] = block.answer


@pytest.fixture(scope="module")
def pool():
    with ProcessPoolExecutor(2) as made:
        yield made


@pytest.fixture(scope="module")
def threads():
    with ThreadPoolExecutor(2) as made:
        yield made


class Backwards(Executor):
    """Finishes what it was given in the opposite order, as soon as it has three."""

    def __init__(self):
        self.waiting = []

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        self.waiting.append((future, functools.partial(fn, *args, **kwargs)))
        if len(self.waiting) == 3:
            self.flush()
        return future

    def flush(self):
        while self.waiting:
            future, call = self.waiting.pop()
            try:
                future.set_result(call())
            except BaseException as error:
                future.set_exception(error)

    _max_workers = 3  # six blocks out at a time: always a whole number of threes


def backwards_map(function, calls):
    return [function(call) for call in list(calls)[::-1]]


@pytest.fixture(scope="module")
def imap():
    with ThreadPool(2) as made:
        yield made.imap_unordered


@pytest.fixture(params=["pool", "threads", "imap", "map", "two"])
def engine(request):
    simple = {"map": backwards_map, "two": 2}
    return simple.get(request.param) or request.getfixturevalue(request.param)


# the same bits


def test_bfoa(engine):
    same(
        bfoa(bowl, BOX, rng=1, maxfev=400, workers=engine),
        bfoa(bowl, BOX, rng=1, maxfev=400),
    )


RIVAL = {"structure": "kanayama", "robustness": None}
TAPS = {"structure": "taps", "robustness": None}
FAMILY = {"scenario": Scenario.published(rng=0)}


@pytest.mark.parametrize("search", [{"robustness": None}, RIVAL, TAPS, FAMILY])
def test_tune(engine, search):
    settings = {"scenario": Scenario.published(rng=0), "rng": 1, "maxfev": 300} | search
    same(tune(**settings, workers=engine), tune(**settings))


RUNS = {"rng": 3, "distributions": {"mass": Normal(11.5, 0.5)}}


@pytest.mark.parametrize("method", ["independent", "latin-hypercube", "sobol"])
def test_monte_carlo(engine, method):
    request = {**RUNS, "method": method, "columns": ("cost", "position_rms")}
    one = monte_carlo(SCENARIO, CONTROLLER, 512, **request)
    other = monte_carlo(SCENARIO, CONTROLLER, 512, **request, workers=engine)
    for name, column in one.metrics.items():
        assert (other.metrics[name] == column).all()
    assert other.replay(77).to_json() == one.replay(77).to_json()


def test_monte_carlo_of_a_family(engine):
    family = SCENARIO.variations("standard")
    one = monte_carlo(family, CONTROLLER, 200, rng=3)
    assert (monte_carlo(family, CONTROLLER, 200, rng=3, workers=engine).costs == one.costs).all()


def test_compare(engine):
    controllers = {"published": CONTROLLER, "other": [CONTROLLER, Controller.recommended()]}
    scenarios = {"calm": Scenario.published(rng=0), "noisy": SCENARIO}
    one = nfopidn.compare(controllers, scenarios, seeds=2)
    other = nfopidn.compare(controllers, scenarios, seeds=2, workers=engine)
    assert list(other.first_runs) == list(one.first_runs)
    assert (other.draws == one.draws).all()
    for name, values in one.values.items():
        np.testing.assert_array_equal(other.values[name], values)
    for pair, run in one.first_runs.items():
        assert (other.first_runs[pair].columns["x"] == run.columns["x"]).all()


def test_basin(engine):
    grid = {"x": np.linspace(2, 4, 7), "y": np.linspace(-1, 1, 5)}
    one = nfopidn.stability.basin(**grid, workers=1)
    other = nfopidn.stability.basin(**grid, workers=engine)
    assert (other.position_error == one.position_error).all()
    assert (other.heading_error == one.heading_error).all()


# the one way of blocks


def test_blocks_come_in_any_order():
    executor = Backwards()
    engine = read_workers(executor)
    firsts = []
    found = np.full(18, -1)
    with Work(engine, double, "double") as started:
        started.pace.size = lambda left, count, workers: 1
        for block in started.blocks(18, cut):
            firsts.append(block.first)
            found[block.first : block.first + block.size] = block.answer
    assert firsts != sorted(firsts)
    assert (found == 2 * np.arange(18)).all()


class Sent:
    """A function that counts how often it is unpickled, in each process."""

    made = 0

    def __init__(self):
        type(self).made += 1

    def __reduce__(self):
        return Sent, ()

    def __call__(self, span):
        return [(os.getpid(), Sent.made)] * span[1]


def test_a_worker_unpickles_the_function_once(pool):
    engine = read_workers(pool)
    answers = []
    with Work(engine, Sent(), "sent") as started:
        started.pace.size = lambda left, count, workers: 1
        for _ in range(2):
            answers += [block.answer[0] for block in started.blocks(40, cut)]
    counts = {}
    for process, count in answers:
        counts.setdefault(process, set()).add(count)
    assert os.getpid() not in counts
    assert len(answers) == 80
    # What was forked off after this process made its own has that one besides.
    assert all(len(seen) == 1 and max(seen) <= 2 for seen in counts.values())


def test_a_worker_that_does_not_know_the_function_is_sent_it():
    name, busy, answer = serving.serve("nobody's token", None, nfopidn.__version__, (0, 3))
    assert (busy, answer) == (0.0, None)
    assert name == serving.worker_name()
    payload = pickle.dumps(double)
    assert serving.serve("some token", payload, nfopidn.__version__, (1, 2))[2] == ([2, 4],)
    assert serving.serve("some token", None, nfopidn.__version__, (2, 1))[2] == ([4],)


def test_a_worker_of_another_version_is_refused():
    with pytest.raises(serving.VersionError, match=r"has nfopidn .*, the caller 0\.0\.1; must be"):
        serving.serve("another token", pickle.dumps(double), "0.0.1", (1, 2))


def test_functions_are_forgotten(threads):
    before = len(serving._own)
    doubles(read_workers(threads))
    assert len(serving._own) == before
    for number in range(10):
        serving.serve(f"token {number}", pickle.dumps(double), nfopidn.__version__, (0, 1))
    assert len(serving._sent) <= serving._KEPT


def test_blocks_of_nothing(threads):
    assert len(doubles(read_workers(threads), count=0)) == 0


def test_the_pace_hides_what_sending_takes():
    pace = Pace(first=4)
    assert pace.size(1000, 1000, 2) == 4
    pace.note(4, busy=4e-6, elapsed=1e-3)  # a microsecond an item, a millisecond to send it
    assert pace.size(18, 18, 2) == 18  # all in one block: it is done before a second one is sent
    assert pace.size(10**6, 10**6, 2) == 166_667
    assert pace.size(6000, 10**6, 2) == 1992  # the last ones no smaller than twice the sending
    pace = Pace(first=4)
    pace.note(1, busy=0.2, elapsed=0.201)
    assert pace.size(100, 100, 2) == int(LONGEST / 0.2)
    assert pace.size(4, 100, 2) == 1
    pace.note(1, busy=0.2, elapsed=0.21)
    assert pace.size(10**6, 10**6, 1000) == int(1000 * 1e-3 / 4 / 0.2) + 1 == 2


def test_the_pace_gives_all_and_no_more():
    for item, overhead in ((1e-7, 1e-3), (1e-3, 1e-3), (1.0, 1e-3), (100.0, 1e-4), (1e-3, 0.0)):
        pace = Pace(first=1)
        pace.note(1, item, item + overhead)
        left = 1000
        while left:
            size = pace.size(left, 1000, 3)
            assert 1 <= size <= left
            left -= size


# what workers may be


def test_processors_are_those_of_the_process():
    assert processors() == len(os.sched_getaffinity(0))
    assert read_threads(-1) == read_workers(-1) == processors()


CALLS = [
    lambda workers: bfoa(bowl, BOX, rng=1, maxfev=20, workers=workers),
    lambda workers: tune(SCENARIO, rng=1, maxfev=20, workers=workers),
    lambda workers: monte_carlo(SCENARIO, CONTROLLER, 10, rng=1, workers=workers),
    lambda workers: nfopidn.compare([CONTROLLER], {"noisy": SCENARIO}, workers=workers),
    lambda workers: nfopidn.stability.basin(workers=workers),
    lambda workers: nfopidn.study.reproduce("nowhere", workers=workers),
]
NAMES = ["bfoa", "tune", "monte_carlo", "compare", "basin", "study"]
KINDS = "must be a whole number in [1, 1024], -1 for all processors, an Executor"


@pytest.mark.parametrize("call", CALLS, ids=NAMES)
def test_what_is_no_engine_is_refused(call):
    for workers in ("all", 1.5, True, [2]):
        with refused(f"workers is {workers!r}; must be a whole number in [1, 1024]"):
            call(workers)
    for workers in (0, -2, 1025):
        with refused(f"workers is {workers}; must be a whole number in [1, 1024]"):
            call(workers)
    with refused("ProcessPoolExecutor", KINDS, "the class ProcessPoolExecutor itself is none"):
        call(ProcessPoolExecutor)
    with ThreadPool(1) as given, refused(KINDS, "its function: pool.map"):
        call(given)


@pytest.mark.parametrize("call", CALLS, ids=NAMES)
@pytest.mark.parametrize("kind", [ProcessPoolExecutor, ThreadPoolExecutor])
def test_a_closed_engine_is_refused(call, kind):
    executor = kind(1)
    executor.shutdown()
    with refused(f"workers is a {kind.__name__} that is shut down; must be open"):
        call(executor)


def test_an_engine_that_is_closed_meanwhile_keeps_what_is_done(monkeypatch):
    """The error has the blocks before, and the same checkpoint goes on."""
    executor = ThreadPoolExecutor(1)
    received = work._Course._receive

    def closing(self, handle, block):
        yield from received(self, handle, block)
        executor.shutdown(wait=True, cancel_futures=True)

    monkeypatch.setattr(work._Course, "_receive", closing)
    with pytest.raises(EngineError, match="ThreadPoolExecutor") as caught:
        monte_carlo(SCENARIO, CONTROLLER, 1000, **RUNS, workers=executor)
    kept = caught.value.best.costs
    assert 0 < len(kept) < 1000
    assert (kept == monte_carlo(SCENARIO, CONTROLLER, len(kept), **RUNS).costs).all()


def test_what_cannot_be_pickled_is_said_before_anything_runs(pool):
    with refused("func is", "<lambda>", "can be pickled for a ProcessPoolExecutor", "workers=1"):
        bfoa(lambda x: 1.0, BOX, rng=1, workers=pool)

    class Own:
        def ppf(self, q):
            return 11 + q

        def __reduce__(self):
            raise TypeError("is not to be sent")

    with refused("distributions: must be such that pickle can send it", "TypeError: is not to be"):
        monte_carlo(SCENARIO, CONTROLLER, 10, rng=1, distributions={"mass": Own()}, workers=pool)


def test_threads_and_map_need_no_pickles(threads):
    def local(x):
        return bowl(x)

    one = bfoa(bowl, BOX, rng=1, maxfev=60)
    for workers in (threads, map):
        same(bfoa(local, BOX, rng=1, maxfev=60, workers=workers), one)


def test_the_map_of_another_process_is_sent_the_function_when_it_asks():
    with multiprocessing.Pool(1) as made:  # forked before it could know of the function
        found = doubles(read_workers(made.map))
        with refused("<lambda>: must be such that pickle can send it", "the function map"):
            list(Work(read_workers(made.map), lambda span: 1, "<lambda>").blocks(1, cut))
    assert (found == 2 * np.arange(100)).all()


def test_a_map_that_loses_answers_is_refused():
    for mapping in (
        lambda function, calls: [],
        lambda function, calls: map(function, list(calls)[1:]),
        lambda function, calls: [0] * len(calls),
        lambda function, calls: [function(calls[0])] * 2,
    ):
        with pytest.raises(EngineError, match="has not given"):
            nfopidn.stability.basin(x=[2.0, 3.0, 4.0], y=[0.0], workers=mapping)


# workers that die


class DiesOnce:
    """Kills its process at item 7, until a file says that it has."""

    def __init__(self, mark, at=7):
        self.mark, self.at = mark, at

    def __call__(self, span):
        first, count = span
        if first <= self.at < first + count and not self.mark.exists():
            self.mark.touch()
            os.kill(os.getpid(), signal.SIGKILL)
        return double(span)


@pytest.mark.parametrize("own", [True, False], ids=["processes of the call", "user's pool"])
def test_a_killed_worker_s_block_is_done_again(tmp_path, own):
    with ProcessPoolExecutor(2) as executor:
        engine = Processes(2) if own else read_workers(executor)
        with pytest.warns(RuntimeWarning, match="a process of .* has died"):
            found = doubles(engine, function=DiesOnce(tmp_path / "died"))
    assert (found == 2 * np.arange(100)).all()


def test_a_broken_pool_is_refused(tmp_path):
    with ProcessPoolExecutor(1) as executor:
        executor.submit(os.kill, 0, 0).exception()  # starts it
        process = next(iter(executor._processes.values()))
        process.kill()
        process.join()
        with pytest.raises(BrokenProcessPool):
            executor.submit(os.getpid).result()
        with refused("ProcessPoolExecutor that is broken", "must be a new one"):
            bfoa(bowl, BOX, rng=1, workers=executor)


class DiesAlways:
    def __call__(self, span):
        first, count = span
        if first <= 30 < first + count:
            os.kill(os.getpid(), signal.SIGKILL)
        return double(span)


@pytest.mark.filterwarnings("ignore:a process of:RuntimeWarning")
def test_a_block_that_always_kills_its_worker_ends_the_work_and_is_named():
    found = np.full(100, -1)
    engine = Processes(2)
    with engine, Work(engine, DiesAlways(), "always", "points") as started:
        started.pace.size = lambda left, count, workers: min(left, 4)
        blocks = started.blocks(100, cut)
        with pytest.raises(EngineError) as caught:
            put(found, blocks)
    assert "at each of 3 attempts at points 28 to 31" in str(caught.value)
    assert "memory" in str(caught.value)
    assert (found[:28] == 2 * np.arange(28)).all()  # no other block is blamed or lost


class TakesTooMuch:
    """Asks for more memory than its process may have."""

    def __call__(self, span):
        hard = resource.getrlimit(resource.RLIMIT_AS)[1]
        resource.setrlimit(resource.RLIMIT_AS, (2**32, hard))
        return len(bytearray(2**33))


def test_a_worker_out_of_memory_is_told_from_other_errors():
    engine = Processes(1)
    with (
        engine,
        Work(engine, TakesTooMuch(), "much", "runs") as started,
        pytest.raises(MemoryError) as caught,
    ):
        list(started.blocks(3, cut))
    (note,) = caught.value.__notes__
    assert "a worker of 1 processes, at runs 0 to 0: fewer workers" in note


def test_what_a_worker_raises_is_raised_here(pool):
    with pytest.raises(ZeroDivisionError) as caught:
        bfoa(divide, BOX, rng=1, maxfev=100, workers=pool)
    assert caught.value.best.nfev >= 0
    same(bfoa(bowl, BOX, rng=1, maxfev=100, workers=pool), bfoa(bowl, BOX, rng=1, maxfev=100))


def divide(x):
    return 1 / 0


# Ctrl-C


class Waits:
    """Bowls, of which a file tells, and then one that never ends."""

    def __init__(self, mark):
        self.mark = mark

    def __call__(self, x):
        with self.mark.open("a") as calls:
            calls.write("x")
        if self.mark.stat().st_size > 60:
            self.mark.with_suffix(".slow").touch()
            time.sleep(3600)
        return bowl(x)


def test_ctrl_c_returns_the_best_of_a_pool(tmp_path):
    mark = tmp_path / "calls"

    def interrupt():
        while not mark.with_suffix(".slow").exists():
            threading.Event().wait(0.01)
        signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    executor = ProcessPoolExecutor(2)
    try:
        thread.start()
        result = bfoa(Waits(mark), BOX, rng=1, method="bfoa", workers=executor)
    finally:
        thread.join()
        for process in executor._processes.values():
            process.kill()
        executor.shutdown()
    assert result.message == "The search was interrupted; this is the best so far."
    assert result.fun == bowl(result.x)


def test_monte_carlo_on_an_engine_goes_on_from_a_checkpoint(tmp_path, threads, monkeypatch):
    """Of one thread the blocks come in order, so that the first ones count."""
    path = tmp_path / "runs.npz"
    one = monte_carlo(SCENARIO, CONTROLLER, 1500, **RUNS)
    block = nfopidn.montecarlo.runs.Analysis.block

    def ending(self, at, count, workers):
        if at + count > 700:
            raise KeyboardInterrupt
        return block(self, at, count, workers)

    with monkeypatch.context() as patch:
        patch.setattr(nfopidn.montecarlo.runs.Analysis, "block", ending)
        with ThreadPoolExecutor(1) as single, pytest.raises(KeyboardInterrupt) as caught:
            monte_carlo(SCENARIO, CONTROLLER, 1500, **RUNS, workers=single, checkpoint=path)
    assert 0 < len(caught.value.best) <= 700
    assert (caught.value.best.costs == one.costs[: len(caught.value.best)]).all()
    again = monte_carlo(SCENARIO, CONTROLLER, 1500, **RUNS, workers=threads, checkpoint=path)
    assert (again.costs == one.costs).all()


def test_nothing_of_the_engines_is_imported_with_the_package():
    names = ["dask", "distributed", "mpi4py", "loky", "cloudpickle"]
    program = f"import nfopidn, sys; print([name for name in {names} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=True)
    assert done.stdout.strip() == b"[]"
