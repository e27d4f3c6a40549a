"""The command `nfopidn monte-carlo`."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np

from nfopidn._core import Scenario
from nfopidn.arguments import suggestion
from nfopidn.commands.parsing import pairs
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
from nfopidn.montecarlo.distributions import Choice, Distribution, LogNormal, Normal, Uniform
from nfopidn.montecarlo.draws import METHODS, PARAMETERS
from nfopidn.montecarlo.result import MonteCarloResult, check_interval, pyarrow_module
from nfopidn.montecarlo.runs import monte_carlo
from nfopidn.search.interrupts import EXIT_INTERRUPTED

_FORMS = {
    "normal": "normal:MEAN:STD",
    "uniform": "uniform:LOW:HIGH",
    "lognormal": "lognormal:MEDIAN:SIGMA",
    "choice": "choice:VALUE:VALUE...",
}


def _distribution(word: str) -> tuple[str, Distribution]:
    """Read NAME=KIND:NUMBER:NUMBER."""
    name, equals, text = word.partition("=")
    kind, *rest = text.split(":")
    if not equals or kind not in _FORMS:
        raise ValueError(
            f"--draw {word}: must be NAME={'|'.join(_FORMS.values())}{suggestion(kind, _FORMS)}"
        )
    try:
        numbers = [float(one) for one in rest]
    except ValueError:
        raise ValueError(f"--draw {word}: must have numbers after the colons") from None
    if not all(map(isfinite, numbers)):
        raise ValueError(f"--draw {word}: must be finite")
    if kind != "choice" and len(numbers) != 2:
        raise ValueError(f"--draw {word}: must be NAME={_FORMS[kind]}")
    try:
        if kind == "choice":
            return name, Choice(numbers)
        if kind == "normal":
            return name, Normal(*numbers)
        return name, Uniform(*numbers) if kind == "uniform" else LogNormal(*numbers)
    except ValueError as error:
        raise ValueError(f"--draw {word}: {error}") from None


def _distributions(words: Sequence[str]) -> dict[str, Distribution]:
    result: dict[str, Distribution] = {}
    for name, one in map(_distribution, words):
        if name in result:
            raise ValueError(f"--draw: {name} is given twice")
        result[name] = one
    return result


def _csv(result: MonteCarloResult) -> str:
    columns = result.to_columns()
    rows = np.column_stack(list(columns.values()))
    lines = [",".join(columns), *(",".join(map(repr, row)) for row in rows.tolist())]
    return "\n".join(lines) + "\n"


def _summary(result: MonteCarloResult, limits: dict[str, float], interval: str) -> dict[str, Any]:
    shares = (0.05, 0.5, 0.95, 1.0)
    worst = result.worst(min(5, len(result)))
    told: dict[str, Any] = {
        "runs": len(result),
        "seed": result.seed,
        "quantiles": dict(zip(map(str, shares), result.quantiles(shares).tolist(), strict=True)),
        "worst": [{"run": int(run), "cost": float(result.costs[run])} for run in worst],
    }
    if limits:
        found = result.yield_(limits, interval=interval)
        told["yield"] = {
            "within": found.successes,
            "share": found.share,
            "low": found.low,
            "high": found.high,
            "confidence": found.confidence,
            "interval": found.interval,
        }
    if result.parameters and len(result) > 1:
        strongest = result.sensitivity()
        told["rank_correlations"] = {
            name: value if isfinite(value) else None  # of a parameter that never changes
            for name, value in zip(strongest.names, strongest.correlations.tolist(), strict=True)
        }
    return told


def _print(result: MonteCarloResult, told: dict[str, Any], limits: dict[str, float]) -> None:
    print(result)
    print("worst: " + ", ".join(f"run {one['run']} ({one['cost']:.6g})" for one in told["worst"]))
    if limits:
        one = told["yield"]
        print(
            f"within limits: {one['within']} of {told['runs']}, {one['share']:.6g}, 95 % interval "
            f"[{one['low']:.6g}, {one['high']:.6g}] ({one['interval']})"
        )
    for name, value in told.get("rank_correlations", {}).items():
        print(
            f"  {name:18} " + ("not known: it never changes" if value is None else f"{value:+.3f}")
        )


def _write(
    result: MonteCarloResult,
    arguments: argparse.Namespace,
    limits: dict[str, float],
    faults: list[OSError | ValueError],
) -> None:
    """Write what is asked for; a file that cannot be written does not keep the others back."""
    if arguments.csv:
        with collect_fault(faults):
            replace_file(arguments.csv, _csv(result))
    if arguments.parquet:
        with collect_fault(faults):
            result.to_parquet(arguments.parquet)
    if arguments.plot:
        from nfopidn.plot import cost_histogram

        with collect_fault(faults):
            figure: Any = cost_histogram(result.costs, limits.get("cost")).figure
            save_picture(figure, arguments.plot)


def _run(arguments: argparse.Namespace) -> int:
    controller = load_controller(arguments.controller)
    inputs = [arguments.controller, *([arguments.scenario] if arguments.scenario else [])]
    check_picture(arguments.plot)
    outputs = {
        "--csv": arguments.csv,
        "--parquet": arguments.parquet,
        "--plot": arguments.plot,
        "--checkpoint": arguments.checkpoint,
    }
    check_outputs(outputs, inputs=inputs)
    if arguments.scenario:
        scenario = Scenario.load(arguments.scenario)
    else:
        scenario = Scenario.published(rng=0)
        print("nfopidn: no --scenario; runs on the published one", file=sys.stderr)
    distributions = _distributions(arguments.draw)
    limits = pairs(arguments.limit, "limit", 1)
    check_interval(arguments.interval)
    if arguments.parquet:
        pyarrow_module()  # before the runs, not after them
    interrupted = False
    try:
        result = monte_carlo(
            scenario,
            controller,
            arguments.runs,
            rng=arguments.seed,
            distributions=distributions,
            method=arguments.method,
            columns=("cost", *limits, *arguments.column),
            workers=arguments.workers,
            checkpoint=arguments.checkpoint,
            progress=shows_progress(arguments.quiet),
        )
    except KeyboardInterrupt as interrupt:
        interrupted = True
        kept = getattr(interrupt, "best", None)
        if kept is None:
            print("nfopidn: interrupted before the first block of runs", file=sys.stderr)
            return EXIT_INTERRUPTED
        result = kept
        print(f"nfopidn: interrupted; {len(result)} runs are kept", file=sys.stderr)
    faults: list[OSError | ValueError] = []
    _write(result, arguments, limits, faults)
    told = _summary(result, limits, arguments.interval)
    if arguments.json:
        print(json.dumps(told, allow_nan=False))
    elif not arguments.quiet:
        _print(result, told, limits)
    raise_kept(faults)
    return EXIT_INTERRUPTED if interrupted else 0


def add_monte_carlo(commands: Any) -> None:
    """Add the command to the others."""
    parser = commands.add_parser(
        "monte-carlo",
        help="many runs with drawn parameters: yield, worst cases, what drives them",
        description="Runs a controller on a scenario many times, each run with a robot, a start "
        "and noise of its own, and tells quantiles of the cost, the share within limits, the worst "
        "runs and which parameter drives the cost. Exit code: 0 done, 2 bad usage or bad file, "
        "130 interrupted (Ctrl-C; the runs that are done are told and written).",
        epilog="Parameters: " + ", ".join(PARAMETERS) + ", in SI units.",
    )
    add = parser.add_argument
    add("controller", metavar="CONTROLLER", help="controller file or rival file")
    add("--scenario", metavar="FILE", help="scenario file; default: the published scenario")
    add("-n", "--runs", type=int, default=10000, help="how many (%(default)s)")
    add(
        "--draw",
        action="append",
        default=[],
        metavar="NAME=KIND:NUMBERS",
        help="draw a parameter: " + ", ".join(_FORMS.values()) + "; may be given several times",
    )
    add(
        "--limit",
        action="append",
        default=[],
        metavar="METRIC=HIGHEST",
        help="count the runs within it; may be given several times",
    )
    add(
        "--column",
        action="append",
        default=[],
        metavar="METRIC",
        help="a metric to keep besides the cost; may be given several times",
    )
    add("--method", default="independent", help=", ".join(METHODS) + " (%(default)s)")
    add("--interval", default="wilson", help="wilson or clopper-pearson (%(default)s)")
    add("--seed", type=int, default=0, help="of all draws (%(default)s)")
    add("--workers", type=int, default=1, help="threads; -1: all processors (%(default)s)")
    add("--checkpoint", metavar="FILE", help="keep finished runs there, and go on from there")
    add("--csv", metavar="FILE", help="write parameters and metrics, a row a run")
    add("--parquet", metavar="FILE", help="the same as Parquet; needs nfopidn[arrow]")
    add("--plot", metavar="FILE", help="draw how the costs spread: PNG, SVG or PDF")
    add("--json", action="store_true", help="print one JSON object")
    add("--quiet", action="store_true", help="print nothing, and no progress bar")
    parser.set_defaults(run=_run)
