"""`nfopidn simulate`: the executable nfopidn_sim, as a command of the wheel."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from typing import Any

from nfopidn import _core

#: The command's word. What follows it is read by the C++ function that nfopidn_sim is made of.
SIMULATE = "simulate"


def simulate(words: Sequence[str]) -> int:
    """Run a scenario as nfopidn_sim does with the same words; returns its exit code.

    0 done, 2 bad input, 3 the run diverged, 130 the search of `--tune` was interrupted. Text goes
    to the process's own standard output and standard error, not to what stands for them in `sys`.
    Until the command is done, Ctrl-C and SIGTERM end a search, which then writes its best, and end
    the process where nothing is searched for.
    """
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    return _core.run_simulate(f"nfopidn {SIMULATE}", [os.fsencode(word) for word in words])


def add_simulate(commands: Any) -> None:
    """List the command in the help."""
    commands.add_parser(
        SIMULATE, help="run a scenario under a controller, as nfopidn_sim does", add_help=False
    )
