"""The one way in which blocks of items go to an engine and their answers come back."""

from __future__ import annotations

import uuid
from collections import deque
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from time import perf_counter
from types import TracebackType
from typing import Any, NamedTuple

from nfopidn import _core
from nfopidn.engines import serving
from nfopidn.engines.engine import Engine, EngineError
from nfopidn.engines.pace import Pace

#: How often a block is begun whose worker dies each time.
ATTEMPTS = 3
_AHEAD = 2  # blocks sent for each worker, so that none waits for the next one


class Block(NamedTuple):
    """A finished block: items first .. first + size - 1."""

    first: int
    size: int
    answer: Any


@dataclass
class _Sent:
    """A block under way."""

    first: int
    count: int
    job: Any
    deaths: int = 0
    begun: float = 0.0


class Work:
    """A function whose jobs an engine does; within `with`.

    The function goes to each worker once. Its answers must not depend on how items are cut into
    blocks: then results are the same to the bit on any engine and any number of workers.
    """

    def __init__(
        self,
        engine: Engine,
        function: Callable[[Any], Any],
        what: str,
        items: str = "items",
        first: int = 1,
    ) -> None:
        """Prepare it; nothing is sent yet.

        Parameters
        ----------
        engine
            that stays the caller's to close
        function
            of a job
        what
            a message calls the function so
        items
            a message calls its items so
        first
            items of a block at most, before one has been measured

        Raises
        ------
        ValueError
            The function cannot be sent to other processes, or the engine is closed.
        """
        engine.check()
        self._engine = engine
        self._function = function
        self._what, self._items = what, items
        self._token = uuid.uuid4().hex
        self._bytes: bytes | None = None
        self._knowing: set[str] = set()
        self.pace = Pace(first)
        if engine.pickles:
            self._payload()
        serving.register(self._token, function)

    def __enter__(self) -> Work:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Forget the function."""
        serving.forget(self._token)

    def blocks(self, count: int, cut: Callable[[int, int], Any]) -> Generator[Block, None, None]:
        """Do items 0 .. count - 1, and give the blocks as they are finished, in any order.

        Parameters
        ----------
        count
            items
        cut
            makes the job of (first, count) items

        Raises
        ------
        EngineError
            The engine is closed, or a block's worker died at each attempt.
        """
        course = _Course(self, count, cut)
        try:
            yield from course.run()
        except BaseException:  # what is still out is of no use any more
            course.cancel()
            self._engine.stop()
            raise

    def _payload(self) -> bytes:
        """Give the function as it is sent."""
        if self._bytes is None:
            try:
                self._bytes = self._engine.dumps(self._function)
            except Exception as error:  # whatever a class's own way to be pickled raises
                reason = " ".join(f"{type(error).__name__}: {error}".split())
                raise ValueError(
                    f"{self._what}: must be such that pickle can send it to the workers of "
                    f"{self._engine.title} ({reason})"
                ) from None
        return self._bytes

    def start(self, block: _Sent, with_function: bool) -> Any:
        """Send a block; with the function while there are workers that may not know it."""
        new = self._engine.pickles and len(self._knowing) < self._engine.count()
        payload = self._payload() if new or with_function else None
        block.begun = perf_counter()
        return self._engine.start(serving.serve, self._token, payload, _core.__version__, block.job)


class _Course:
    """One round of blocks: which are out, which are to be sent again."""

    def __init__(self, work: Work, count: int, cut: Callable[[int, int], Any]) -> None:
        self._work, self._engine = work, work._engine
        self._count, self._cut = count, cut
        self._next = 0
        self._out: dict[Any, _Sent] = {}
        # Of a pool that has lost all its blocks, each may be the one that kills its worker: they
        # are done one at a time, so that it shows which.
        self._suspects: deque[_Sent] = deque()

    def run(self) -> Iterator[Block]:
        while self._next < self._count or self._out or self._suspects:
            self._send()
            handle = self._engine.finished()
            block = self._out.pop(handle, None)
            if block is not None:
                yield from self._receive(handle, block)

    def cancel(self) -> None:
        if self._out:
            self._engine.cancel(list(self._out))

    def _send(self) -> None:
        if self._suspects:
            if not self._out:
                self._begin(self._suspects.popleft())
            return
        workers = self._engine.count()
        while self._next < self._count and len(self._out) < _AHEAD * workers:
            left = self._count - self._next
            size = self._work.pace.size(left, self._count, workers)
            first, self._next = self._next, self._next + size
            self._begin(_Sent(first, size, self._cut(first, size)))

    def _begin(self, block: _Sent, with_function: bool = False) -> None:
        try:
            handle = self._work.start(block, with_function)
        except BaseException as error:
            if not self._engine.is_death(error):
                raise
            self._bury(block, error)
            return
        self._out[handle] = block

    def _receive(self, handle: Any, block: _Sent) -> Iterator[Block]:
        try:
            worker, busy, answer = self._engine.answer(handle)
        except MemoryError as error:
            error.add_note(
                f"in a worker of {self._engine.title}, at {self._named(block)}: fewer workers on a "
                "machine have more memory each"
            )
            raise
        except Exception as error:
            if not self._engine.is_death(error):
                raise
            self._bury(block, error)
            return
        if answer is None:
            self._begin(block, with_function=True)
            return
        if worker in self._work._knowing:  # the first time it loads modules besides
            self._work.pace.note(block.count, busy, perf_counter() - block.begun)
        self._work._knowing.add(worker)
        yield Block(block.first, block.count, answer[0])

    def _bury(self, block: _Sent, error: BaseException) -> None:
        """Have the block of a dead worker done again."""
        everything = self._engine.loses_all(error)
        if not everything or not self._out:  # it was the only one
            block.deaths += 1
        if block.deaths >= ATTEMPTS:
            raise EngineError(
                f"{self._engine.title}: the worker died at each of {ATTEMPTS} attempts at "
                f"{self._named(block)} ({type(error).__name__}: {error}); the usual reason is "
                "memory: the system kills what takes too much"
            ) from error
        self._suspects.append(block)
        if everything:
            self._lose(error)

    def _lose(self, error: BaseException) -> None:
        """Take back all blocks that were out, and have the engine renewed."""
        kept = {handle: one for handle, one in self._out.items() if self._engine.survives(handle)}
        lost = [one for handle, one in self._out.items() if handle not in kept]
        self._suspects.extend(sorted(lost, key=lambda block: block.first))
        self._out = kept
        self._work._knowing.clear()
        self._engine.renew(error)

    def _named(self, block: _Sent) -> str:
        last = block.first + block.count - 1
        return f"{self._work._items} {block.first} to {last}"
