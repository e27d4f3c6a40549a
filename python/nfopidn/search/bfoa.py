"""Bacterial foraging for any function, with SciPy's conventions."""

from __future__ import annotations

import pickle
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nfopidn import _core
from nfopidn.arguments import real_numbers
from nfopidn.engines import Engine, Processes, Work, read_workers
from nfopidn.engines import Mapping as MapEngine
from nfopidn.search.interrupts import StopRequests, heeded_signals, user_code
from nfopidn.search.optimise import (
    UNLIMITED,
    Array,
    Callback,
    OptimizeResult,
    Settings,
    check_bounds,
    check_settings,
    deny_success,
    finish,
    returned,
    run,
)

Map = Callable[..., Iterable[Any]]
Box = tuple[Array, Array]


def bfoa(
    func: Callable[..., Any],
    bounds: Sequence[tuple[float, float]] | ArrayLike | Any,
    args: tuple[Any, ...] = (),
    *,
    method: str = "bfoa+",
    options: Mapping[str, Any] | None = None,
    rng: Any = None,
    seed: Any = None,
    maxfev: int | None = None,
    maxtime: float | None = None,
    stopval: float | None = None,
    callback: Callback | None = None,
    x0: ArrayLike | None = None,
    vectorized: bool = False,
    workers: Any = 1,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
) -> OptimizeResult:
    """Minimise a function within bounds by bacterial foraging.

    A script for scipy.optimize.differential_evolution runs with it too; what differs is how the
    search is set: `method`, `options` and `maxfev` for strategy, popsize, maxiter and the like.

    Parameters
    ----------
    func
        Takes a point (p,) and `args`, and returns its cost, a number or an array of one; or, if
        `vectorized`, takes points (p, n) and returns costs (n,). Infinity is a cost; NaN is
        refused.
    bounds
        (p, 2): low and high of each coordinate; or a scipy.optimize.Bounds. A coordinate whose
        bounds are equal is fixed.
    args
        More arguments of func.
    method
        "bfoa+", the improved variant, or "bfoa", Passino's algorithm.
    options
        Settings of the method; docs/tuning.md lists them.
    rng
        A seed, a numpy.random.Generator, BitGenerator, SeedSequence or RandomState, or None to draw
        a seed, which the result records as `seed`; with a `checkpoint` to go on from, None stands
        for its seed. SciPy's older name `seed` does as well.
    maxfev, maxtime, stopval
        End at this many evaluations (default 10,000 for "bfoa+", one schedule for "bfoa"), after
        this time [s], or at this cost.
    callback
        Called after each chemotactic step. If its only parameter is `intermediate_result`, or
        `result`, it gets an OptimizeResult with x, fun, nfev, mean, step, population,
        population_energies and convergence; else x, and the convergence too if it takes two. The
        convergence is SciPy's: 0.01 of the mean cost of the population over the costs' standard
        deviation. It ends the search by returning True or raising StopIteration.
    x0
        A point to start from (p,), within the bounds.
    vectorized
        Whether func takes a block of points.
    workers
        Processes that evaluate a block's points, -1 for as many as there are processors; an
        Executor as of concurrent.futures (of Python, loky or mpi4py) or a dask.distributed.Client;
        or a function like map, whose answers may come in any order. func must then be one that can
        be pickled, and takes one point: `vectorized` is overridden, with a warning. The result is
        the same with each; docs/scaling.md tells when which is of use.
    checkpoint
        A file from which the same call goes on after an interruption, to the same result. It is
        saved every half second between evaluations; a block, if func is `vectorized` or `workers`
        is a map, is one evaluation.
    progress
        Whether to show a progress bar in a terminal or notebook

    Returns
    -------
    OptimizeResult
        `success` is True if the search came to its own end: a whole schedule, the default number of
        evaluations, or `stopval`. It is False where maxfev, maxtime, the callback or Ctrl-C, which
        returns the best so far, ended it, and where no cost was finite.

    Raises
    ------
    ValueError
        For an argument out of range, and for a cost that is NaN. What func raises is passed on;
        its attribute `best` then holds the result so far.
    EngineError
        The workers keep dying, or were closed meanwhile; `best` as above.
    KeyboardInterrupt
        After Ctrl-C before there was any cost, and in the moment of the return; `best` as above.
    """
    settings = check_settings(
        *(method, options, one_seed(rng, seed), maxfev, maxtime, stopval, checkpoint, progress),
        callback,
    )
    box = read_box(bounds)
    start = read_start(x0, box)
    if not callable(func):
        raise ValueError(f"func is {func!r}; must be a function")
    if not isinstance(args, tuple):
        args = (args,)  # as SciPy takes it
    crew = read_workers(workers)
    if vectorized and crew != 1:
        text = "bfoa: the 'workers' keyword overrides the 'vectorized' keyword"
        warnings.warn(text, UserWarning, stacklevel=2)
        vectorized = False
    own_budget = maxfev is not None

    def search() -> OptimizeResult:
        result = _search(func, box, args, start, settings, callback, vectorized, crew)
        if (result.status == 1 and own_budget) or result.status in (2, 4):
            result.success = False
        return result

    return returned(search)


