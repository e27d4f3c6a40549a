"""What `workers=` may be, and what it stands for."""

from __future__ import annotations

import os
import sys
from concurrent.futures import Executor
from numbers import Integral
from typing import Any

from nfopidn.arguments import shown, whole_number
from nfopidn.engines.dask_client import DaskCluster
from nfopidn.engines.engine import Engine
from nfopidn.engines.mapping import Mapping
from nfopidn.engines.pools import Pool

#: Of a whole number of workers.
MAXIMUM_WORKERS = 1024
_KINDS = (
    f"a whole number in [1, {MAXIMUM_WORKERS}], -1 for all processors, an Executor as of "
    "concurrent.futures, a dask.distributed.Client or a function like map"
)


def processors() -> int:
    """Give the processors that this process may use."""
    known = hasattr(os, "sched_getaffinity")  # not on macOS
    return min(len(os.sched_getaffinity(0)) if known else os.cpu_count() or 1, MAXIMUM_WORKERS)


def read_threads(given: Any) -> int:
    """Give the number of threads of what has no other workers.

    Raises
    ------
    ValueError
        No such number.
    """
    if isinstance(given, Integral) and not isinstance(given, bool) and given == -1:
        return processors()
    return whole_number("workers", given, 1, MAXIMUM_WORKERS)


def read_workers(given: Any) -> int | Engine:
    """Give the number of workers, or the engine that does the work.

    Raises
    ------
    ValueError
        Neither, or an engine that is closed.
    """
    if isinstance(given, Integral) and not isinstance(given, bool):
        return read_threads(given)
    engine = _engine(given)
    if engine is None:
        raise ValueError(f"workers is {shown(given)}; must be {_KINDS}{_advice(given)}")
    engine.check()
    return engine


def _engine(given: Any) -> Engine | None:
    if isinstance(given, Engine):
        return given
    distributed = sys.modules.get("distributed")
    if distributed is not None:
        if isinstance(given, distributed.Client):
            return DaskCluster(given)
        if isinstance(given, sys.modules["distributed.cfexecutor"].ClientExecutor):
            return DaskCluster(given._client)
    if isinstance(given, type) and hasattr(given, "submit"):
        return None
    if isinstance(given, Executor) or (hasattr(given, "submit") and hasattr(given, "shutdown")):
        return Pool(given, processors)
    return Mapping(given) if callable(given) else None


def _advice(given: Any) -> str:
    """Tell what to give in place of what is near to an engine."""
    if isinstance(given, type):
        return f" (the class {given.__name__} itself is none: make one)"
    if hasattr(given, "scheduler_address"):
        return " (of a Dask cluster, its client: dask.distributed.Client(cluster))"
    if hasattr(given, "imap_unordered"):
        return " (of a pool of multiprocessing, its function: pool.map)"
    return ""
