"""Executors of concurrent.futures, and those of others that are like them: loky, mpi4py."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterable
from concurrent.futures import (
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from queue import SimpleQueue
from typing import Any

from nfopidn.engines.engine import Engine, EngineError


class Pool(Engine):
    """An executor of the user's, which stays open.

    A process pool of Python's or loky's is broken for good once one of its processes dies. The
    blocks then go on in a new one with its settings, which ends with the call.
    """

    def __init__(self, executor: Any, known_count: Callable[[], int]) -> None:
        """Take an executor, and what tells the workers of one that does not tell."""
        self.title = f"a {type(executor).__name__}"
        isolated = (
            type(executor).__name__ == "InterpreterPoolExecutor"
        )  # threads that share nothing
        self.pickles = isolated or not isinstance(executor, ThreadPoolExecutor)
        self._executor: Any = executor
        self._known_count = known_count
        self._substitute: Executor | None = None
        self._done: SimpleQueue[Future[Any]] = SimpleQueue()

    @property
    def _present(self) -> Any:
        return self._substitute or self._executor

    def count(self) -> int:
        """Give the workers that it may have."""
        for name in ("num_workers", "_max_workers"):  # MPI's pool knows the first one alone
            number = getattr(self._present, name, None)
            if isinstance(number, int) and number > 0:
                return number
        return self._known_count()

    def check(self) -> None:
        """Refuse one that is shut down or broken."""
        flags = getattr(self._executor, "_flags", None)  # loky's
        marks = [
            getattr(self._executor, "_shutdown", False),
            getattr(self._executor, "_shutdown_thread", False),
            getattr(flags, "shutdown", False),
        ]
        # A pool that is broken counts as shut down too.
        if getattr(self._executor, "_broken", False) or getattr(flags, "broken", None):
            raise ValueError(
                f"workers is {self.title} that is broken, as one of its processes has died; must "
                "be a new one"
            )
        if any(mark is True for mark in marks):
            raise ValueError(f"workers is {self.title} that is shut down; must be open")

    def dumps(self, value: Any) -> bytes:
        """Pickle as the executor would."""
        if type(self._executor).__module__.startswith("loky"):
            return by_value(value)
        return super().dumps(value)

    def start(self, call: Callable[..., Any], *arguments: Any) -> Future[Any]:
        """Submit a call."""
        try:
            future: Future[Any] = self._present.submit(call, *arguments)
        except BrokenExecutor:
            raise
        except RuntimeError as error:
            raise EngineError(f"{self.title} takes no more calls: {error}") from error
        future.add_done_callback(self._done.put)
        return future

    def finished(self) -> Future[Any]:
        """Wait for the next one."""
        return self._done.get()

    def answer(self, handle: Future[Any]) -> Any:
        """Give its result."""
        try:
            return handle.result()
        except CancelledError as error:
            raise EngineError(f"{self.title} was shut down while blocks were out") from error

    def cancel(self, handles: Iterable[Future[Any]]) -> None:
        """Cancel those that have not begun."""
        for one in handles:
            one.cancel()

    def is_death(self, error: BaseException) -> bool:
        """Whether a process has died."""
        return isinstance(error, BrokenExecutor)

    def loses_all(self, error: BaseException) -> bool:
        """Tell that the pool is broken as a whole."""
        return True

    def survives(self, handle: Future[Any]) -> bool:
        """Whether it has a result."""
        return handle.done() and not handle.cancelled() and handle.exception() is None

    def renew(self, error: BaseException) -> None:
        """Put a new pool in the place of the broken one."""
        if self._substitute is not None:
            self._substitute.shutdown(wait=False)
        self._substitute = _like(self._executor)
        if self._substitute is None:
            raise EngineError(
                f"{self.title} is broken, as one of its workers has died ({error}); give a new one"
            ) from error
        warn_of_death(self.title)

    def close(self) -> None:
        """End a pool that was put in the place of the user's."""
        if self._substitute is not None:
            self._substitute.shutdown(wait=True)
            self._substitute = None


class Threads(Pool):
    """Threads of a call's own, for work that the core does without the GIL."""

    def __init__(self, count: int) -> None:
        """Take their number."""
        super().__init__(ThreadPoolExecutor(count), lambda: count)
        self.title = f"{count} threads"

    def close(self) -> None:
        """End them, once what has begun is done."""
        self._executor.shutdown(wait=True, cancel_futures=True)


def warn_of_death(title: str) -> None:
    """Tell that a process has died, and what follows."""
    warnings.warn(
        f"a process of {title} has died, and with it the pool; its blocks are done again in a new "
        "one (a process that the system kills has mostly used up the memory)",
        RuntimeWarning,
        stacklevel=2,
    )


def by_value(value: Any) -> bytes:
    """Pickle by cloudpickle, which loky and Dask need too: functions of a session can be sent."""
    import cloudpickle

    return bytes(cloudpickle.dumps(value))


def _like(executor: Any) -> Executor | None:
    """Make a process pool with the settings of another; None for other kinds."""
    kind: type = type(executor)
    if kind is ProcessPoolExecutor:
        return ProcessPoolExecutor(
            executor._max_workers,
            mp_context=executor._mp_context,
            initializer=executor._initializer,
            initargs=executor._initargs,
        )
    if kind.__module__.startswith("loky"):
        made: Executor = sys.modules["loky"].ProcessPoolExecutor(
            executor._max_workers,
            context=executor._context,
            initializer=executor._initializer,
            initargs=executor._initargs,
            env=executor._env,
        )
        return made
    return None
