"""A log as a table in a file: a line of names, then rows of numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn.arguments import suggestion

Array = NDArray[np.float64]

QUANTITIES = (
    *("t", "x", "y", "theta", "counts_left", "counts_right", "tau_left", "tau_right"),
    *("voltage_left", "voltage_right", "v_command", "omega_command", "t_command"),
)


def read_columns(path: str, columns: Mapping[str, str] | None = None) -> dict[str, Array]:
    """Return the columns of a table that identify() knows, by their names or as `columns` says.

    The separator is a comma, a semicolon, a tab or blanks; lines that begin with # or % are
    comments, of which the last before the rows may have the names. Numbers are taken in SI units.

    Raises
    ------
    ValueError
        No names, a name in `columns` that the table lacks, a cell that is no number; by its line.
    """
    lines = [
        (number, line.strip())
        for number, line in enumerate(_core.read_text(path).splitlines(), 1)
        if line.strip()
    ]
    while len(lines) > 1 and lines[0][1][0] in "#%" and lines[1][1][0] in "#%":
        lines.pop(0)
    if len(lines) < 2:
        raise ValueError(f"{path}: has {len(lines)} lines; must have a line of names and rows")
    head = lines[0][1].lstrip("#% \ufeff")
    separator = next((mark for mark in ",;\t" if mark in head), None)
    names = [name.strip().strip('"') for name in head.split(separator)]
    given = {name: name for name in QUANTITIES if name in names} | dict(columns or {})
    for quantity, name in given.items():
        if quantity not in QUANTITIES:
            hint = suggestion(quantity, QUANTITIES)
            known = ", ".join(QUANTITIES)
            raise ValueError(f"column {quantity!r}{hint} is unknown; must be one of {known}")
        if names.count(name) != 1:
            many = "no column" if name not in names else "several columns"
            raise ValueError(
                f"{path}: {quantity} is {name!r}{suggestion(name, names)}, of which name the table "
                f"has {many}; it has {', '.join(names)}"
            )
    places = {quantity: names.index(name) for quantity, name in given.items()}
    rows = [(number, line.split(separator)) for number, line in lines[1:] if line[0] not in "#%"]
    return {
        quantity: np.array([_number(path, number, cells, place) for number, cells in rows])
        for quantity, place in places.items()
    }


def _number(path: str, line: int, cells: list[str], place: int) -> float:
    cell = cells[place].strip() if place < len(cells) else ""
    try:
        return float(cell)
    except ValueError:
        raise ValueError(f"{path}:{line}: {cell!r} in column {place + 1} is no number") from None
