"""Bacterial foraging for any function, with SciPy's conventions."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack, suppress
from dataclasses import dataclass
from numbers import Integral
from os import PathLike, fspath
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nfopidn import _core
from nfopidn._checks import check_encoding, is_number, whole_number
from nfopidn._files import check_outputs
from nfopidn._progress import Report, progress

Array = NDArray[np.float64]
Callback = Callable[["OptimizeResult"], object]

METHODS: tuple[str, ...] = tuple(_core.METHODS)
HISTORY = ("l", "k", "j", "nfev", "best", "mean", "step")
DEFAULT_EVALUATIONS = _core.METHODS[METHODS[0]]
UNLIMITED = _core.UNLIMITED
FIRST_STAGE = ".gains"  # suffix of the checkpoint of a search's first stage
#: Those of its stages by what the lateral channel is fed; the last has the search's own name.
LATERAL_STAGES = {name: f".{name}" for name in _core.FREE_TAP_LATERALS[:-1]}
LATERAL_STAGES[_core.FREE_TAP_LATERALS[-1]] = ""
MOST_WORKERS = 1024
WIDEST = 1e300  # of a bound: beyond, the width of a box overflows

MESSAGES = {
    "schedule": "The schedule is complete.",
    "evaluations": "The budget of evaluations is used up.",
    "time": "The time is up.",
    "target": "The wanted cost is reached.",
    "callback": "The callback asked to stop.",
    "interrupted": "The search was interrupted; this is the best so far.",
    "not_a_number": "The function returned NaN.",
}


class OptimizeResult(dict[str, Any]):
    """The result of a search: SciPy's fields, as attributes and as keys.

    x (p,), fun, nfev, nit, success, status, message, population (S, p), population_energies (S,),
    history (a structured array, a row a chemotactic step: l, k, j, nfev, best, mean, step; with
    "cma" a row a generation, j, of restart l), seed, elapsed [s].
    """

    def __getattr__(self, name: str) -> Any:
        """Give the field of that name."""
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None

    def __setattr__(self, name: str, value: Any) -> None:
        """Set the field of that name."""
        self[name] = value

    def __dir__(self) -> list[str]:
        """Name the fields too."""
        return [*super().__dir__(), *self]

    def __repr__(self) -> str:
        """Tell the cost and how it was reached."""
        if "fun" not in self or "nfev" not in self:
            return f"{type(self).__name__}({dict(self)})"
        text = f"{type(self).__name__}(fun={self['fun']:.6g}, nfev={self['nfev']}"
        return text + (f", {self['message']!r})" if "message" in self else ")")

    def plot(self, ax: Any = None) -> Any:
        """Draw the best and the mean cost against evaluations; returns the Axes."""
        from nfopidn import plot

        return plot.convergence(self, ax=ax)


@dataclass
class Settings:
    """What every search is given, checked."""

    method: str
    options: dict[str, Any]
    maxfev: int
    maxtime: float
    stopval: float
    seed: int
    checkpoint: str
    progress: bool

    def request(self, low: Array, high: Array, problem: Mapping[str, Any]) -> dict[str, Any]:
        """Make the core's dictionary; the problem is what a checkpoint must agree with."""
        whole = {
            "kind": "search",
            "method": self.method,
            "options": _core.default_options(self.method) | self.options,
            "maxfev": self.maxfev,
            "stopval": str(self.stopval) if np.isinf(self.stopval) else self.stopval,
            "seed": self.seed,
            "low": low.tolist(),
            "high": high.tolist(),
            **problem,
        }
        return {
            "method": self.method,
            "options": self.options,
            "maxfev": self.maxfev,
            "maxtime": self.maxtime,
            "stopval": self.stopval,
            "seed": self.seed,
            "checkpoint": self.checkpoint,
            "low": low,
            "high": high,
            "start": None,
            "callback": None,
            "problem": json.dumps(whole, allow_nan=False),
        }


