"""Signals that ask long work to end, taken as requests that it heeds when it can."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from types import FrameType

#: What a command exits with that Ctrl-C or SIGTERM has ended.
EXIT_INTERRUPTED = 130


class StopRequests:
    """Whether a signal has asked for an end since its signals are heeded.

    Within the library's own code a signal is only noted, so that no result is lost to it. Within
    code of the user's Ctrl-C raises KeyboardInterrupt, as it does anywhere else.
    """

    def __init__(self, second_ends: bool = False) -> None:
        self.asked = False
        self.in_user_code = False
        #: By number, what was done with each signal before.
        self.heeded: dict[int, object] = {}
        self._second_ends = second_ends

    def is_asked(self) -> bool:
        """Tell whether the work is to end."""
        return self.asked

    def note(self, number: int, _: FrameType | None) -> None:
        """Handle a signal."""
        self.asked = True
        if self._second_ends:
            for one in self.heeded:
                signal.signal(one, signal.SIG_DFL)
        if self.in_user_code and number == signal.SIGINT:
            self.in_user_code = False  # what follows is the library's code
            raise KeyboardInterrupt


_active: StopRequests | None = None  # of the main thread


@contextmanager
def heeded_signals(
    signals: Iterable[int] = (signal.SIGINT,), second_ends: bool = False
) -> Iterator[StopRequests]:
    """Take signals as requests to stop, for as long as the work takes.

    A signal is left alone that is ignored, or that the program handles in its own way. Work within
    work has the requests of the outer one. Python handles signals in the main thread alone:
    elsewhere nothing asks for an end.

    Parameters
    ----------
    signals
        Those to heed.
    second_ends
        Whether after the first signal another one ends the program at once.
    """
    global _active  # noqa: PLW0603  # as the handlers of signals are: one for the process
    if threading.current_thread() is not threading.main_thread():
        yield StopRequests()
        return
    if _active is not None:
        outer = _active.in_user_code
        _active.in_user_code = False
        try:
            yield _active
        finally:
            _active.in_user_code = outer
        return
    requests = StopRequests(second_ends)
    usual = (signal.default_int_handler, signal.SIG_DFL)
    requests.heeded = {one: signal.getsignal(one) for one in signals}
    requests.heeded = {one: had for one, had in requests.heeded.items() if had in usual}
    _active = requests
    try:
        for one in requests.heeded:
            signal.signal(one, requests.note)
        yield requests
    finally:
        _active = None
        for one, had in requests.heeded.items():
            signal.signal(one, had)  # type: ignore[arg-type]


@contextmanager
def user_code(requests: StopRequests) -> Iterator[None]:
    """Run code of the user's, within which Ctrl-C raises KeyboardInterrupt at once."""
    outer = requests.in_user_code
    requests.in_user_code = True
    try:
        yield
    finally:
        requests.in_user_code = outer


@contextmanager
def wish_to_stop() -> Iterator[threading.Event]:
    """Give an event that Ctrl-C sets; the signal does nothing else meanwhile.

    Python hears signals in the main thread alone: elsewhere nothing sets the event.
    """
    stop = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield stop
        return
    before = signal.signal(signal.SIGINT, lambda *_: stop.set())
    try:
        yield stop
    finally:
        signal.signal(signal.SIGINT, signal.SIG_DFL if before is None else before)
