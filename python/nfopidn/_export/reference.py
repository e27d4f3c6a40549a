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
    """Count a lap: of a closed path, whose last sample is the first again, one less.

    A path that comes back to its first place looking elsewhere is not closed: the robot would be
    told to jump. Such a path closes after two laps.
    """
    size = float(np.ptp(rows[:, :2], axis=0).max())
    first, last = rows[0], rows[-1]
    there = np.hypot(*(last[:2] - first[:2])) <= 1e-5 * size
    # Headings of sampled paths are one-sided differences at the ends, and differ by a step's turn.
    step = float(np.abs(np.diff(rows[:, 2])).max(initial=0.0))
    between = np.remainder(last[2] - first[2] + np.pi, 2 * np.pi) - np.pi
    same_heading = abs(between) <= min(max(2 * step, 1e-3), np.pi / 2)
    closed = bool(there and same_heading)
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
        "lap_note": "" if lap < len(rows) else "; but it is not closed",
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