def check_settings(
    method: str,
    options: Mapping[str, Any] | None,
    rng: Any,
    maxfev: int | None,
    maxtime: float | None,
    stopval: float | None,
    checkpoint: str | PathLike[str] | None,
    progress: bool,
    callback: Callback | None,
    stages: Sequence[str] = (),
) -> Settings:
    """Refuse what is out of range; fill in what is missing.

    A search in stages has checkpoints with these suffixes besides its own.
    """
    if not isinstance(method, str) or method not in METHODS:
        raise ValueError(f"method is {method!r}; must be one of {', '.join(map(repr, METHODS))}")
    if maxfev is None:
        maxfev = _core.METHODS[method]
    elif not is_number(maxfev) or not 1 <= maxfev < UNLIMITED or int(maxfev) != maxfev:
        raise ValueError(f"maxfev is {maxfev}; must be a whole number in [1, 2**62)")
    if maxtime is not None and not (is_number(maxtime) and maxtime > 0):
        raise ValueError(f"maxtime is {maxtime}; must be greater than 0 s")
    if stopval is not None and not is_number(stopval):
        raise ValueError(f"stopval is {stopval}; must be a number")
    if callback is not None and not callable(callback):
        raise ValueError(f"callback is {callback!r}; must be a function or None")
    options = _checked_options(options)
    _core.check_options(method, options)
    path = _checked_path(checkpoint)
    return Settings(
        method=method,
        options=options,
        maxfev=int(maxfev),
        maxtime=np.inf if maxtime is None else float(maxtime),
        stopval=-np.inf if stopval is None else float(stopval),
        seed=_seed(rng, path, stages),
        checkpoint=path,
        progress=progress,
    )


def _checked_options(options: Mapping[str, Any] | None) -> dict[str, Any]:
    """Give the options as plain numbers, which the core checks by name."""
    if options is None:
        return {}
    if not isinstance(options, Mapping):
        raise ValueError(f"options is {options!r}; must be a mapping of names to numbers")
    plain = {}
    for name, value in options.items():
        if not isinstance(name, str):
            raise ValueError(f"options: {name!r} is no name of an option")
        check_encoding("options: ", name)
        if not is_number(value) or not np.isfinite(float(value)):
            raise ValueError(f"options: {name} is {value}; must be a finite number")
        plain[name] = int(value) if isinstance(value, Integral) else float(value)
    return plain


def _checked_path(checkpoint: Any) -> str:
    if checkpoint is None:
        return ""
    if not isinstance(checkpoint, str | PathLike) or not isinstance(fspath(checkpoint), str):
        raise ValueError(f"checkpoint is {checkpoint!r}; must be the name of a file")
    path = fspath(checkpoint)
    if path == "" or "\0" in path:
        raise ValueError(f"checkpoint is {path!r}, empty or with a NUL; must be the name of a file")
    check_encoding("checkpoint: ", path)
    check_outputs({"checkpoint": path})
    return path


def _seed(rng: Any, checkpoint: str, stages: Sequence[str]) -> int:
    if rng is None:
        paths = [checkpoint + suffix for suffix in ("", *stages)] if checkpoint else []
        seeds = [_seed_of_checkpoint(path) for path in paths]
        return next((seed for seed in seeds if seed is not None), secrets.randbits(32))
    if hasattr(rng, "integers"):
        return int(rng.integers(2**53))
    if np.ndim(rng) != 0:
        raise ValueError(f"rng has {np.ndim(rng)} dimensions; must be a number")
    try:
        seed = int(rng)
    except (TypeError, ValueError, OverflowError):
        seed = -1
    if isinstance(rng, bool) or seed != rng or not 0 <= seed <= 2**53:
        raise ValueError(f"rng is {rng}; must be a whole number in [0, 2**53], a Generator or None")
    return seed


