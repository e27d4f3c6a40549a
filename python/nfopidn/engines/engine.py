"""What the dispatch of blocks asks of whatever runs them."""

from __future__ import annotations

import pickle
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Iterable
from types import TracebackType
from typing import Any


class EngineError(RuntimeError):
    """An engine can do no more blocks: it was closed meanwhile, or its workers keep dying.

    What was finished is kept: `best` is the result so far where the function that was called has
    one, and its checkpoint has the same.
    """


class Engine(ABC):
    """Runs calls elsewhere: in threads, in processes, on other machines.

    An engine of a user's own stays open; one that was made for a call ends with it.
    """

    #: What messages call it.
    title: str
    #: Whether its workers share no objects with this process.
    pickles = True

    @abstractmethod
    def count(self) -> int:
        """Give how many calls run at a time, as far as is known; at least 1."""

    @abstractmethod
    def start(self, call: Callable[..., Any], *arguments: Any) -> Hashable:
        """Begin a call, and give what stands for it.

        Raises
        ------
        EngineError
            The engine is closed.
        """

    @abstractmethod
    def finished(self) -> Any:
        """Wait for a call that was begun to end, and give what stands for it."""

    @abstractmethod
    def answer(self, handle: Any) -> Any:
        """Give what a finished call has returned; raise what it has raised."""

    @abstractmethod
    def cancel(self, handles: Iterable[Any]) -> None:
        """Give calls up. Those that run already may run on."""

    def check(self) -> None:  # noqa: B027  # most have nothing to do
        """Refuse an engine that is closed.

        Raises
        ------
        ValueError
            Names it.
        """

    def is_death(self, error: BaseException) -> bool:
        """Whether a call ended with its worker, so that it may be begun again."""
        return False

    def loses_all(self, error: BaseException) -> bool:
        """Whether with that worker every other call is lost too."""
        return False

    def survives(self, handle: Any) -> bool:
        """Whether a call had ended before all were lost."""
        return False

    def renew(self, error: BaseException) -> None:  # noqa: B027  # most have nothing to do
        """Make an engine that has lost all fit to go on.

        Raises
        ------
        EngineError
            It cannot be.
        """

    def dumps(self, value: Any) -> bytes:
        """Pickle for its workers."""
        return pickle.dumps(value, pickle.HIGHEST_PROTOCOL)

    def stop(self) -> None:  # noqa: B027  # most have nothing to do
        """End what runs, of which nothing is wanted any more, where the engine is one's own."""

    def close(self) -> None:  # noqa: B027  # most have nothing to do
        """End the engine where it is one's own."""

    def __enter__(self) -> Engine:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End it, at once where the work was cut short."""
        if error is not None:
            self.stop()
        self.close()
