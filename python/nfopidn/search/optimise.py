"""What the searches have in common: settings, results, callbacks, how they end."""

from __future__ import annotations

import inspect
import json
import secrets
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from numbers import Integral
from os import PathLike, fspath
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn.arguments import check_encoding, is_number, suggestion
from nfopidn.console import Report, progress
from nfopidn.files import check_outputs
from nfopidn.search.interrupts import StopRequests, heeded_signals, user_code

Array = NDArray[np.float64]
Callback = Callable[..., object]
Result = TypeVar("Result", bound="OptimizeResult")

METHODS: tuple[str, ...] = tuple(_core.METHODS)
HISTORY = ("l", "k", "j", "nfev", "best", "mean", "step")
DEFAULT_EVALUATIONS = _core.METHODS[METHODS[0]]
UNLIMITED = _core.UNLIMITED
BOUND_WORDS = {-1: "  (at its lower bound)", 0: "", 1: "  (at its upper bound)"}
MOST_LINES = 40  # of a printed result
NEAR_BOUND = 1e-4  # of the width of the bounds: nearer, a number is at its bound
WIDEST = 1e300  # of a bound: beyond, the width of a box overflows

MESSAGES = {
    "schedule": "The schedule is complete.",
    "evaluations": "The budget of evaluations is used up.",
    "time": "The time is up.",
    "target": "The wanted cost is reached.",
    "callback": "The callback asked to stop.",
    "interrupted": "The search was interrupted; this is the best so far.",
    "not_a_number": "The function returned NaN.",
    "no_finite_cost": "No point that was tried has a finite cost.",
    "diverged": "The best controller that was found diverges",
    "constraints": "No controller that keeps to the constraints was found",
}
#: Up to this status a search has ended as it was asked to.
CALLED_OFF = list(MESSAGES).index("callback")


