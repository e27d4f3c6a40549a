"""Tune every contender over the same families with the same budget and seeds; print the costs.

Usage: python bench/family_contest.py [--families P R G J] [--seeds 1 2 3 4 5] [--csv contest.csv]

P is the published scenario alone; the other families are those of nfopidn.families.benchmark. A
contender is a structure of nfopidn.tune(); a law with "differenced" takes the speeds from the last
two poses, as a robot without speed sensors must, and one with "integral" has integral action.
Costs are min(E, 1); a cell is the median over the seeds of the mean over the family, and, after
the stroke, the worst scenario of the median seed.
"""

import argparse
import csv
import sys
import time

import nfopidn
import numpy as np
from families import costs
from nfopidn.families import benchmark

LAWS = ("samson", "lqr", "takagi-sugeno", "sliding-mode")
STRUCTURES = ("tracking", "extended", "incremental")


def contenders():
    """Give the structures by name."""
    named = {name: name for name in STRUCTURES}
    for law in LAWS:
        for speeds in ("measured", "differenced"):
            for integral in (False, True):
                words = [law, *(["differenced"] if speeds == "differenced" else [])]
                words += ["integral"] if integral else []
                named[" ".join(words)] = {"law": law, "speeds": speeds, "integral": integral}
    return named


def scenarios_of(name):
    """Give the scenarios of a family; of P the published one."""
    return [nfopidn.Scenario.published(rng=0)] if name == "P" else benchmark(name)


def contest(families, seeds, chosen, maxfev, workers):
    """Give rows (contender, family, seed, mean, worst, seconds), as they are found."""
    for family in families:
        scenarios = scenarios_of(family)
        for name, structure in contenders().items():
            if chosen and name not in chosen:
                continue
            for seed in seeds:
                begun = time.perf_counter()
                found = nfopidn.tune(
                    scenarios,
                    structure=structure,
                    robustness=None,
                    cost_cap=1.0 if family != "P" else None,
                    maxfev=maxfev,
                    rng=seed,
                    workers=workers,
                )
                each = costs(scenarios, found.controller)
                yield name, family, seed, each.mean(), each.max(), time.perf_counter() - begun


def table(rows, families):
    """Print the medians as a table of Markdown."""
    names = list(dict.fromkeys(row[0] for row in rows))
    print("| contender | " + " | ".join(families) + " |")
    print("| --- |" + " --- |" * len(families))
    for name in names:
        cells = []
        for family in families:
            found = sorted((row[3], row[4]) for row in rows if row[:2] == (name, family))
            mean, worst = found[(len(found) - 1) // 2] if found else (np.nan, np.nan)
            cells.append(f"{mean:.4f}" if family == "P" else f"{mean:.4f} / {worst:.3f}")
        print(f"| {name} | " + " | ".join(cells) + " |")


def main():
    """Run the contest that the arguments ask for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--families", nargs="+", default=["P", "R", "G", "J"])
    parser.add_argument("--seeds", nargs="+", type=int, default=[1, 2, 3, 4, 5])
    parser.add_argument("--contenders", nargs="+", choices=list(contenders()))
    parser.add_argument("--maxfev", type=int, default=10_000)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--csv", help="where each search's row goes, as soon as it is found")
    arguments = parser.parse_args()
    rows = []
    log = open(arguments.csv, "w", newline="") if arguments.csv else None  # noqa: SIM115
    chosen = (arguments.families, arguments.seeds, arguments.contenders)
    for row in contest(*chosen, arguments.maxfev, arguments.workers):
        rows.append(row)
        print(*row, file=sys.stderr, flush=True)
        if log:
            csv.writer(log).writerow(row)
            log.flush()
    table(rows, arguments.families)


if __name__ == "__main__":
    main()
