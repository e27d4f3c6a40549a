"""Processes that evaluate points. They end with the search, and with the process that has them."""

from __future__ import annotations

import os
import pickle
import signal
import threading
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import connection, parent_process
from types import TracebackType
from typing import Any

_LOOK = 1.0  # [s] between two looks at the parent, where its end is not told at once


def check_picklable(func: Callable[..., Any], args: tuple[Any, ...], workers: int) -> None:
    """Refuse what cannot be sent to other processes, before there are any.

    Raises
    ------
    ValueError
        Names it, and the part of it that cannot be sent.
    """
    for name, value in (("func", func), ("args", args)):
        try:
            pickle.dumps(value)
        except Exception as error:  # whatever a class's own way to be pickled raises
            reason = " ".join(f"{type(error).__name__}: {error}".split())
            raise ValueError(
                f"{name} is {value!r}; must be such that it can be pickled for {workers} workers, "
                f"as functions of a module can; or give workers=1 ({reason})"
            ) from None


class Workers:
    """A pool of processes; within `with`."""

    def __init__(self, count: int) -> None:
        self._pool = ProcessPoolExecutor(count, initializer=_settle)
        self._cut_short = False

    def map(self, func: Callable[[Any], Any], points: Iterable[Any]) -> Iterator[Any]:
        """Give func of each point, in order."""
        try:
            yield from self._pool.map(func, points)
        except BaseException:
            self._cut_short = True  # what the others are at is of no use any more
            raise

    def __enter__(self) -> Workers:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the processes; those of a search that was cut short in the midst of a point."""
        if self._cut_short or error is not None:
            for process in list((self._pool._processes or {}).values()):
                process.kill()
        self._pool.shutdown(wait=True, cancel_futures=True)


def _settle() -> None:
    """Prepare a worker: signals are for its parent to heed, whose end is its own."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_watch_parent, daemon=True).start()


def _watch_parent() -> None:
    """End this process with its parent, however that ends.

    The sentinel tells it at once, but not where another process has a copy of its other end, as
    workers that were forked later do; the number of the parent then changes. With a fork server
    that number is the server's from the start, and the sentinel has no copies.
    """
    parent = parent_process()
    if parent is None:
        return
    is_forked = os.getppid() == parent.pid
    while not connection.wait([parent.sentinel], timeout=_LOOK):
        if is_forked and os.getppid() != parent.pid:
            break
    os._exit(1)