class OptimizeResult(dict[str, Any]):
    """The result of a search: SciPy's fields, as attributes and as keys.

    x (p,), fun, nfev, nit, success, status, message, population (S, p), population_energies (S,),
    active_mask (p,) (-1 where x is at its lower bound, 1 at its upper one, else 0), history (a
    structured array, a row a chemotactic step: l, k, j, nfev, best, mean, step; with "cma" a row a
    generation, j, of restart l), seed, elapsed [s].
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

    def __str__(self) -> str:
        """Tell what was found, in lines: a number of x each, marked where it is at its bound."""
        if not {"x", "fun", "nfev", "message", "elapsed"} <= set(self):
            return repr(self)
        lines = [
            ("cost", f"{self['fun']:.8g}"),
            ("evaluations", f"{self['nfev']}"),
            ("time", f"{self['elapsed']:.2f} s"),
            *([("seed", f"{self['seed']}")] if "seed" in self else []),
            *self.numbers(),
        ]
        if len(lines) > MOST_LINES:
            more = len(lines) - MOST_LINES
            lines = [*lines[:MOST_LINES], ("...", f"and {more} more")]
        width = max(len(name) for name, _ in lines)
        told = [f"  {name:{width}}  {value}" for name, value in lines]
        return "\n".join([f"{type(self).__name__}: {self['message']}", *told])

    def numbers(self) -> list[tuple[str, str]]:
        """Give names and values of x as text, with a word on those that are at a bound."""
        names = self.get("parameters") or [f"x[{i}]" for i in range(len(self["x"]))]
        mask = self.get("active_mask", np.zeros(len(names)))
        return [
            (name, f"{value:.10g}{BOUND_WORDS[int(side)]}")
            for name, value, side in zip(names, self["x"], mask, strict=True)
        ]

    def at_bounds(self) -> dict[str, str]:
        """Give "lower" or "upper" by name, for each number of x that is at a bound of its own."""
        names = [name for name, _ in self.numbers()]
        mask = self.get("active_mask", np.zeros(len(names)))
        words = {-1: "lower", 1: "upper"}
        return {name: words[side] for name, side in zip(names, mask, strict=True) if side != 0}

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
            "engine": None,
            "engine_workers": 1,
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
        hint = suggestion(method, METHODS)
        known = ", ".join(map(repr, METHODS))
        raise ValueError(f"method is {method!r}{hint}; must be one of {known}")
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
        seed = seed_of_checkpoints(checkpoint, stages)
        return secrets.randbits(32) if seed is None else seed
    if isinstance(rng, np.random.SeedSequence | np.random.BitGenerator):
        rng = np.random.default_rng(rng)
    if isinstance(rng, np.random.RandomState):
        return int(rng.randint(2**53, dtype=np.int64))
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
    text = _core.checkpoint_problem(checkpoint)
    problem = None if text is None else json.loads(text)
    return problem if isinstance(problem, dict) else None


def seed_of_checkpoints(checkpoint: str, stages: Sequence[str] = ()) -> int | None:
    """Give the seed of the search that goes on from a checkpoint, or from that of a stage of it.

    None if there is none, or if `checkpoint` is empty.
    """
    paths = [checkpoint + suffix for suffix in ("", *stages)] if checkpoint else []
    seeds = (_seed_of_checkpoint(path) for path in paths)
    return next((seed for seed in seeds if seed is not None), None)


def _seed_of_checkpoint(path: str) -> int | None:
    """Give the seed of the search that goes on, None if there is none."""
    seed = (problem_in(path) or {}).get("seed")
    return seed if isinstance(seed, int) and 0 <= seed <= 2**53 else None


def check_bounds(low: Array, high: Array, names: Sequence[str], may_be_equal: bool = False) -> None:
    """Refuse bounds that are not finite or not in order."""
    for name, a, b in zip(names, low, high, strict=True):
        if not (np.isfinite(a) and np.isfinite(b)):
            raise ValueError(f"bounds of {name} are ({a}, {b}); must be finite")
        if abs(a) > WIDEST or abs(b) > WIDEST:
            raise ValueError(f"bounds of {name} are ({a}, {b}); must be within +-{WIDEST:g}")
        if not (a < b or (may_be_equal and a == b)):
            raise ValueError(f"bounds of {name} are ({a}, {b}); the first must be the smaller")


def answering(callback: Callback) -> Callable[[OptimizeResult], object]:
    """Give a function that calls a callback with what its parameters ask for, as SciPy does."""
    try:
        signature = inspect.signature(callback)
    except ValueError:  # of some built-in functions it is not known
        return lambda result: callback(result.x)
    names = set(signature.parameters)
    if names == {"intermediate_result"}:
        return lambda result: callback(intermediate_result=result)
    if names == {"result"}:
        return callback
    try:
        signature.bind(None, None)
    except TypeError:
        return lambda result: callback(result.x)
    return lambda result: callback(result.x, result.convergence)


class Observer:
    """What the core calls after each step: the user's callback, and the progress bar."""

    def __init__(self, callback: Callback | None, report: Report, requests: StopRequests) -> None:
        self.call = None if callback is None else answering(callback)
        self.report = report
        self.requests = requests

    def __call__(
        self,
        x: Array,
        fun: float,
        nfev: int,
        mean: float,
        step: float,
        population: Array,
        population_energies: Array,
    ) -> bool:
        """Hand the result so far on; False ends the search."""
        self.report(nfev, f"{nfev} evaluations, cost {fun:.6g}")
        if self.call is None:
            return True
        result = OptimizeResult(
            x=x,
            fun=fun,
            nfev=nfev,
            mean=mean,
            step=step,
            population=population,
            population_energies=population_energies,
            convergence=_convergence(population_energies),
        )
        try:
            with user_code(self.requests):
                return not bool(self.call(result))
        except StopIteration:
            return False


def _convergence(costs: Array) -> float:
    """Give SciPy's measure of how alike the costs of a population are: 1 and more is alike."""
    if not np.isfinite(costs).all():
        return 0.0
    tiny = np.finfo(float).eps
    return float(0.01 / (np.std(costs) / (abs(np.mean(costs)) + tiny) + tiny))


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
        with heeded_signals() as requests, progress(title, total, settings.progress) as report:
            if callback is not None or settings.progress:
                request["callback"] = Observer(callback, report, requests)
            with _core.StopIf(requests.is_asked):
                found.update(search(request))
    except KeyboardInterrupt as interrupt:
        if not found:
            raise
        found["raised"] = found["raised"] or interrupt  # as the bar was taken away
    return found, found.pop("raised")


