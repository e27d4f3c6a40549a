"""The command `nfopidn identify`."""

from __future__ import annotations

import argparse
import sys
import warnings
from typing import Any

from nfopidn._core import Motor, Robot, Scenario
from nfopidn.commands.parsing import pairs
from nfopidn.files import check_outputs, check_picture, replace_file, save_picture
from nfopidn.formats import read_urdf
from nfopidn.identification.identifier import LOSSES, MODELS, SIGNS, identify
from nfopidn.identification.models import DRIVES
from nfopidn.identification.table import QUANTITIES, read_columns


def _given(arguments: argparse.Namespace) -> tuple[Robot | None, Motor | None]:
    """Return the robot and the motor of --scenario or --urdf."""
    if arguments.scenario and arguments.urdf:
        raise ValueError("--urdf and --scenario both have a robot; give one")
    if arguments.urdf:
        found = read_urdf(arguments.urdf)
        for note in found.notes:
            print(f"nfopidn: {note}", file=sys.stderr)
        return found.robot, None
    if not arguments.scenario:
        return None, None
    scenario = Scenario.load(arguments.scenario)
    return scenario.robot, scenario.motor if arguments.model == "voltage" else None


def _delay(word: str) -> str | int:
    return int(word) if word.isdigit() else word


def _run(arguments: argparse.Namespace) -> int:
    check_picture(arguments.plot)
    if arguments.dark and not arguments.plot:
        raise ValueError("--dark is of a picture; give --plot too")
    if arguments.output and arguments.model not in DRIVES:
        raise ValueError(
            f"--output is a scenario, which the model {arguments.model} does not find; --result"
        )
    inputs = [
        one for one in (arguments.input, arguments.scenario, arguments.urdf) if one is not None
    ]
    outputs = {
        "--output": arguments.output,
        "--result": arguments.result,
        "--plot": arguments.plot,
    }
    check_outputs(outputs, inputs=inputs)
    robot, motor = _given(arguments)
    columns = read_columns(arguments.input, pairs(arguments.column, "column", 0))
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always", UserWarning)
        found = identify(
            columns,
            arguments.model,
            robot=robot,
            motor=motor,
            signs=arguments.signs,
            free=arguments.free or None,
            known=pairs(arguments.known, "known", 1),
            delay=_delay(arguments.delay),
            max_delay=arguments.max_delay,
            window=arguments.window,
            loss=arguments.loss,
            validation=arguments.validation,
            counts_per_turn=arguments.counts_per_turn,
            counter_range=arguments.counter_range,
        )
        scenario = found.scenario if arguments.output else None
    for note in [*found.notes, *(str(one.message) for one in said)]:
        print(f"nfopidn: {note}", file=sys.stderr)
    if scenario is not None:
        replace_file(arguments.output, scenario.to_json())
    if arguments.result:
        found.to_json(arguments.result)
    if arguments.plot:
        save_picture(found.plot(dark=arguments.dark)[0].figure, arguments.plot)
    if not arguments.quiet:
        print(found)
    return 0


def add_identify(commands: Any) -> None:
    """Add the command to those of `nfopidn`."""
    parser = commands.add_parser(
        "identify",
        help="find a robot's mass, inertia, friction and delay in a log",
        description="Reads a table of commands and motion, and finds the parameters with which the "
        "simulated motion meets the measured one. What was made of the log, and what it does not "
        "tell, goes to standard error. Exit code: 0 done, 2 bad usage or bad file.",
    )
    add = parser.add_argument
    add("input", metavar="FILE", help="table with a line of names; numbers in SI units")
    add("--model", choices=MODELS, default="torque", help="what is commanded (%(default)s)")
    add("--scenario", metavar="FILE", help="has the robot, and the motor of the model voltage")
    add("--urdf", metavar="FILE", help="has the robot")
    add(
        "--column",
        action="append",
        default=[],
        metavar="QUANTITY=NAME",
        help=f"where the table has other names than {', '.join(QUANTITIES)}",
    )
    add(
        "--signs",
        choices=SIGNS,
        default="paper",
        help="whose left and right: rep103 of a real robot (%(default)s)",
    )
    add("--free", action="append", default=[], metavar="NAME", help="parameter to find (all)")
    add("--known", action="append", default=[], metavar="NAME=NUMBER", help="parameter that stays")
    add("--delay", default="whole", help="whole, fractional, or samples known (%(default)s)")
    add("--max-delay", type=int, default=10, metavar="SAMPLES", help="longest tried (%(default)s)")
    add("--window", type=float, default=4.0, metavar="SECONDS", help="of one run (%(default)s)")
    add("--loss", choices=LOSSES, default="huber", help="what outliers count (%(default)s)")
    add("--validation", type=float, default=0.25, help="share of the windows (%(default)s)")
    add("--counts-per-turn", type=float, metavar="COUNTS", help="of a wheel")
    add("--counter-range", type=float, metavar="COUNTS", help="where the counters go round")
    add("-o", "--output", metavar="FILE", help="write the log's motion as a scenario (JSON)")
    add("--result", metavar="FILE", help="write the parameters and their covariance (JSON)")
    add("--plot", metavar="FILE", help="draw measured against simulated")
    add("--dark", action="store_true", help="light strokes on dark ground, for --plot")
    add("--quiet", action="store_true", help="print nothing to standard output")
    parser.set_defaults(run=_run)