def one_seed(rng: Any, seed: Any) -> Any:
    """Give what a search is seeded with, of SciPy's two names.

    Raises
    ------
    ValueError
        Both are given.
    """
    if rng is not None and seed is not None:
        raise ValueError(f"rng is {rng!r} and seed is {seed!r}; must be one of them")
    return seed if rng is None else rng


def read_box(bounds: Any) -> Box:
    """Give low and high of bounds (p, 2), or of a scipy.optimize.Bounds, checked."""
    try:
        if hasattr(bounds, "lb") and hasattr(bounds, "ub"):
            bounds = np.column_stack(
                np.broadcast_arrays(*map(np.atleast_1d, (bounds.lb, bounds.ub)))
            )
        box = real_numbers("bounds", bounds)
    except (TypeError, ValueError):
        raise ValueError(f"bounds are {bounds!r}; must be numbers (p, 2)") from None
    if box.ndim != 2 or box.shape[1] != 2 or len(box) == 0:
        raise ValueError(f"bounds have the shape {box.shape}; must be (p, 2)")
    names = [f"coordinate {i}" for i in range(len(box))]
    check_bounds(box[:, 0], box[:, 1], names, may_be_equal=True)
    return box[:, 0].copy(), box[:, 1].copy()


def read_start(x0: Any, box: Box) -> Array | None:
    """Give the point to start from, checked."""
    if x0 is None:
        return None
    start = real_numbers("x0", x0)
    low, high = box
    if start.shape != low.shape:
        raise ValueError(f"x0 has the shape {start.shape}; must be ({len(low)},)")
    for place, value in enumerate(start):
        if not low[place] <= value <= high[place]:
            within = f"[{low[place]:g}, {high[place]:g}]"
            raise ValueError(f"x0 of coordinate {place} is {value:g}; must be in {within}")
    return start


def _search(
    func: Callable[..., Any],
    box: Box,
    args: tuple[Any, ...],
    start: Array | None,
    settings: Settings,
    callback: Callback | None,
    vectorized: bool,
    workers: int | Engine,
) -> OptimizeResult:
    """Search as bfoa() does, with what it has checked."""
    low, high = box
    problem = {"kind": "function"} | ({} if start is None else {"start": start.tolist()})
    with ExitStack() as stack:
        requests = stack.enter_context(heeded_signals())
        block = _blockwise(func, args) if vectorized else _pointwise(func, args, workers, stack)
        request = settings.request(low, high, problem)
        request["start"] = start
        request["most_at_once"] = UNLIMITED
        watched = settings.checkpoint or np.isfinite(settings.maxtime)
        if watched and not vectorized and not isinstance(workers, MapEngine):
            # Time is looked at, and answers are saved, between what is asked for together.
            count = workers if isinstance(workers, int) else workers.count()
            request["most_at_once"] = 1 if count == 1 else 4 * count
        asking = _interruptible(block, requests)
        found, raised = run(
            lambda request: _core.search_function(asking, request),
            request,
            settings,
            callback,
            "bfoa",
        )
    result = OptimizeResult(seed=settings.seed)
    finish(result, found, raised, box)
    if result["fun"] == np.inf:
        deny_success(result, "no_finite_cost")
    return result


def _interruptible(block: Callable[[Array], Any], requests: StopRequests) -> Callable[[Array], Any]:
    """Make a function of points one within which Ctrl-C is heard at once."""

    def called(points: Array) -> Any:
        with user_code(requests):
            return block(points)

    return called


def _blockwise(func: Callable[..., Any], args: tuple[Any, ...]) -> Callable[[Array], Any]:
    """Make a function of points (n, p) from one of points (p, n)."""
    return lambda points: func(points.T, *args)


def _plain_cost(cost: Any) -> float:
    """Give what func returns as a number; of an array of one the one."""
    if type(cost) is float:
        return cost
    if isinstance(cost, str | bytes | bytearray):
        raise TypeError(f"func returned {cost!r}; must return a number")
    if np.shape(cost) != ():
        array = np.asarray(cost)
        if array.size != 1:
            raise ValueError(f"func returned an array of shape {array.shape}; must return a number")
        cost = array.item()
    try:
        return float(cost)
    except OverflowError:
        raise ValueError("func returned a whole number beyond every double") from None


class _Answer(float):
    """A cost that tells of which point it is, by the point's bytes."""

    point: bytes

    def __new__(cls, cost: float, point: bytes) -> _Answer:
        made = super().__new__(cls, cost)
        made.point = point
        return made

    def __reduce__(self) -> tuple[Any, ...]:
        return _Answer, (float(self), self.point)


