"""The command `nfopidn study`."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from nfopidn.console import shows_progress
from nfopidn.search.interrupts import EXIT_INTERRUPTED


def _study(arguments: argparse.Namespace) -> int:
    from nfopidn.study.cases import InterruptedSearchError
    from nfopidn.study.reproduction import reproduce

    shown = shows_progress(arguments.quiet)
    try:
        files = reproduce(
            arguments.output,
            seeds=arguments.seeds,
            workers=arguments.workers,
            progress=shown,
        )
    except (KeyboardInterrupt, InterruptedSearchError):
        print("nfopidn: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    if not arguments.quiet:
        print(f"{len(files)} files written: {arguments.output}")
    return 0


def add_study(commands: Any) -> None:
    """Add the command to the others."""
    parser = commands.add_parser(
        "study",
        help="draw the paper's figures and tables again, and more",
        description="Writes the paper's tables and figures, the cost against the memory, other "
        "initial poses, other readings of the paper and the open-loop optima: figures as PNG and "
        "SVG, numbers as CSV and JSON. Needs nfopidn[optimum].",
    )
    add = parser.add_argument
    add("-o", "--output", default="study", metavar="DIR", help="where to (%(default)s)")
    add(
        "--seeds",
        type=int,
        default=25,
        help="searches for each of the eight memories (%(default)s)",
    )
    add("--workers", type=int, default=1, help="threads; -1: all processors (%(default)s)")
    add("--quiet", action="store_true", help="print nothing")
    parser.set_defaults(run=_study)
