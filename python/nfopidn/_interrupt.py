"""Ctrl-C as a wish that long work hears when it can, also within a solver that would lose it."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

#: What a command exits with that Ctrl-C has ended.
EXIT_INTERRUPTED = 130


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
