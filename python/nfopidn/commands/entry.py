"""The command `nfopidn`."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from typing import Any

import nfopidn
from nfopidn import _core
from nfopidn.arguments import check_encoding
from nfopidn.commands.compare import add_compare
from nfopidn.commands.front import EXIT_DIVERGED, write_front
from nfopidn.commands.identify import add_identify
from nfopidn.commands.monte_carlo import add_monte_carlo
from nfopidn.commands.parsing import limits, pairs, parse
from nfopidn.commands.physics import add_physics
from nfopidn.commands.report import add_report
from nfopidn.commands.simulate import SIMULATE, add_simulate, simulate
from nfopidn.commands.study import add_study
from nfopidn.commands.trajectory import add_trajectory
from nfopidn.commands.verdict import add_verdict
from nfopidn.console import shows_progress
from nfopidn.files import (
    check_outputs,
    check_picture,
    collect_fault,
    load_controller,
    load_nfopidn,
    raise_kept,
    save_picture,
)
from nfopidn.robustness import Verdict, digest, read_verdict, save_with_verdict
from nfopidn.search.interrupts import EXIT_INTERRUPTED, heeded_signals
from nfopidn.search.optimise import (
    MESSAGES,
    METHODS,
    seed_of_checkpoints,
)
from nfopidn.tuning.constraints import CONSTRAINTS
from nfopidn.tuning.pareto import OBJECTIVES, POPULATION

EXIT_BAD_INPUT = 2
EXIT_BROKEN_PIPE = 141  # as a shell counts SIGPIPE


def _cap(word: str) -> float | str | None:
    """Read --cost-cap."""
    if word in ("auto", "friction"):
        return word
    if word == "none":
        return None
    try:
        return float(word)
    except ValueError:
        raise ValueError(f"--cost-cap {word}: must be a number, friction, none or auto") from None


def _options(words: Sequence[str]) -> dict[str, float]:
    given = pairs(words, "option", 1)
    return {name: int(value) if value == int(value) else value for name, value in given.items()}


def _stages(arguments: argparse.Namespace) -> Sequence[str]:
    """Return the suffixes of the checkpoints that the search's stages have besides its own."""
    if not arguments.checkpoint or arguments.structure != "taps":
        return ()
    return _core.STAGE_SUFFIXES


def _seed(arguments: argparse.Namespace) -> int:
    """Return the seed: the one given, or that of the search that goes on, or 0.

    Commands draw no seed: the same words give the same result.
    """
    if arguments.seed is not None:
        return int(arguments.seed)
    seed = seed_of_checkpoints(arguments.checkpoint or "", _stages(arguments))
    return 0 if seed is None else seed


def _tune(arguments: argparse.Namespace) -> int:
    """Tune and write; Ctrl-C and SIGTERM end the search, a second one ends the program."""
    signals = (signal.SIGINT, signal.SIGTERM)
    with heeded_signals(signals, second_ends=True) as requests:
        code = _tune_and_write(arguments)
    return EXIT_INTERRUPTED if requests.asked else code


