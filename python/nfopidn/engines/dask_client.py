"""A cluster of Dask, by its client."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable, Iterable
from concurrent.futures import CancelledError
from queue import SimpleQueue
from time import monotonic
from typing import Any

from nfopidn.engines.engine import Engine, EngineError
from nfopidn.engines.pools import by_value

_COUNTED_FOR = 1.0  # [s] until workers are counted again: a cluster may grow and shrink


class DaskCluster(Engine):
    """The workers of a dask.distributed.Client.

    The scheduler itself sends a task again whose worker has died, up to its setting
    `allowed-failures`, and gives it up then.
    """

    def __init__(self, client: Any) -> None:
        """Take a client."""
        self.title = "a dask.distributed.Client"
        self._client = client
        self._done: SimpleQueue[Any] = SimpleQueue()
        self._counted, self._counted_at = 0, -_COUNTED_FOR

    def count(self) -> int:
        """Count its workers' threads."""
        if monotonic() - self._counted_at > _COUNTED_FOR:
            self._counted = sum(self._client.nthreads().values())
            self._counted_at = monotonic()
        return max(1, self._counted)

    def check(self) -> None:
        """Refuse a client that is closed or is for coroutines; warn of one without workers."""
        if self._client.status != "running":
            raise ValueError(f"workers is {self.title} that is {self._client.status}; must be open")
        if self._client.asynchronous:
            raise ValueError(f"workers is {self.title} with asynchronous=True; must be synchronous")
        self.count()
        if self._counted == 0:
            warnings.warn(
                "the Dask cluster has no workers yet; the work begins when one joins",
                RuntimeWarning,
                stacklevel=2,
            )

    def dumps(self, value: Any) -> bytes:
        """Pickle as Dask would."""
        return by_value(value)

    def start(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Submit a call; not as a pure function, of which equal ones run once for all."""
        try:
            future = self._client.submit(call, *arguments, pure=False)
        except RuntimeError as error:
            raise EngineError(f"{self.title} takes no more calls: {error}") from error
        future.add_done_callback(self._done.put)
        return future

    def finished(self) -> Any:
        """Wait for the next one."""
        return self._done.get()

    def answer(self, handle: Any) -> Any:
        """Fetch its result."""
        try:
            return handle.result()
        except CancelledError as error:
            raise EngineError(
                f"{self.title} was closed, or has lost its scheduler, while blocks were out"
            ) from error

    def cancel(self, handles: Iterable[Any]) -> None:
        """Have the scheduler forget them."""
        if self._client.status == "running":
            self._client.cancel(list(handles))

    def is_death(self, error: BaseException) -> bool:
        """Whether the scheduler has given a task up whose workers died."""
        return isinstance(error, sys.modules["distributed"].KilledWorker)