class _Ask:
    """What a map is given: func of a point, whose answer tells the point."""

    def __init__(self, func: Callable[..., Any], args: tuple[Any, ...]) -> None:
        self.func, self.args = func, args

    def __call__(self, point: Array) -> _Answer:
        asked = point.tobytes()  # before func, which might change it
        return _Answer(_plain_cost(self.func(point, *self.args)), asked)


class _Points:
    """What an engine's workers are given: func of each of some points."""

    def __init__(self, func: Callable[..., Any], args: tuple[Any, ...]) -> None:
        self.func, self.args = func, args

    def __call__(self, points: Array) -> list[float]:
        """Give the costs; what func raises tells those of the points before."""
        costs: list[float] = []
        try:
            for point in points:
                costs.append(_plain_cost(self.func(point, *self.args)))  # kept
        except BaseException as error:
            _tell_answers(error, costs)
            raise
        return costs


def _tell_answers(error: BaseException, costs: list[float]) -> None:
    """Note with an error the costs of the points before it, which the core counts."""
    with suppress(AttributeError, TypeError):
        error._nfopidn_answered = costs  # type: ignore[attr-defined]


def _pointwise(
    func: Callable[..., Any],
    args: tuple[Any, ...],
    workers: int | Engine,
    stack: ExitStack,
) -> Callable[[Array], Array]:
    """Make a function of points (n, p) from one of a point."""
    if workers == 1:
        own = _Points(func, args)  # a plain loop: through map a StopIteration would be lost
        return lambda points: np.array(own(points), dtype=float)
    if isinstance(workers, MapEngine):
        return _mapped(func, args, workers.function)
    _check_picklable(func, args, workers)
    engine = stack.enter_context(Processes(workers) if isinstance(workers, int) else workers)
    return _shared_out(stack.enter_context(Work(engine, _Points(func, args), "func", "points")))


def _check_picklable(
    func: Callable[..., Any], args: tuple[Any, ...], workers: int | Engine
) -> None:
    """Refuse what cannot be sent to other processes, before there are any.

    Raises
    ------
    ValueError
        Names it, and the part of it that cannot be sent.
    """
    if not isinstance(workers, int) and not workers.pickles:
        return
    dumps = pickle.dumps if isinstance(workers, int) else workers.dumps
    title = f"{workers} workers" if isinstance(workers, int) else workers.title
    for name, value in (("func", func), ("args", args)):
        try:
            dumps(value)
        except Exception as error:  # whatever a class's own way to be pickled raises
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise ValueError(
                f"{name} is {value!r}; must be such that it can be pickled for {title}, "
                f"as functions of a module can; or give workers=1 ({reason})"
            ) from None


def _shared_out(work: Work) -> Callable[[Array], Array]:
    """Make a function of points (n, p) whose blocks an engine evaluates."""

    def each(points: Array) -> Array:
        costs = np.full(len(points), np.nan)
        answered = np.zeros(len(points), dtype=bool)
        try:
            for block in work.blocks(len(points), lambda first, n: points[first : first + n]):
                own = slice(block.first, block.first + block.size)
                costs[own], answered[own] = block.answer, True
        except BaseException as error:
            _tell_answers(error, _first_answers(costs, answered))
            raise
        return costs

    return each


def _first_answers(costs: Array, answered: Array) -> list[float]:
    """Give the costs before the first that is missing."""
    first = costs[: len(costs) if answered.all() else int(np.argmin(answered))]
    return [float(cost) for cost in first]


def _mapped(
    func: Callable[..., Any], args: tuple[Any, ...], mapping: Map
) -> Callable[[Array], Array]:
    """Make a function of points (n, p) whose points a function like map evaluates."""

    def each(points: Array) -> Array:
        costs = np.full(len(points), np.nan)
        answered = np.zeros(len(points), dtype=bool)
        try:
            _gather(mapping(_Ask(func, args), points), points, costs, answered)
        except BaseException as error:
            _tell_answers(error, _first_answers(costs, answered))
            raise
        return costs

    return each


def _gather(answers: Iterable[Any], points: Array, costs: Array, answered: Array) -> None:
    """Put each of a map's answers at its point's place.

    Numbers of the map's own, which do not tell their points, are taken in the points' order.

    Raises
    ------
    ValueError
        There are more or fewer than points, or one of another point.
    """
    places: dict[bytes, list[int]] = {}
    for place, point in enumerate(points):
        places.setdefault(point.tobytes(), []).append(place)
    for count, answer in enumerate(answers):
        if count == len(points):
            raise ValueError(f"workers gave more than {count} answers to {count} points")
        place = count
        if isinstance(answer, _Answer):
            own = places.get(answer.point)
            if not own:
                raise ValueError("workers gave an answer to a point that it was not asked for")
            place = own.pop(0)
        costs[place] = _plain_cost(answer)
        answered[place] = True
    if not answered.all():
        text = f"workers gave {int(answered.sum())} answers to {len(points)} points"
        raise ValueError(f"{text}; must give one to each")
