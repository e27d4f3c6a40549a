"""The command `nfopidn verdict`."""

from __future__ import annotations

import argparse
import json
from typing import Any

from nfopidn._core import Scenario
from nfopidn.files import check_outputs, load_controller
from nfopidn.robustness import Verdict, read_verdict, save_with_verdict, scenario_digest, verdict

EXIT_RED = 3


def _run(arguments: argparse.Namespace) -> int:
    controller = load_controller(arguments.controller)
    scenario = (
        Scenario.load(arguments.scenario) if arguments.scenario else Scenario.published(rng=0)
    )
    check_outputs({"--output": arguments.output})
    found = verdict(
        controller,
        scenario,
        at_bound=_left_on_a_bound(read_verdict(arguments.controller), scenario),
        workers=arguments.workers,
    )
    if arguments.output:
        save_with_verdict(controller, arguments.output, found)
    print(json.dumps(found.to_dict(), allow_nan=False) if arguments.json else found)
    return EXIT_RED if found.colour == "red" else 0


def _left_on_a_bound(before: Verdict | None, scenario: Scenario) -> tuple[str, ...]:
    """Give what the file's own verdict knows of the search, if it is on the same scenario."""
    if before is None or before.digest != scenario_digest(scenario):
        return ()
    return before.at_bound


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
