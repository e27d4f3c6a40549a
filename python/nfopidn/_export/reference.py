"""A scenario's reference as a table."""

from __future__ import annotations

import numpy as np

from nfopidn._core import Scenario, __version__
from nfopidn._export.design import folded, literal, template

Rows = np.ndarray[tuple[int, ...], np.dtype[np.float32]]


def _rows_of(scenario: Scenario) -> Rows:
    """x, y, theta, v, omega, tau_left, tau_right, reverse a sample."""
    rows = np.array(scenario.reference)
    if not scenario.feedforward:
        rows[:, 5:7] = 0.0
    return rows.astype(np.float32)


def _lap_of(rows: Rows) -> int:
    """Count a lap: of a closed path, whose last sample is the first again, one less."""
    size = float(np.ptp(rows[:, :2], axis=0).max())
    closed = bool(np.hypot(*(rows[-1, :2] - rows[0, :2])) <= 1e-5 * size)
    return len(rows) - 1 if closed else len(rows)


def _lines(rows: Rows, columns: tuple[int, ...], truth: tuple[str, str]) -> str:
    return ",\n".join(
        "    {" + ", ".join([*(literal(row[i]) for i in columns), truth[int(row[7] != 0)]]) + "}"
        for row in rows
    )


def c_reference_texts(scenario: Scenario, name: str) -> dict[str, str]:
    """Header and source by file."""
    rows = _rows_of(scenario)
    lap = _lap_of(rows)
    words = {
        "name": name,
        "guard": name.upper(),
        "version": __version__,
        "origin": folded([f"Trajectory: {scenario.trajectory!r}"], " * "),
        "sample_time": f"{scenario.trajectory.dt:g}",
        "count": str(len(rows)),
        "lap": str(lap),
        "lap_note": "" if lap < len(rows) else "; but the path is open",
        "rows": _lines(rows, (0, 1, 2, 3, 5, 6), ("0", "1")),
    }
    return {
        f"{name}_reference.{kind}": template(f"reference.{kind}").substitute(words)
        for kind in ("h", "c")
    }


def cpp_reference_text(scenario: Scenario) -> str:
    """Write the part of the C++ header."""
    rows = _rows_of(scenario)
    return template("reference.hpp").substitute(
        sample_time=f"{scenario.trajectory.dt:g}",
        count=len(rows),
        lap=_lap_of(rows),
        rows=_lines(rows, tuple(range(7)), ("false", "true")),
    )
