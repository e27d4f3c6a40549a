"""The command `nfopidn report`."""

from __future__ import annotations

import argparse
from typing import Any

from nfopidn.reporting import report


def _run(arguments: argparse.Namespace) -> int:
    print(f"written: {report(arguments.result, arguments.output)}")
    return 0


def add_report(commands: Any) -> None:
    """Add the command to those of `nfopidn`."""
    parser = commands.add_parser(
        "report",
        help="write a tuning's result as a page of HTML",
        description="Writes one HTML page, which needs no network, of what nfopidn tune --result "
        "has written: controller, search, and for each scenario the run with its metrics, the "
        "loop's stability and the basin of attraction.",
    )
    parser.add_argument("result", metavar="RESULT", help="result file (nfopidn tune --result)")
    parser.add_argument(
        "-o", "--output", default="report.html", metavar="FILE", help="page to write (%(default)s)"
    )
    parser.set_defaults(run=_run)
