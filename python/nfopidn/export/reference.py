"""A scenario's reference as a table."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from nfopidn._core import Scenario, __version__
from nfopidn.export.c_tracking import reference_words
from nfopidn.export.design import folded, literal, template

#: [m]: from here on a float's steps are a millimetre and more, and make torques rough.
_FARTHEST = 8192.0
#: [rad]: as far a float's steps are 6e-5 rad. The law takes whole turns off anyway.
_MOST_TURNED = 1024.0

Rows = np.ndarray[tuple[int, ...], np.dtype[np.float32]]


def _rows_of(scenario: Scenario) -> tuple[Rows, tuple[float, float]]:
    """x, y, theta, v, omega, tau_left, tau_right, reverse a sample; and where x and y are 0.

    Of a path that goes far off, as in coordinates of a map, that is its first sample: a float has
    no digits for the rest.

    Raises
    ------
    ValueError
        For a path that goes as far from its first sample.
    """
    rows = np.array(scenario.reference)
    if not scenario.feedforward:
        rows[:, 5:7] = 0.0
    origin = (0.0, 0.0)
    if np.abs(rows[:, :2]).max() > _FARTHEST:
        origin = (float(rows[0, 0]), float(rows[0, 1]))
        rows[:, :2] -= origin
        if (farthest := float(np.abs(rows[:, :2]).max())) > _FARTHEST:
            raise ValueError(
                f"the reference goes {farthest:g} m away from its first sample; must stay within "
                f"{_FARTHEST:g} m of it, or of the origin: beyond, single precision has steps of "
                "a millimetre and more"
            )
    if np.abs(rows[:, 2]).max() > _MOST_TURNED:
        rows[:, 2] = _wrapped(rows[:, 2])
    return rows.astype(np.float32), origin


def _wrapped(angles: Any) -> Any:
    """Give angles less whole turns, in [-pi, pi)."""
    return np.remainder(angles + np.pi, 2 * np.pi) - np.pi


def warn_of_origin(scenario: Scenario) -> None:
    """Warn where a table has another origin than the scenario; of the caller's caller."""
    if note := _origin_note(_rows_of(scenario)[1]):
        warnings.warn(f"reference: {note}", stacklevel=3)


def _origin_note(origin: tuple[float, float]) -> str:
    if origin == (0.0, 0.0):
        return ""
    return (
        f"The path lies far off: x and y are counted from its first sample, ({origin[0]!r}, "
        f"{origin[1]!r}) m. Take the same off every measured pose, in double precision."
    )


def _noted(origin: tuple[float, float], prefix: str) -> str:
    note = _origin_note(origin)
    return "\n" + folded([note], prefix) if note else ""


def _lap_of(rows: Rows) -> int:
    """Count a lap: of a closed path, whose last sample is the first again, one less.

    A path that comes back to its first place looking elsewhere is not closed: the robot would be
    told to jump. Such a path closes after two laps.
    """
    size = float(np.ptp(rows[:, :2], axis=0).max())
    first, last = rows[0], rows[-1]
    there = np.hypot(*(last[:2] - first[:2])) <= 1e-5 * size
    # Headings of sampled paths are one-sided differences at the ends, and differ by a step's turn.
    step = float(np.abs(_wrapped(np.diff(rows[:, 2]))).max(initial=0.0))
    between = _wrapped(last[2] - first[2])
    same_heading = abs(between) <= min(max(2 * step, 1e-3), np.pi / 2)
    closed = bool(there and same_heading)
    return len(rows) - 1 if closed else len(rows)


def _lines(rows: Rows, columns: tuple[int, ...], truth: tuple[str, str]) -> str:
    return ",\n".join(
        "    {" + ", ".join([*(literal(row[i]) for i in columns), truth[int(row[7] != 0)]]) + "}"
        for row in rows
    )


def c_reference_texts(scenario: Scenario, name: str, *, turn_rate: bool) -> dict[str, str]:
    """Header and source by file; `turn_rate`: the law reads it."""
    rows, origin = _rows_of(scenario)
    lap = _lap_of(rows)
    columns = (0, 1, 2, 3, 4, 5, 6) if turn_rate else (0, 1, 2, 3, 5, 6)
    words = {
        **reference_words(turn_rate),
        "name": name,
        "guard": name.upper(),
        "version": __version__,
        "origin": folded([f"Trajectory: {scenario.trajectory!r}"], " * ") + _noted(origin, " * "),
        "origin_x": repr(origin[0]),
        "origin_y": repr(origin[1]),
        "sample_time": f"{scenario.trajectory.dt:g}",
        "count": str(len(rows)),
        "lap": str(lap),
        "lap_note": "" if lap < len(rows) else "; but it is not closed",
        "rows": _lines(rows, columns, ("0", "1")),
    }
    return {
        f"{name}_reference.{kind}": template(f"reference.{kind}").substitute(words)
        for kind in ("h", "c")
    }


def cpp_reference_text(scenario: Scenario) -> str:
    """Write the part of the C++ header."""
    rows, origin = _rows_of(scenario)
    return template("reference.hpp").substitute(
        sample_time=f"{scenario.trajectory.dt:g}",
        count=len(rows),
        lap=_lap_of(rows),
        note=_noted(origin, "// "),
        origin_x=repr(origin[0]),
        origin_y=repr(origin[1]),
        rows=_lines(rows, tuple(range(7)), ("false", "true")),
    )
