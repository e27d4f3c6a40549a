"""Bacterial foraging by ask and tell."""

from __future__ import annotations

import atexit
import inspect
import os
import queue
import threading
import weakref
from collections.abc import Sequence
from contextlib import suppress
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from nfopidn._checks import real_numbers
from nfopidn._search import (
    MESSAGES,
    Array,
    Callback,
    OptimizeResult,
    bfoa,
    check_settings,
    read_box,
)

_CALLBACK = list(MESSAGES).index("callback")
_CLOSED = "The search was closed; this is the best so far."
_OPEN: weakref.WeakSet[Forager] = weakref.WeakSet()


@atexit.register
def _close_all() -> None:
    """End the searches that nobody has: a thread in the core would bring the interpreter down."""
    for forager in list(_OPEN):
        with suppress(BaseException):
            forager.close()


class Forager:
    """The same search by ask and tell, for costs that come from elsewhere.

    >>> forager = Forager([(0, 1), (0, 1)], rng=1, maxfev=100)
    >>> while (points := forager.ask()) is not None:
    ...     forager.tell([((x - 0.3) ** 2).sum() for x in points])
    >>> forager.result.nfev
    100
    """

    def __init__(self, bounds: Sequence[tuple[float, float]] | ArrayLike, **arguments: Any) -> None:
        """Take the arguments of bfoa(), but for func, vectorized and workers."""
        for name in ("func", "vectorized", "workers"):
            if name in arguments:
                raise TypeError(f"Forager() has no argument {name!r}")
        self._points: queue.Queue[Array | None] = queue.Queue()
        self._costs: queue.Queue[Array | None] = queue.Queue()
        self._asked: Array | None = None
        self._error: BaseException | None = None
        self._closed = False
        self._ending = False  # asked for by the callback
        #: The OptimizeResult once ask() has returned None, or raised.
        self.result: OptimizeResult | None = None
        read_box(bounds)
        given = inspect.signature(bfoa).bind(None, bounds, **arguments)
        given.apply_defaults()
        known = inspect.signature(check_settings).parameters
        words = {name: word for name, word in given.arguments.items() if name in known}
        if hasattr(words["rng"], "integers"):  # a generator's numbers are the search's
            words["rng"] = 0
        check_settings(**words)
        self._process = os.getpid()
        callback = given.arguments["callback"]
        if callback is not None:
            arguments["callback"] = self._told(callback)

        def work() -> None:
            try:
                self.result = bfoa(self._evaluate, bounds, vectorized=True, **arguments)
                if self._ending:
                    self.result["message"] = _CLOSED
            except _ClosedError as closed:
                # As when the callback closes it.
                self.result = closed.best
                success = self.result["nfev"] > 0
                self.result.update(success=success, status=_CALLBACK, message=_CLOSED)
            except BaseException as error:
                self.result = getattr(error, "best", None)
                self._error = error
            self._points.put(None)

        self._thread = threading.Thread(target=work, daemon=True)
        self._thread.start()
        _OPEN.add(self)

    def _evaluate(self, points: Array) -> Array:
        self._points.put(points)
        costs = self._costs.get()
        if costs is None:
            raise _ClosedError
        return costs

    def _told(self, callback: Callback) -> Callback:
        def tell_result(result: OptimizeResult) -> object:
            answer = callback(result)
            if self._ending:
                raise StopIteration
            return answer

        return tell_result

    def _is_searching(self) -> bool:
        """Whether it is the callback that calls, which the search waits for."""
        return threading.current_thread() is self._thread

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
        if self._process != os.getpid():
            raise ValueError("ask() comes in another process than the Forager is in")
        if self._asked is None and not self._closed:
            self._asked = self._points.get()
            self._closed = self._asked is None
            if self._error is not None:
                raise self._error
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
        self._costs.put(values)

    def close(self) -> None:
        """End the search early; result holds the best so far."""
        if self._is_searching():
            self._ending = True
            return
        if self._process != os.getpid():  # a fork, in which the search does not run
            self._closed = True
            return
        if not self._closed:
            self.ask()
        if not self._closed:
            self._asked = None
            self._closed = True
            self._costs.put(None)
        self._thread.join()


class _ClosedError(Exception):
    best: OptimizeResult