def active_mask(x: Array, low: Array, high: Array) -> NDArray[np.int64]:
    """Tell which numbers are at a bound: -1 the lower one, 1 the upper one, 0 neither.

    Numbers whose bounds are equal are at neither: they are fixed.
    """
    if len(x) == 0:  # nothing was answered
        return np.zeros(0, dtype=np.int64)
    near = NEAR_BOUND * (high - low)
    sides = np.where(x >= high - near, 1, np.where(x <= low + near, -1, 0))
    return np.where(high > low, sides, 0)


def ended_by(reason: str) -> dict[str, Any]:
    """Give success, status and message of a search that ended so."""
    success = reason not in ("interrupted", "not_a_number")
    return {
        "success": success,
        "status": list(MESSAGES).index(reason),
        "message": MESSAGES[reason],
    }


def nothing_found(found: dict[str, Any]) -> BaseException:
    """Give what a search ends with that was interrupted before it knew a first cost."""
    if found["reason"] == "interrupted":
        return KeyboardInterrupt()
    return ValueError("maxtime was over before the first cost was known; give it more")


def finish(
    result: OptimizeResult,
    found: dict[str, Any],
    raised: BaseException | None,
    box: tuple[Array, Array],
) -> None:
    """Fill the result; raise what callback or function raised, with the result attached.

    Where the search ended before its first cost there is no result to fill.
    """
    if found["nfev"] == 0 and raised is None:
        raise nothing_found(found)
    reason = found.pop("reason")
    fault = found.pop("checkpoint_fault")
    if raised is not None and reason == "not_a_number":
        # The function was asked for one point more, which it has not answered.
        found["nfev"] -= 1
        counts = found["history"][:, HISTORY.index("nfev")]
        np.minimum(counts, found["nfev"], out=counts)
    if isinstance(raised, KeyboardInterrupt):
        reason = "interrupted"
        if found["nfev"] > 0:  # else there is nothing to return
            raised = None
    history = np.zeros(len(found["history"]), dtype=[(name, float) for name in HISTORY])
    for column, name in enumerate(HISTORY):
        history[name] = found["history"][:, column]
    found["history"] = history
    result.update(found)
    result["active_mask"] = active_mask(found["x"], *box)
    result["nit"] = len(history)
    result.update(ended_by(reason))
    error: BaseException | None = raised
    if error is not None:
        so_far = "this is the best so far" if found["nfev"] > 0 else "nothing was answered before"
        result["message"] = f"{type(error).__name__} was raised; {so_far}."
    if error is None and fault:
        error = ValueError(f"checkpoint: {fault}")
    if error is None and reason == "not_a_number":
        error = ValueError("func returned NaN; return inf for points that have no cost")
    if error is not None:
        error.best = result  # type: ignore[attr-defined]
        raise error


def returned(search: Callable[[], Result]) -> Result:
    """Give what a search finds, whatever signal comes meanwhile; all of a public call is in here.

    Ctrl-C ends the search, and the result says so. One that comes as the call returns may still
    raise KeyboardInterrupt, whose `best` is the result; one before the first cost does, and its
    `best` is None or a result without evaluations.
    """
    result: Result | None = None
    try:
        with _core.StandardArithmetic(), heeded_signals() as requests:
            result = search()
        if requests.asked:
            result.update(ended_by("interrupted"))
        return result
    except KeyboardInterrupt as interrupt:
        if result is not None or not hasattr(interrupt, "best"):
            interrupt.best = result  # type: ignore[attr-defined]
        raise


def deny_success(result: OptimizeResult, reason: str, text: str = "") -> None:
    """Mark a search that has ended as asked, but has found nothing that is of use."""
    if result["status"] <= CALLED_OFF:
        message = f"{MESSAGES[reason]}{text} {result['message']}"
        result.update(success=False, status=list(MESSAGES).index(reason), message=message)
