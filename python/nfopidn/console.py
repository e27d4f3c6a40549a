"""Progress of long work: a bar in a terminal or a notebook, nothing elsewhere."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Protocol


class Report(Protocol):
    """What the work calls now and then."""

    def __call__(self, done: float, note: str) -> None:
        """Tell how much is done, and a word on it."""


def shows_progress(quiet: bool) -> bool:
    """Whether a command shows a bar: in a terminal."""
    return not quiet and sys.stderr.isatty()


@contextmanager
def progress(title: str, total: float | None, wanted: bool) -> Iterator[Report]:
    """Give a function report(done, note); `total` None stands for an unknown end."""
    if not wanted:
        yield lambda done, note: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = Console(stderr=True)
    shown = console.is_terminal or console.is_jupyter
    columns = (TextColumn(title), BarColumn(), TextColumn("{task.fields[note]}"))
    with Progress(*columns, TimeElapsedColumn(), console=console, disable=not shown) as bar:
        task = bar.add_task(title, total=total, note="")

        def report(done: float, note: str) -> None:
            bar.update(task, completed=done, note=note)

        yield report