def problem_in(checkpoint: str) -> dict[str, Any] | None:
    """Give what a checkpoint is of; None if it cannot be told: the core says what is wrong."""
    if not Path(checkpoint).is_file():
        return None
    try:
        problem = json.loads(Path(checkpoint).read_text(encoding="utf-8"))["problem"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return None
    return problem if isinstance(problem, dict) else None


def _seed_of_checkpoint(path: str) -> int | None:
    """Give the seed of the search that goes on, None if there is none."""
    seed = (problem_in(path) or {}).get("seed")
    return seed if isinstance(seed, int) and 0 <= seed <= 2**53 else None


def check_bounds(low: Array, high: Array, names: Sequence[str]) -> None:
    """Refuse bounds that are not finite or not in order."""
    for name, a, b in zip(names, low, high, strict=True):
        if not (np.isfinite(a) and np.isfinite(b)):
            raise ValueError(f"bounds of {name} are ({a}, {b}); must be finite")
        if abs(a) > WIDEST or abs(b) > WIDEST:
            raise ValueError(f"bounds of {name} are ({a}, {b}); must be within +-{WIDEST:g}")
        if not a < b:
            raise ValueError(f"bounds of {name} are ({a}, {b}); the first must be the smaller")


class Observer:
    """What the core calls after each step: the user's callback, and the progress bar."""

    def __init__(self, callback: Callback | None, report: Report) -> None:
        self.callback = callback
        self.report = report

    def __call__(self, x: Array, fun: float, nfev: int, mean: float, step: float) -> bool:
        """Hand the result so far on; False ends the search."""
        self.report(nfev, f"{nfev} evaluations, cost {fun:.6g}")
        if self.callback is None:
            return True
        try:
            self.callback(OptimizeResult(x=x, fun=fun, nfev=nfev, mean=mean, step=step))
        except StopIteration:
            return False
        return True


def run(
    search: Callable[[dict[str, Any]], dict[str, Any]],
    request: dict[str, Any],
    settings: Settings,
    callback: Callback | None,
    title: str,
) -> tuple[dict[str, Any], BaseException | None]:
    """Run one search of the core with its callback and its progress bar."""
    total = None if settings.maxfev == UNLIMITED else settings.maxfev
    found: dict[str, Any] = {}
    try:
        with progress(title, total, settings.progress) as report:
            if callback is not None or settings.progress:
                request["callback"] = Observer(callback, report)
            found.update(search(request))
    except KeyboardInterrupt as interrupt:
        if not found:
            raise
        found["raised"] = found["raised"] or interrupt  # as the bar was taken away
    return found, found.pop("raised")


def finish(result: OptimizeResult, found: dict[str, Any], raised: BaseException | None) -> None:
    """Fill the result; raise what callback or function raised, with the result attached."""
    reason = found.pop("reason")
    fault = found.pop("checkpoint_fault")
    if isinstance(raised, KeyboardInterrupt):
        reason, raised = "interrupted", None
    history = np.zeros(len(found["history"]), dtype=[(name, float) for name in HISTORY])
    for column, name in enumerate(HISTORY):
        history[name] = found["history"][:, column]
    found["history"] = history
    result.update(found)
    result["nit"] = len(history)
    result["success"] = reason not in ("interrupted", "not_a_number")
    result["status"] = list(MESSAGES).index(reason)
    result["message"] = MESSAGES[reason]
    error: BaseException | None = raised
    if error is not None:
        result["message"] = f"{type(error).__name__} was raised; this is the best so far."
    if error is None and fault:
        error = ValueError(f"checkpoint: {fault}")
    if error is None and reason == "not_a_number":
        error = ValueError("func returned NaN; return inf for points that have no cost")
    if error is not None:
        error.best = result  # type: ignore[attr-defined]
        raise error


def bfoa(
    func: Callable[[Array], Any],
    bounds: Sequence[tuple[float, float]] | ArrayLike,
    *,
    method: str = "bfoa+",
    options: Mapping[str, Any] | None = None,
    rng: Any = None,
    maxfev: int | None = None,
    maxtime: float | None = None,
    stopval: float | None = None,
    callback: Callback | None = None,
    vectorized: bool = False,
    workers: int | Callable[..., Iterable[Any]] = 1,
    checkpoint: str | PathLike[str] | None = None,
    progress: bool = False,
) -> OptimizeResult:
    """Minimise a function within bounds by bacterial foraging, or by CMA-ES.

    Parameters
    ----------
    func
        Takes a point (p,) and returns its cost, or, if `vectorized`, points (n, p) and returns
        costs (n,). Infinity is a cost; NaN is refused.
    bounds
        (p, 2): low and high of each coordinate.
    method
        "bfoa+", the improved variant, "bfoa", Passino's algorithm, or "cma", CMA-ES.
    options
        Settings of the method; docs/tuning.md lists them.
    rng
        A seed, a numpy.random.Generator, or None to draw a seed, which the result records.
    maxfev, maxtime, stopval
        End at this many evaluations (default 10,000 for "bfoa+" and "cma", one schedule for
        "bfoa"), after this time [s], or at this cost.
    callback
        Called with the result so far after each chemotactic step or generation; may raise
        StopIteration.
    vectorized
        Whether func takes a block of points.
    workers
        Processes that evaluate a block's points, or a function like map. func must then be one
        that can be pickled.
    checkpoint
        A file from which the same call goes on after an interruption, to the same result. It is
        saved every half second between evaluations; a block, if func is `vectorized` or `workers`
        is a map, is one evaluation.
    progress
        Whether to show a progress bar in a terminal or notebook; needs rich.

    Returns
    -------
    OptimizeResult
        Ctrl-C ends the search and returns the best so far.

    Raises
    ------
    ValueError
        For an argument out of range, and for a cost that is NaN. What func raises is passed on;
        its attribute `best` then holds the result so far.
    """
    settings = check_settings(
        method, options, rng, maxfev, maxtime, stopval, checkpoint, progress, callback
    )
    low, high = read_box(bounds)
    if not callable(func):
        raise ValueError(f"func is {func!r}; must be a function")
    with ExitStack() as stack:
        if not callable(workers):
            whole_number("workers", workers, 1, MOST_WORKERS)
        block = func if vectorized else _pointwise(func, workers, stack)
        request = settings.request(low, high, {"kind": "function"})
        request["most_at_once"] = UNLIMITED
        watched = settings.checkpoint or np.isfinite(settings.maxtime)
        if watched and not vectorized and not callable(workers):
            # Time is looked at, and answers are saved, between what is asked for together.
            request["most_at_once"] = 1 if workers == 1 else 4 * workers
        found, raised = run(
            lambda request: _core.search_function(block, request),
            request,
            settings,
            callback,
            "bfoa",
        )
    result = OptimizeResult(seed=settings.seed)
    finish(result, found, raised)
    return result


def read_box(bounds: Any) -> tuple[Array, Array]:
    """Give low and high of bounds (p, 2), checked."""
    try:
        box = np.array(bounds, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"bounds are {bounds!r}; must be numbers (p, 2)") from None
    if box.ndim != 2 or box.shape[1] != 2 or len(box) == 0:
        raise ValueError(f"bounds have the shape {box.shape}; must be (p, 2)")
    check_bounds(box[:, 0], box[:, 1], [f"coordinate {i}" for i in range(len(box))])
    return box[:, 0].copy(), box[:, 1].copy()


def _pointwise(
    func: Callable[[Array], Any],
    workers: int | Callable[..., Iterable[Any]],
    stack: ExitStack,
) -> Callable[[Array], Array]:
    """Make a function of points from one of a point."""
    mapping: Callable[..., Iterable[Any]] | None = None
    if callable(workers):
        mapping = workers
    elif workers > 1:
        mapping = stack.enter_context(ProcessPoolExecutor(workers)).map

    def each(points: Array) -> Array:
        costs: list[float] = []
        try:
            if mapping is None:  # a plain loop: through map a StopIteration of func would be lost
                for point in points:
                    costs.append(float(func(point)))
            else:
                for cost in mapping(func, points):
                    costs.append(float(cost))
        except BaseException as error:
            with suppress(AttributeError, TypeError):
                error._nfopidn_answered = costs  # type: ignore[attr-defined]  # the core counts them
            raise
        return np.array(costs)

    return each
