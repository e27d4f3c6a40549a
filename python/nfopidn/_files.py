"""Files that the commands are given, and that they write."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from os import PathLike
from pathlib import Path

from nfopidn._core import Controller, Rival


def load_controller(path: str) -> Controller | Rival:
    """Read a controller file or a rival file.

    Raises
    ------
    ValueError
        Names the file, and what in it is not as it must be.
    """
    try:
        rival = json.loads(Path(path).read_text(encoding="utf-8"))["format"] == "nfopidn-rival"
    except (OSError, ValueError, TypeError, KeyError):  # Controller.load says what is wrong
        rival = False
    return Rival.load(path) if rival else Controller.load(path)


def check_picture(path: str | None) -> None:
    """Refuse a picture's name that matplotlib has no format for, before any work."""
    if path is None:
        return
    from matplotlib.backend_bases import FigureCanvasBase

    known = FigureCanvasBase.get_supported_filetypes()
    if Path(path).suffix[1:].lower() not in known:
        raise ValueError(f"--plot {path}: must end in one of {', '.join(sorted(known))}")


@contextmanager
def draft_of(path: str | PathLike[str]) -> Iterator[Path]:
    """Give a draft to write, which takes the file's place at the end: whole or not at all."""
    target = Path(path)
    draft = target.with_name(target.name + ".part")
    try:
        yield draft
        draft.replace(target)
    finally:
        draft.unlink(missing_ok=True)


def replace_file(path: str | PathLike[str], text: str) -> None:
    """Write a file whole or not at all."""
    with draft_of(path) as draft:
        draft.write_text(text, encoding="utf-8")
