"""What runs in a worker: the function is sent once, and kept under a token.

A task that brings a token alone costs its worker nothing but a look into a table. A worker that
does not know the token, because it is new or was started again, says so and is sent the function.
"""

from __future__ import annotations

import os
import pickle
import socket
import threading
from collections import OrderedDict
from collections.abc import Callable
from time import perf_counter
from typing import Any

_KEPT = 4  # functions of other processes that a worker keeps

#: Of this process's own, for as long as their work is open.
_own: dict[str, Callable[[Any], Any]] = {}
_sent: OrderedDict[str, Callable[[Any], Any]] = OrderedDict()
_lock = threading.Lock()
if hasattr(os, "register_at_fork"):  # another thread may have held it
    os.register_at_fork(after_in_child=_lock._at_fork_reinit)  # type: ignore[attr-defined]


class VersionError(RuntimeError):
    """A worker has another version of nfopidn, whose numbers may be others."""


def register(token: str, function: Callable[[Any], Any]) -> None:
    """Make a function known in this process, where threads and `map` find it."""
    with _lock:
        _own[token] = function


def forget(token: str) -> None:
    """Undo register()."""
    with _lock:
        _own.pop(token, None)


def worker_name() -> str:
    """Tell this process from those of all machines."""
    return f"{socket.gethostname()}:{os.getpid()}"


def serve(
    token: str, payload: bytes | None, version: str, job: Any
) -> tuple[str, float, tuple[Any] | None]:
    """Do a job with the function of a token.

    Returns
    -------
    str, float, tuple or None
        which worker did it; how long it took [s]; the answer, or None where the function is not
        known and no payload was given
    """
    function = _function(token, payload, version)
    if function is None:
        return worker_name(), 0.0, None
    begun = perf_counter()
    answer = function(job)
    return worker_name(), perf_counter() - begun, (answer,)


def _function(token: str, payload: bytes | None, version: str) -> Callable[[Any], Any] | None:
    with _lock:
        own = _own.get(token) or _sent.get(token)
    if own is not None or payload is None:
        return own
    _check_version(version)
    made: Callable[[Any], Any] = pickle.loads(payload)
    with _lock:
        _sent[token] = made
        while len(_sent) > _KEPT:
            _sent.popitem(last=False)
    return made


def _check_version(wanted: str) -> None:
    from nfopidn import __version__

    if __version__ != wanted:
        raise VersionError(
            f"worker {worker_name()} has nfopidn {__version__}, the caller {wanted}; must be the "
            "same, or the numbers may differ"
        )
