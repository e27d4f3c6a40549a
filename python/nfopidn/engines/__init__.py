"""What does the work of `workers=`: processes, executors, a Dask client, or a function like map."""

from nfopidn.engines.choose import MAXIMUM_WORKERS, processors, read_threads, read_workers
from nfopidn.engines.engine import Engine, EngineError
from nfopidn.engines.mapping import Mapping
from nfopidn.engines.pools import Threads
from nfopidn.engines.processes import Processes
from nfopidn.engines.work import Block, Work

__all__ = [
    "MAXIMUM_WORKERS",
    "Block",
    "Engine",
    "EngineError",
    "Mapping",
    "Processes",
    "Threads",
    "Work",
    "processors",
    "read_threads",
    "read_workers",
]
