"""The folder that a study fills: figures as PNG and SVG, tables as CSV and JSON."""

from __future__ import annotations

import csv
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from io import StringIO
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING, Any

import numpy as np

from nfopidn.files import replace_file, save_picture

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_DOTS_PER_INCH = 100
_WRITTEN_BY = "Written by `nfopidn study`"
_BEGINNING = 4096  # bytes of README.md that tell of what it is
#: What would differ from one run of the study to the next.
_SAME_EACH_TIME: dict[str, dict[str, Any]] = {
    "png": {"Software": None},
    "svg": {"Date": None, "Creator": None},
}
_SETTINGS: Any = {"svg.hashsalt": "nfopidn", "path.simplify_threshold": 0.2}

Cell = str | float | int | None


@dataclass
class Folder:
    """Where a study writes, and what it has written: titles by name."""

    path: Path
    figures: dict[str, str] = field(default_factory=dict)
    tables: dict[str, str] = field(default_factory=dict)

    def figure(self, name: str, title: str, figure: Figure) -> None:
        """Write NAME.png and NAME.svg, the same bytes for the same figure."""
        import matplotlib as mpl

        if figure.get_layout_engine() is not None:  # once, not for each file
            figure.set_dpi(_DOTS_PER_INCH)
            figure.draw_without_rendering()
            figure.set_layout_engine("none")
        for kind, metadata in _SAME_EACH_TIME.items():
            path = self.path / f"{name}.{kind}"
            with mpl.rc_context(_SETTINGS):
                save_picture(figure, path, dpi=_DOTS_PER_INCH, metadata=metadata)
        self.figures[name] = title

    def table(
        self,
        name: str,
        title: str,
        columns: Mapping[str, Sequence[Cell] | np.ndarray[Any, Any]],
        units: Mapping[str, str],
        digits: int = 17,
    ) -> None:
        """Write NAME.csv and NAME.json: numbers to so many digits, None as nothing and as null.

        `units` has the columns that have a unit.
        """
        plain = {key: [_plain(cell, digits) for cell in column] for key, column in columns.items()}
        text = StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(plain)
        writer.writerows(zip(*plain.values(), strict=True))
        document = {"title": title, "units": dict(units), "columns": plain}
        self._text(f"{name}.csv", text.getvalue())
        self._text(f"{name}.json", _json(document))
        self.tables[name] = title

    def index(self, heading: str) -> None:
        """Write README.md: what the folder has."""
        text = StringIO()
        text.write(f"# {heading}\n\n{_WRITTEN_BY}; not edited by hand.\n")
        text.write("\n| figure | |\n| --- | --- |\n")
        for name, title in self.figures.items():
            text.write(f"| [{name}]({name}.png) ([SVG]({name}.svg)) | {title} |\n")
        text.write("\n| table | |\n| --- | --- |\n")
        for name, title in self.tables.items():
            text.write(f"| [{name}]({name}.csv) ([JSON]({name}.json)) | {title} |\n")
        self._text("README.md", text.getvalue())

    def written(self) -> list[Path]:
        """Return every file written, sorted."""
        names = [f"{name}.{kind}" for name in self.figures for kind in ("png", "svg")]
        names += [f"{name}.{kind}" for name in self.tables for kind in ("csv", "json")]
        return [self.path / name for name in sorted([*names, "README.md"])]

    def _text(self, name: str, text: str) -> None:
        replace_file(self.path / name, text)


def make_folder(path: str | os.PathLike[str]) -> Folder:
    """Make a folder, if it is not there, and see that it can be written.

    Raises
    ------
    OSError
        If it cannot.
    ValueError
        If it has a README.md that is not of a study.
    """
    folder = Path(path)
    folder.mkdir(parents=True, exist_ok=True)
    index = folder / "README.md"
    if index.exists() and not _is_of_study(index):
        raise ValueError(f"{index}: is not of a study, and would be replaced; give another folder")
    with TemporaryFile(dir=folder):
        return Folder(folder)


def _is_of_study(index: Path) -> bool:
    """Whether the beginning of a file, which may have no end, says so."""
    with index.open("rb") as file:
        return _WRITTEN_BY.encode() in file.read(_BEGINNING)


def _plain(cell: Any, digits: int) -> Cell:
    value = cell.item() if isinstance(cell, np.generic) else cell
    if isinstance(value, float):
        return float(f"{value:.{digits}g}") if np.isfinite(value) else None
    if value is None or isinstance(value, str | int):
        return value
    raise TypeError(f"a cell is a {type(value).__name__}; must be text, a number or None")


def _json(document: Mapping[str, Any]) -> str:
    """Return a document with one line a column."""
    lines = ",\n".join(
        f"  {json.dumps(key)}: {json.dumps(column)}" for key, column in document["columns"].items()
    )
    head = json.dumps({key: document[key] for key in ("title", "units")}, ensure_ascii=False)
    return f'{head[:-1]},\n "columns": {{\n{lines}\n }}}}\n'
