"""How large a block is: large enough to hide what sending it takes, small enough to share out."""

from __future__ import annotations

from math import ceil, inf

LONGEST = 0.5  # [s] of work in a block, after which progress shows and Ctrl-C is heard
_SHARES = 3  # blocks of what is left for each worker
_AT_ONCE = 4  # blocks that are on their way to workers or back, as one is prepared
_WEIGHT = 0.3  # of the newest block in the mean


class Pace:
    """Measures what an item takes in a worker and what a block takes besides.

    The results do not depend on it: an item's answer is the same in any block.
    """

    def __init__(self, first: int) -> None:
        """Start with blocks of `first` items at most, until one has been measured."""
        self.first = first
        #: [s] an item in a worker; 0: not known yet.
        self.item = 0.0
        #: [s] of a block besides, the least that was seen: others have waited for a worker.
        self.overhead = inf

    def note(self, items: int, busy: float, elapsed: float) -> None:
        """Take in a finished block: time in the worker, and from its start to its answer [s]."""
        own = max(busy, 1e-9) / items
        self.item = own if self.item == 0 else self.item + _WEIGHT * (own - self.item)
        self.overhead = min(self.overhead, max(elapsed - busy, 0.0))

    def size(self, left: int, count: int, workers: int) -> int:
        """Give the items of the next block, of `left` that are left of `count`."""
        share = ceil(left / (_SHARES * workers))
        if self.item == 0:
            return min(share, self.first)
        if count * self.item <= self.overhead:  # shared out it would take longer
            least = count
        else:
            least = min(ceil(2 * self.overhead / self.item), ceil(count / workers))
        # Many workers would want blocks faster than one process sends them.
        longest = max(LONGEST, workers * self.overhead / _AT_ONCE)
        most = max(1, int(longest / self.item))
        return min(left, max(share, least), most)
