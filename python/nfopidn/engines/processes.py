"""Processes of a call's own. They end with the call, and with the process that has them."""

from __future__ import annotations

import os
import signal
import threading
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import connection, parent_process

from nfopidn.engines.pools import Pool, warn_of_death

_LOOK = 1.0  # [s] between two looks at the parent, where its end is not told at once


class Processes(Pool):
    """A pool of processes, which starts with the first call."""

    def __init__(self, count: int) -> None:
        """Take the number of processes."""
        self._count = count
        super().__init__(self._made(), lambda: count)
        self.title = f"{count} processes"

    def _made(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(self._count, initializer=_settle)

    def renew(self, error: BaseException) -> None:
        """Start processes again."""
        warn_of_death(self.title)
        self.stop()

    def stop(self) -> None:
        """Kill the processes: one may be in the midst of a call that never ends."""
        for process in list((self._executor._processes or {}).values()):
            process.kill()
        self.close()
        self._executor = self._made()  # none of its processes is started yet

    def close(self) -> None:
        """End the processes."""
        self._executor.shutdown(wait=True, cancel_futures=True)


def _settle() -> None:
    """Prepare a worker: signals are for its parent to heed, whose end is its own."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    threading.Thread(target=_watch_parent, daemon=True).start()


def _watch_parent() -> None:
    """End this process with its parent, however that ends.

    The sentinel tells it at once, but not where another process has a copy of its other end, as
    workers that were forked later do; the number of the parent then changes. With a fork server
    that number is the server's from the start, and the sentinel has no copies.
    """
    parent = parent_process()
    if parent is None:
        return
    is_forked = os.getppid() == parent.pid
    while not connection.wait([parent.sentinel], timeout=_LOOK):
        if is_forked and os.getppid() != parent.pid:
            break
    os._exit(1)