def _tune_and_write(arguments: argparse.Namespace) -> int:
    scenarios = [nfopidn.Scenario.load(path) for path in arguments.scenario]
    start = load_controller(arguments.start) if arguments.start else None
    check_picture(arguments.plot)
    if arguments.front and not arguments.objectives:
        raise ValueError("--front is a search over objectives'; give --objectives too")
    outputs = {
        "--output": arguments.output,
        "--result": arguments.result,
        "--front": arguments.front,
        "--plot": arguments.plot,
        "--checkpoint": arguments.checkpoint,
    }
    stages = _stages(arguments)
    outputs |= {f"--checkpoint{stage}": arguments.checkpoint + stage for stage in stages}
    check_outputs(
        outputs,
        inputs=[*arguments.scenario, *([arguments.start] if arguments.start else [])],
    )
    settings: dict[str, Any] = {
        "structure": arguments.structure,
        "bounds": pairs(arguments.bound, "bound", 2) or None,
        "method": arguments.method,
        "options": _options(arguments.option),
        "rng": _seed(arguments),
        "maxfev": arguments.maxfev,
        "maxtime": arguments.maxtime,
        "stopval": arguments.stopval,
        "workers": arguments.workers,
        "checkpoint": arguments.checkpoint,
        "progress": shows_progress(arguments.quiet),
        "frozen": pairs(arguments.freeze, "freeze", 1),
        "tied": pairs(arguments.tie, "tie", 0),
        "start": start,
        "worst_share": arguments.worst_share,
        "robustness": None if arguments.nominal else "standard",
        "cost_cap": _cap(arguments.cost_cap),
        "constraints": limits(arguments.constraint, "constraint") or None,
    }
    if arguments.objectives:
        names = [name.strip() for name in arguments.objectives.split(",")]
        front = nfopidn.tune(
            scenarios or None, objectives=names, population=arguments.population, **settings
        )
        return write_front(front, arguments)
    faults: list[OSError | ValueError] = []
    try:
        result = nfopidn.tune(scenarios or None, **settings)
    except ValueError as error:  # the checkpoint cannot be written any more
        best = getattr(error, "best", None)
        if not isinstance(best, nfopidn.TuneResult):
            raise
        result = best
        faults.append(error)
    judged = _judged(result)
    with collect_fault(faults):
        if judged is None:
            result.controller.save(arguments.output)
        else:
            save_with_verdict(result.controller, arguments.output, judged)
    if arguments.result:
        with collect_fault(faults):
            result.to_json(arguments.result)
    if arguments.plot:
        with collect_fault(faults):
            save_picture(result.plot().figure, arguments.plot)
    if not arguments.quiet:
        _tell(result, judged)
        print(f"written: {arguments.output}" if not faults else "not all could be written")
    raise_kept(faults)
    if result.message == MESSAGES["interrupted"]:
        return EXIT_INTERRUPTED
    if not result.success:
        print(f"nfopidn: {result.message}", file=sys.stderr)
        return EXIT_DIVERGED
    return 0


def _tell(result: nfopidn.TuneResult, judged: Verdict | None) -> None:
    """Print what has been found."""
    print(f"cost {result.fun:.8g} after {result.nfev} evaluations, {result.elapsed:.2f} s")
    print(f"seed {result.seed}. {result.message}")
    for name, value in result.numbers():
        print(f"  {name:12} {value}")
    for name, row in result.get("constraints", {}).items():
        met = "met" if row["met"] else "NOT met"
        print(f"  {name} {row['value']:.6g} {row['unit']}: {met}")
    if judged is not None:
        print(judged.line)


def _judged(result: nfopidn.TuneResult) -> Verdict | None:
    """Judge what has been found; None where the search did not come to its end."""
    if not result.success:
        return None
    try:
        return result.verdict
    except ValueError as error:  # the reference never moves
        print(f"nfopidn: no verdict: {error}", file=sys.stderr)
        return None


