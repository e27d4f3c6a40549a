"""What `nfopidn tune --objectives` writes."""

from __future__ import annotations

import argparse
import sys

from nfopidn.files import collect_fault, raise_kept, save_picture
from nfopidn.robustness import Verdict, save_with_verdict
from nfopidn.search.interrupts import EXIT_INTERRUPTED
from nfopidn.search.optimise import MESSAGES
from nfopidn.tuning.pareto_result import ParetoResult

EXIT_DIVERGED = 3


def write_front(front: ParetoResult, arguments: argparse.Namespace) -> int:
    """Write the knee's controller, the front and its picture; returns the exit code."""
    faults: list[OSError | ValueError] = []
    judged: Verdict | None = None
    if len(front):
        knee = front.choose()
        judged = _judged(front, knee)
        with collect_fault(faults):
            if judged is None:
                front.controllers[knee].save(arguments.output)
            else:
                save_with_verdict(front.controllers[knee], arguments.output, judged)
        if arguments.plot:
            with collect_fault(faults):
                panels = front.plot()
                panel = panels if len(front.objective_names) == 2 else panels[0]
                save_picture(panel.figure, arguments.plot)
    if arguments.front:
        with collect_fault(faults):
            front.to_csv(arguments.front)
    if arguments.result:
        with collect_fault(faults):
            front.to_json(arguments.result)
    if not arguments.quiet:
        print(front)
        print(f"seed {front.seed}")
        if judged is not None:
            print(f"knee: {judged.line}")
        if len(front):
            print("not all could be written" if faults else f"written: {arguments.output}")
    raise_kept(faults)
    if front.message.endswith(MESSAGES["interrupted"]):
        return EXIT_INTERRUPTED
    if not front.success:
        print(f"nfopidn: {front.message}", file=sys.stderr)
        return EXIT_DIVERGED
    return 0


def _judged(front: ParetoResult, place: int) -> Verdict | None:
    if not front.success:
        return None
    try:
        return front.verdict(place)
    except ValueError as error:  # the reference never moves
        print(f"nfopidn: no verdict: {error}", file=sys.stderr)
        return None
