"""The command `nfopidn verdict`."""

from __future__ import annotations

import argparse
import json
import sys
from typing import Any

from nfopidn._core import Scenario
from nfopidn.files import check_outputs, load_controller
from nfopidn.robustness import read_verdict, save_with_verdict, verdict

EXIT_RED = 3


def _run(arguments: argparse.Namespace) -> int:
    controller = load_controller(arguments.controller)
    if arguments.scenario:
        scenario = Scenario.load(arguments.scenario)
    else:
        scenario = Scenario.published(rng=0)
        print("nfopidn: no --scenario; judged on the published one", file=sys.stderr)
    check_outputs({"--output": arguments.output})
    before = read_verdict(arguments.controller)  # which knows what a search left on a bound
    known = before is not None and before.is_of(controller, scenario)
    found = verdict(
        controller,
        scenario,
        at_bound=before.at_bound if before is not None and known else (),
        workers=arguments.workers,
    )
    if arguments.output:
        save_with_verdict(controller, arguments.output, found)
    print(json.dumps(found.to_dict(), allow_nan=False) if arguments.json else found)
    return EXIT_RED if found.colour == "red" else 0


def add_verdict(commands: Any) -> None:
    """Add the command to those of `nfopidn`."""
    parser = commands.add_parser(
        "verdict",
        help="judge a controller: stability, margins, what it bears",
        description="Judges a controller or a rival on a scenario: its cost on the standard "
        "variations, whether it is stable on its path, its margins, and how much delay, mass "
        "error, friction and distance at the start it bears. Exit code: 0 green or amber, 2 bad "
        "usage or bad file, 3 red.",
    )
    add = parser.add_argument
    add("controller", metavar="CONTROLLER", help="controller file or rival file")
    add("--scenario", metavar="FILE", help="scenario file; default: the published scenario")
    add("--json", action="store_true", help="print one JSON object instead of the table")
    add("-o", "--output", metavar="FILE", help="write the controller file with its verdict")
    add("--workers", type=int, default=1, help="threads (%(default)s)")
    parser.set_defaults(run=_run)
