"""Comparisons as tables."""

from __future__ import annotations

import csv
import io
import re
import sys
from os import PathLike
from typing import TYPE_CHECKING

import numpy as np

from nfopidn.files import replace_file

if TYPE_CHECKING:
    from nfopidn.comparison.comparison import Comparison


#: The row of optima: what no controller is known to beat.
BEST_KNOWN = "best open loop found"


def number(value: float) -> str:
    """Give four digits."""
    if np.isinf(value):
        return "never"
    return f"{value:.4g}" if np.isfinite(value) else "-"


def _cells(comparison: Comparison, metric: str) -> list[list[str]]:
    """Give the medians as text; who is level with the best is marked, diverged runs are told."""
    medians = comparison.median(metric)
    diverged = comparison.values["diverged"].mean(axis=2)
    rankings = [comparison.ranking(scenario) for scenario in comparison.scenarios]
    marked = [set(one.level()) if one.is_tested() else set() for one in rankings]
    rows = []
    optima = comparison.optima if metric == "cost" else {}
    if optima:
        known = [optima.get(scenario) for scenario in comparison.scenarios]
        rows.append([BEST_KNOWN, *("-" if cost is None else number(cost) for cost in known)])
    for i, name in enumerate(comparison.controllers):
        cells = [name]
        for j, scenario in enumerate(comparison.scenarios):
            text = number(medians[i, j])
            if diverged[i, j] == 1:
                text = "diverges"
            elif diverged[i, j] > 0:
                text += f" ({diverged[i, j]:.0%} diverge)"
            elif metric == "cost" and name in marked[j]:
                text = f"**{text}**"
            best = optima.get(scenario)
            if best is not None and diverged[i, j] == 0:
                text += f" = {medians[i, j] / best:.3g} x"
            cells.append(text)
        rows.append(cells)
    return rows


def _cell(text: str) -> str:
    """Give a text that stays within its cell of a Markdown table."""
    return " ".join(text.replace("\\", "\\\\").replace("|", "\\|").split())


def _lines(header: list[str], rows: list[list[str]]) -> str:
    header, *rows = [[_cell(text) for text in row] for row in [header, *rows]]
    widths = [max(len(row[k]) for row in [header, *rows]) for k in range(len(header))]
    lines = []
    for row in [header, ["-" * width for width in widths], *rows]:
        cells = [cell.ljust(width) for cell, width in zip(row, widths, strict=True)]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def markdown(comparison: Comparison, metric: str) -> str:
    """Give medians; bold: not significantly behind the first of the column."""
    return _lines([metric, *comparison.scenarios], _cells(comparison, metric))


def details(comparison: Comparison, scenario: str) -> str:
    """Give every metric on one scenario."""
    ranking = comparison.ranking(scenario)
    place = comparison.scenarios.index(scenario)
    tables = [comparison.median(metric) for metric in comparison.values]
    rows = []
    for name, p in zip(ranking.names, ranking.p, strict=True):
        i = comparison.controllers.index(name)
        figures = [number(medians[i, place]) for medians in tables]
        rows.append([name, *figures, "" if p is None else f"{p:.2g}"])
    verdict = f"Winner: {ranking.winner}." if ranking.winner else f"No winner: {ranking.reason}."
    return _lines([scenario, *comparison.values, "p"], rows) + f"\n{verdict}\n"


def write_csv(comparison: Comparison, path: str | PathLike[str]) -> None:
    """Write a row a controller, scenario and run."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["controller", "scenario", "run", *comparison.values])
    runs = next(iter(comparison.values.values())).shape[2]
    for i, name in enumerate(comparison.controllers):
        for j, scenario in enumerate(comparison.scenarios):
            for run in range(runs):
                figures = [repr(float(v[i, j, run])) for v in comparison.values.values()]
                writer.writerow([name, scenario, run, *figures])
    replace_file(path, text.getvalue())


def print_table(comparison: Comparison, metric: str) -> None:
    """Print by rich in a terminal, else as Markdown."""
    if not sys.stdout.isatty():
        print(markdown(comparison, metric), end="")
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    table = Table(metric, *map(escape, comparison.scenarios))
    for name, *cells in _cells(comparison, metric):
        marked = [re.sub(r"\*\*(.*)\*\*", r"[bold]\1[/]", cell) for cell in cells]
        table.add_row(escape(name), *marked)
    Console().print(table)
