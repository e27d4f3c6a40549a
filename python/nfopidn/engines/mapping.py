"""A function like map, which may do the calls anywhere, and answer in any order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any, NamedTuple

from nfopidn.engines.engine import Engine, EngineError

_AT_A_TIME = 8  # calls; how many such a function does at a time is not known


class Mapping(Engine):
    """Calls in rounds, each one call of the function."""

    pickles = False  # not known: a worker that shares no objects says that it needs them

    def __init__(self, function: Callable[..., Iterable[Any]]) -> None:
        """Take the function."""
        self.title = f"the function {getattr(function, '__name__', repr(function))}"
        self.function = function
        self._begun = 0
        self._next: list[tuple[int, Callable[..., Any], tuple[Any, ...]]] = []
        self._round: Iterator[Any] = iter(())
        self._open: set[int] = set()
        self._answers: dict[int, Any] = {}

    def count(self) -> int:
        """Give half the calls of a round."""
        return _AT_A_TIME

    def start(self, call: Callable[..., Any], *arguments: Any) -> int:
        """Put a call into the next round."""
        self._begun += 1
        self._next.append((self._begun, call, arguments))
        return self._begun

    def finished(self) -> int:
        """Take the next answer of the round, or begin a round."""
        if not self._open:
            calls, self._next = self._next, []
            self._open = {number for number, _, _ in calls}
            self._round = iter(self.function(_numbered, calls))
        for reply in self._round:
            if not isinstance(reply, _Reply) or reply.number not in self._open:
                break
            self._open.remove(reply.number)
            self._answers[reply.number] = reply.answer
            return reply.number
        raise EngineError(
            f"{self.title} has not given {len(self._open)} calls the answers that they return; "
            "must give each its own, in any order"
        )

    def answer(self, handle: int) -> Any:
        """Give it."""
        return self._answers.pop(handle)

    def cancel(self, handles: Iterable[int]) -> None:
        """Forget the round."""
        self._next, self._open, self._answers = [], set(), {}


class _Reply(NamedTuple):
    number: int
    answer: Any


def _numbered(call: tuple[int, Callable[..., Any], tuple[Any, ...]]) -> _Reply:
    """Do a call, and tell which."""
    number, function, arguments = call
    return _Reply(number, function(*arguments))