def _add_tune(commands: Any) -> None:
    parser = commands.add_parser(
        "tune",
        help="search for a controller's gains and orders",
        description="Searches for the parameters of least cost (eq. 41) over the scenario's "
        "standard variations, judges what it finds, and writes it as a controller file, which "
        "nfopidn_sim --controller reads. Exit code: 0 done, 2 bad usage or bad file, 3 the best "
        "controller that was found diverges or breaks a constraint, 130 interrupted (by Ctrl-C or "
        "SIGTERM; the best so far is written).",
    )
    add = parser.add_argument
    add("-o", "--output", default="controller.json", help="controller file to write (%(default)s)")
    add(
        "--scenario",
        action="append",
        default=[],
        metavar="FILE",
        help="scenario file; may be given several times; default: the published scenario",
    )
    add(
        "--structure",
        help="tracking, paper, decoupled, incremental, extended or taps, or a rival: "
        + ", ".join(nfopidn.Rival.laws())
        + " (tracking; with --nominal: paper)",
    )
    add(
        "--nominal",
        action="store_true",
        help="search over the scenarios as they are, without variations of the robot",
    )
    add(
        "--cost-cap",
        default="auto",
        metavar="COST",
        help="a scenario's cost beyond counts by its logarithm: a number, friction (1, or ten "
        "times what friction alone costs) or none; auto: friction, with --nominal none "
        "(%(default)s)",
    )
    add("--method", default=METHODS[0], help=f"one of {', '.join(METHODS)} (%(default)s)")
    add("--option", action="append", default=[], metavar="NAME=NUMBER", help="of the method")
    add("--bound", action="append", default=[], metavar="NAME=LOW:HIGH", help="of a parameter")
    add("--freeze", action="append", default=[], metavar="NAME=NUMBER", help="keep a parameter")
    add("--tie", action="append", default=[], metavar="NAME=NAME", help="make one equal another")
    add("--start", metavar="FILE", help="controller file to start from")
    add(
        "--worst-share",
        type=float,
        default=1.0,
        help="share of the worst scenarios that counts (%(default)s: all)",
    )
    add(
        "--seed",
        type=int,
        help="of the search; default: the seed of the checkpoint that is resumed, or 0",
    )
    add("--maxfev", type=int, help="evaluations (10000 for bfoa+ and cma, one schedule for bfoa)")
    add("--maxtime", type=float, help="most time [s]")
    add("--stopval", type=float, help="end at this cost")
    add("--workers", type=int, default=1, help="threads (%(default)s)")
    add("--checkpoint", metavar="FILE", help="go on from here after an interruption")
    add(
        "--constraint",
        action="append",
        default=[],
        metavar="NAME=LOW:HIGH",
        help="keep to these limits, either of which may be left away, such as "
        f"position_rms=:0.02 or gain_margin=6: (dB); one of {', '.join(CONSTRAINTS)}",
    )
    add(
        "--objectives",
        metavar="NAME,NAME",
        help="search for a Pareto front of these, whose knee is written as the controller: "
        + ", ".join(OBJECTIVES),
    )
    add(
        "--population",
        type=int,
        default=POPULATION,
        help="with --objectives: points of a generation (%(default)s)",
    )
    add("--front", metavar="FILE", help="with --objectives: write the front (CSV)")
    add("--result", metavar="FILE", help="write the whole result (JSON)")
    add("--plot", metavar="FILE", help="draw the convergence, or the front")
    add("--quiet", action="store_true", help="print nothing")
    parser.set_defaults(run=_tune)


def _verdict_of_file(
    arguments: argparse.Namespace,
    controller: nfopidn.Controller,
    scenario: nfopidn.Scenario | None,
) -> Verdict | None:
    """Give the file's verdict; refuse to export what is red, and say where nothing is verified.

    Raises
    ------
    ValueError
        The controller file's verdict is red, and --force is not given.
    """
    found = read_verdict(arguments.controller)
    own = found is not None and found.controller_digest == digest(controller)
    if found is None or not own:
        why = "has no verdict" if found is None else "has a verdict on other numbers than its own"
        print(
            f"nfopidn: {arguments.controller} {why}: not verified; nfopidn verdict "
            f"{arguments.controller} -o FILE gives it one",
            file=sys.stderr,
        )
        return None
    print(f"nfopidn: {found.line}", file=sys.stderr)
    if not found.is_of(controller, scenario):
        where = "no scenario is given" if scenario is None else "the scenario given is another"
        print(
            f"nfopidn: {where}; the verdict is on scenario {found.scenario_digest}: not verified",
            file=sys.stderr,
        )
    if found.colour == "red" and not arguments.force:
        raise ValueError(
            f"{arguments.controller} is not exported, since its verdict is red: "
            f"{'; '.join(found.reasons)}; --force exports it all the same"
        )
    return found


