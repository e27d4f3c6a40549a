"""The command `nfopidn compare`."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from nfopidn._core import Scenario
from nfopidn.comparison.comparison import METRICS, Comparison, compare
from nfopidn.comparison.contenders import (
    CONTENDERS,
    GROUPS,
    AnyController,
    contender_names,
    tune_contenders,
)
from nfopidn.comparison.suite import CONDITIONS, path_names, scenario_suite
from nfopidn.console import shows_progress
from nfopidn.files import (
    check_outputs,
    check_picture,
    collect_fault,
    load_controller,
    raise_kept,
    replace_file,
    save_picture,
)
from nfopidn.search.interrupts import EXIT_INTERRUPTED

DESCRIPTION = """Tunes controllers alike, by the same search with the same budget and seeds, runs
them on the same scenarios, and prints their costs (eq. 41) and who is ahead."""


def _epilogue() -> str:
    return (
        f"controllers: {', '.join(map(repr, CONTENDERS))}; groups: {', '.join(GROUPS)}.\n"
        f"scenarios: {', '.join(path_names())}; with /CONDITION: {', '.join(CONDITIONS)}."
    )


def _scenarios(names: list[str]) -> dict[str, Scenario]:
    """Give those of the suite, and those in files."""
    return {
        name: Scenario.load(name) if name.endswith(".json") else scenario_suite([name])[name]
        for name in names
    }


def _controllers(
    arguments: argparse.Namespace, scenario: Scenario
) -> tuple[dict[str, list[AnyController]], bool]:
    """Load and tune; also whether all are there, and Ctrl-C did not come between."""
    files = [name for name in arguments.controllers if name.endswith(".json")]
    names = contender_names([name for name in arguments.controllers if name not in files])
    loaded: dict[str, list[AnyController]] = {name: [load_controller(name)] for name in files}
    tuned = tune_contenders(
        names,
        scenario,
        seeds=arguments.seeds,
        maxfev=arguments.maxfev,
        workers=arguments.workers,
        progress=shows_progress(arguments.quiet),
    )
    return {**loaded, **tuned}, len(tuned) == len(names)


def _result(
    arguments: argparse.Namespace, scenarios: dict[str, Scenario], tuned_on: str
) -> tuple[Comparison | None, bool]:
    """Tune and compare; of what Ctrl-C has ended, what is complete."""
    if not arguments.tune_each:
        controllers, complete = _controllers(arguments, _scenarios([tuned_on])[tuned_on])
        if not controllers:
            return None, complete
        shown = shows_progress(arguments.quiet)
        return compare(controllers, scenarios, workers=arguments.workers, progress=shown), complete
    parts: list[Comparison] = []
    for name, scenario in scenarios.items():
        controllers, complete = _controllers(arguments, scenario)
        if complete or (controllers and not parts):
            parts.append(compare(controllers, {name: scenario}, workers=arguments.workers))
        if not complete:
            return parts[0].join(parts[1:]) if parts else None, False
    return parts[0].join(parts[1:]), True


def _check_extras(arguments: argparse.Namespace) -> None:
    """Refuse what the end of the work would need and not find, before any work.

    Raises
    ------
    ImportError
        Tells how to install what is missing.
    """
    if arguments.optimum:
        from nfopidn.study.transcription import casadi

        casadi()


def _optima(scenarios: dict[str, Scenario], tell: bool) -> dict[str, float | None]:
    """Find the best open-loop costs; of one with the exact integrator there is none."""
    from nfopidn.study import open_loop_optimum

    optima: dict[str, float | None] = dict.fromkeys(scenarios)
    for name, scenario in scenarios.items():
        try:
            found = open_loop_optimum(scenario, progress=shows_progress(not tell))
            optima[name], message = found.cost, found.message
        except ValueError as error:
            message = str(error)
        if tell and optima[name] is None:
            print(f"{name}: no optimum: {message}", file=sys.stderr)
    return optima


def _compare(arguments: argparse.Namespace) -> int:
    if arguments.tune_each and arguments.tune_on is not None:
        raise ValueError(f"--tune-on {arguments.tune_on}: does not apply with --tune-each")
    tuned_on = arguments.tune_on or "published"
    check_picture(arguments.plot)
    check_outputs(
        {"--csv": arguments.csv, "--markdown": arguments.markdown, "--plot": arguments.plot},
        inputs=[*arguments.controllers, *arguments.scenarios, tuned_on],
    )
    _check_extras(arguments)
    scenarios = _scenarios(arguments.scenarios)
    result, complete = _result(arguments, scenarios, tuned_on)
    if not complete:
        print("nfopidn: interrupted; the rest is of what was complete", file=sys.stderr)
    if result is None:
        return EXIT_INTERRUPTED
    if arguments.optimum and complete:
        result = result.with_optima(_optima(scenarios, not arguments.quiet))
    texts = [result.to_markdown(metric) for metric in arguments.metric]
    texts += [result.details(name) for name in result.scenarios if arguments.details]
    faults: list[OSError | ValueError] = []
    if arguments.csv:
        with collect_fault(faults):
            result.to_csv(arguments.csv)
    if arguments.markdown:
        with collect_fault(faults):
            replace_file(arguments.markdown, "\n".join(texts))
    if arguments.plot:
        with collect_fault(faults):
            save_picture(result.plot(arguments.metric[0]).figure, arguments.plot)
    if not arguments.quiet:
        for metric in arguments.metric:
            result.print(metric)
        for name in result.scenarios:
            ranking = result.ranking(name)
            verdict = f"winner {ranking.winner}" if ranking.winner else ranking.reason
            print(f"{name}: {verdict}" if not arguments.details else f"\n{result.details(name)}")
    raise_kept(faults)
    return 0 if complete else EXIT_INTERRUPTED


def add_compare(commands: Any) -> None:
    """Add the command."""
    parser = commands.add_parser(
        "compare",
        help="tune and compare NFOPIDN and its rivals",
        description=DESCRIPTION,
        epilog=_epilogue(),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add(
        "--controllers",
        nargs="+",
        default=["all"],
        metavar="NAME",
        help="names or groups as below, or controller files (%(default)s)",
    )
    add(
        "--scenarios",
        nargs="+",
        default=["published", "continuous", "continuous-fast"],
        metavar="NAME",
        help="names as below, or scenario files (published continuous continuous-fast)",
    )
    add("--tune-on", metavar="NAME", help="where all are tuned (published)")
    add("--tune-each", action="store_true", help="tune again for each scenario instead")
    add("--seeds", type=int, default=10, help="searches of each controller (%(default)s)")
    add("--maxfev", type=int, default=10_000, help="evaluations of a search (%(default)s)")
    add("--workers", type=int, default=1, help="threads (%(default)s)")
    add("--metric", nargs="+", default=["cost"], choices=list(METRICS), help="(cost)")
    add("--optimum", action="store_true", help="also multiples of the best open loop (CasADi)")
    add("--details", action="store_true", help="every metric of each scenario")
    add("--csv", metavar="FILE", help="write every figure")
    add("--markdown", metavar="FILE", help="write the tables")
    add("--plot", metavar="FILE", help="draw the first metric")
    add("--quiet", action="store_true", help="print nothing")
    parser.set_defaults(run=_compare)
