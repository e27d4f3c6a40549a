"""Bacterial foraging by ask and tell."""

from __future__ import annotations

import atexit
import inspect
import os
import queue
import threading
import weakref
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nfopidn.arguments import real_numbers
from nfopidn.search.bfoa import bfoa, one_seed, read_box, read_start
from nfopidn.search.optimise import (
    MESSAGES,
    Array,
    Callback,
    OptimizeResult,
    answering,
    check_settings,
)

_CALLBACK = list(MESSAGES).index("callback")
_CLOSED = "The search was closed; this is the best so far."


class _ClosedError(Exception):
    best: OptimizeResult


class _Course:
    """A search in a thread of its own, which knows nothing of the Forager that has it."""

    def __init__(self, bounds: Any, arguments: dict[str, Any]) -> None:
        self.points: queue.Queue[Array | None] = queue.Queue()
        self.costs: queue.Queue[Array | None] = queue.Queue()
        self.error: BaseException | None = None
        self.result: OptimizeResult | None = None
        self.ending = False  # asked for by the callback
        self.process = os.getpid()
        self.arguments = arguments
        self.bounds = bounds
        if arguments.get("callback") is not None:
            arguments["callback"] = self._told(arguments["callback"])
        self.thread = threading.Thread(target=self._search, daemon=True)
        self.thread.start()
        _OPEN.add(self)

    def _search(self) -> None:
        try:
            self.result = bfoa(self._evaluate, self.bounds, vectorized=True, **self.arguments)
            if self.ending:
                self.result["message"] = _CLOSED
        except _ClosedError as closed:  # as when the callback closes it
            self.result = closed.best
            self.result.update(status=_CALLBACK, message=_CLOSED)
        except BaseException as error:
            self.result = getattr(error, "best", None)
            self.error = error
        self.points.put(None)

    def _evaluate(self, columns: Array) -> Array:
        self.points.put(np.ascontiguousarray(columns.T))
        costs = self.costs.get()
        if costs is None:
            raise _ClosedError
        return costs

    def _told(self, callback: Callback) -> Callback:
        answer = answering(callback)

        def tell_result(result: OptimizeResult) -> object:
            reply = answer(result)
            if self.ending:
                raise StopIteration
            return reply

        return tell_result

    def abandon(self) -> None:
        """Let the search end: no more costs will be told.

        Called where an object is collected, in any thread, the search's own among them: it waits
        for nothing.
        """
        self.ending = True
        self.costs.put(None)


_OPEN: weakref.WeakSet[_Course] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    """End the searches that nobody has: a thread in the core would bring the interpreter down."""
    for course in list(_OPEN):
        if course.process == os.getpid():  # in a fork no search runs
            course.abandon()
            course.thread.join()


class Forager:
    """The same search by ask and tell, for costs that come from elsewhere.

    >>> with Forager([(0, 1), (0, 1)], rng=1, maxfev=100) as forager:
    ...     while (points := forager.ask()) is not None:
    ...         forager.tell([((x - 0.3) ** 2).sum() for x in points])
    >>> forager.result.nfev
    100

    A Forager has a thread, which ends with the search: at its own end, at close(), at the end of
    `with`, or when nobody has the Forager any more.
    """

    def __init__(self, bounds: Sequence[tuple[float, float]] | ArrayLike, **arguments: Any) -> None:
        """Take the arguments of bfoa(), but for func, args, vectorized and workers."""
        for name in ("func", "args", "vectorized", "workers"):
            if name in arguments:
                raise TypeError(f"Forager() has no argument {name!r}")
        self._asked: Array | None = None
        self._closed = False
        box = read_box(bounds)
        given = inspect.signature(bfoa).bind(None, bounds, **arguments)
        given.apply_defaults()
        known = inspect.signature(check_settings).parameters
        words = {name: word for name, word in given.arguments.items() if name in known}
        words["rng"] = one_seed(given.arguments["rng"], given.arguments["seed"])
        if hasattr(words["rng"], "integers") or hasattr(words["rng"], "randint"):
            words["rng"] = 0  # a generator's numbers are the search's
        read_start(given.arguments["x0"], box)
        check_settings(**words)
        self._course = _Course(bounds, arguments)
        weakref.finalize(self, self._course.abandon).atexit = False  # _close_all() does it then

    @property
    def result(self) -> OptimizeResult | None:
        """The OptimizeResult once ask() has returned None, or raised."""
        return self._course.result

    def __enter__(self) -> Forager:
        return self

    def __exit__(self, *_: object) -> None:
        """Close it."""
        self.close()

    def _is_searching(self) -> bool:
        """Whether it is the callback that calls, which the search waits for."""
        return threading.current_thread() is self._course.thread

    def ask(self) -> Array | None:
        """Give the points (n, p) whose costs are wanted, the same until told; None at the end.

        Passes on, once, what a callback has raised; `result` then has the best before.

        Raises
        ------
        ValueError
            From a callback, or in a forked process.
        """
        if self._is_searching():
            raise ValueError("ask() is not for a callback, which the search waits for")
        if self._course.process != os.getpid():
            raise ValueError("ask() comes in another process than the Forager is in")
        if self._asked is None and not self._closed:
            self._asked = self._course.points.get()
            self._closed = self._asked is None
            if self._course.error is not None:
                raise self._course.error
        return self._asked

    def tell(self, costs: ArrayLike) -> None:
        """Take the costs (n,) of the points asked for.

        Raises
        ------
        ValueError
            If nothing was asked, or costs are too few, too many or NaN; ask() then gives the same
            points again.
        """
        if self._asked is None:
            raise ValueError("tell() comes after ask()")
        values = real_numbers("costs", costs)
        if values.shape != (len(self._asked),):
            raise ValueError(f"costs have the shape {values.shape}; must be ({len(self._asked)},)")
        if np.isnan(values).any():
            raise ValueError("costs hold NaN; give inf for points that have no cost")
        self._asked = None
        self._course.costs.put(values)

    def close(self) -> None:
        """End the search early; result holds the best so far."""
        if self._is_searching():
            self._course.ending = True
            return
        if self._course.process != os.getpid():  # a fork, in which the search does not run
            self._closed = True
            return
        if not self._closed:
            self.ask()
        if not self._closed:
            self._asked = None
            self._closed = True
            self._course.costs.put(None)
        self._course.thread.join()