def _export(arguments: argparse.Namespace) -> int:
    controller = load_nfopidn(arguments.controller)
    scenario = nfopidn.Scenario.load(arguments.scenario) if arguments.scenario else None
    verdict = _verdict_of_file(arguments, controller, scenario)
    written = []
    in_c = arguments.c or not arguments.cpp
    if arguments.hardware and not in_c:
        raise ValueError("--hardware is written in C; give --c too")
    if arguments.longest_step is not None and not arguments.hardware:
        raise ValueError("--longest-step is the odometry's; give --hardware too")
    if arguments.velocity_limits is not None and not arguments.hardware:
        raise ValueError("--velocity-limits are the hardware's; give --hardware too")
    if in_c:
        name = "nfopidn" if arguments.name is None else arguments.name
        written += nfopidn.export_c(
            controller,
            arguments.output,
            scenario=scenario,
            name=name,
            hardware=arguments.hardware,
            reference=arguments.reference,
            longest_step=arguments.longest_step,
            velocity_limits=arguments.velocity_limits,
            verdict=verdict,
        )
    if arguments.cpp:
        name = "nfopidn_controller" if arguments.name is None else arguments.name
        written += nfopidn.export_cpp(
            controller,
            arguments.output,
            scenario=scenario,
            name=name,
            reference=arguments.reference,
            verdict=verdict,
        )
    for path in written:
        print(path)
    return 0


def _add_export(commands: Any) -> None:
    parser = commands.add_parser(
        "export",
        help="write a controller as source code for a microcontroller",
        description="Writes a controller file as C99 (one header, one source, needs nothing else) "
        "or as a C++ header on the library's core, in single precision.",
    )
    add = parser.add_argument
    add("controller", metavar="CONTROLLER", help="controller file")
    add("--c", action="store_true", help="write NAME.h and NAME.c (the default)")
    add("--cpp", action="store_true", help="write NAME.hpp")
    add("-o", "--output", default=".", metavar="DIR", help="where to (%(default)s)")
    add(
        "--scenario",
        metavar="FILE",
        help="gives the torque limit, the peak speed, the robot, the sample time and the reference",
    )
    add(
        "--hardware",
        action="store_true",
        help="in C, also NAME_hardware.h and .c: what stands between the law and a real robot; "
        "needs --scenario",
    )
    add(
        "--longest-step",
        type=float,
        metavar="METRES",
        help="with --hardware: the farthest a wheel can roll in a sample; beyond, an encoder has "
        "failed (ten times what the reference asks)",
    )
    add(
        "--velocity-limits",
        type=float,
        nargs=4,
        metavar=("V", "OMEGA", "ACCELERATION", "ANGULAR"),
        help="with --hardware, for bases that take velocities: the most m/s, rad/s, m/s^2 and "
        "rad/s^2; 0: the base does not move; inf: no limit (the default)",
    )
    add("--reference", action="store_true", help="also the reference, as a table; needs --scenario")
    add("--force", action="store_true", help="export a controller whose verdict is red")
    add("--name", help="prefix in C (nfopidn), namespace in C++ (nfopidn_controller)")
    parser.set_defaults(run=_export)


def main(words: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit code.

    0 done, 2 bad input, 3 the run of simulate or the best controller of tune diverges or a verdict
    is red, 130 interrupted, 141 the reader of standard output has gone.
    """
    words = sys.argv[1:] if words is None else list(words)
    if words[:1] == [SIMULATE]:
        return simulate(words[1:])
    parser = argparse.ArgumentParser(prog="nfopidn", description=nfopidn.__doc__)
    parser.add_argument("--version", action="version", version=f"nfopidn {nfopidn.__version__}")
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    add_simulate(commands)
    _add_tune(commands)
    _add_export(commands)
    add_compare(commands)
    add_monte_carlo(commands)
    add_physics(commands)
    add_report(commands)
    add_study(commands)
    add_trajectory(commands)
    add_identify(commands)
    add_verdict(commands)
    try:
        for word in words:
            check_encoding("", word)
        arguments = parse(parser, commands.choices, words)
        code = int(arguments.run(arguments))
        sys.stdout.flush()
        return code
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # nor at exit
        return EXIT_BROKEN_PIPE
    except (ValueError, OSError, ImportError) as error:
        print(f"nfopidn: {error}", file=sys.stderr)
        return EXIT_BAD_INPUT
    except KeyboardInterrupt:
        print("nfopidn: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
