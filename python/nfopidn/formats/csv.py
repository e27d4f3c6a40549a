"""Tables of states or waypoints, as people have them."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn.arguments import suggestion
from nfopidn.formats.log import Array, Log
from nfopidn.trajectories.pieces import wrap

QUANTITIES = ("t", "x", "y", "theta", "v", "omega", "reverse")
#: Factors to SI of units that `units` and names in brackets may have.
UNITS = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "x": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "ft": 0.3048, "in": 0.0254},
    "theta": {"rad": 1.0, "deg": np.pi / 180},
    "v": {"m/s": 1.0, "km/h": 1 / 3.6, "cm/s": 1e-2, "mm/s": 1e-3, "mph": 0.44704},
    "omega": {"rad/s": 1.0, "deg/s": np.pi / 180, "rpm": 2 * np.pi / 60},
    "reverse": {"": 1.0},
}
UNITS["y"] = UNITS["x"]
#: Names with their unit that mean a speed; without a unit a speed's column is not used.
_SPEEDS = {
    "vx_mps": ("v", "m/s"),
    "v_mps": ("v", "m/s"),
    "v [m/s]": ("v", "m/s"),
    "v (m/s)": ("v", "m/s"),
    "speed_mps": ("v", "m/s"),
    "speed [m/s]": ("v", "m/s"),
    "velocity_mps": ("v", "m/s"),
    "velocity [m/s]": ("v", "m/s"),
    "omega_radps": ("omega", "rad/s"),
    "omega [rad/s]": ("omega", "rad/s"),
    "omega (rad/s)": ("omega", "rad/s"),
}
_WHY_NOT = {
    "v": "its name has no unit: columns={'v': 'v'} takes it as m/s",
    "speed": "its name has no unit: columns={'v': 'speed'} takes it as m/s",
    "velocity": "its name has no unit, and Autoware.ai writes km/h: columns={'v': 'velocity'}, "
    "units={'v': 'km/h'}",
    "omega": "its name has no unit: columns={'omega': 'omega'} takes it as rad/s",
    "psi_rad": "TUMFTM's programs count it from the y axis, others from the x axis: "
    "columns={'theta': 'psi_rad'} takes it as from the x axis",
    "heading": "programs differ in its zero and its sense: columns={'theta': 'heading'} takes it "
    "counter-clockwise from the x axis",
}
_CHECKED = 0.5


@dataclass(frozen=True)
class _Use:
    column: int
    factor: float
    unit: str


def _number(cell: str, path: str, line: int, name: str) -> float:
    try:
        value = float(cell)
    except ValueError:
        value = np.nan
    if not np.isfinite(value):
        raise ValueError(f"{path}:{line}: {cell!r} in column {name} is no finite number")
    return value


def _listed(names: list[str]) -> str:
    return ", ".join(name or "(no name)" for name in names)


def _given(
    path: str, names: list[str], columns: Mapping[str, str | int], units: Mapping[str, str]
) -> dict[str, _Use]:
    """Return what `columns` names."""
    found = {}
    for quantity, name in columns.items():
        if quantity not in QUANTITIES:
            hint = suggestion(quantity, QUANTITIES)
            known = ", ".join(QUANTITIES)
            raise ValueError(f"columns has {quantity!r}{hint}; must be of {known}")
        if isinstance(name, int) and not isinstance(name, bool):
            if not 0 <= name < len(names):
                raise ValueError(
                    f"{path}: columns[{quantity!r}] is {name}; the table has {len(names)} columns"
                )
            index = name
        else:
            where = [i for i, one in enumerate(names) if one == name]
            if len(where) != 1:
                many = "has no column" if not where else "has several columns"
                raise ValueError(
                    f"{path}: columns[{quantity!r}] is {name!r}{suggestion(name, names)}; the "
                    f"table {many} of this name; its columns are {_listed(names)}"
                )
            index = where[0]
        meaning, factor = _core.column_meaning(names[index])
        known_unit = meaning == quantity and factor != 1.0
        found[quantity] = _Use(index, factor if known_unit else 1.0, "as in its name")
        if not known_unit:
            found[quantity] = _Use(index, 1.0, next(iter(UNITS[quantity])))
    for quantity in units:
        if quantity not in QUANTITIES:
            known = ", ".join(QUANTITIES)
            raise ValueError(f"units has {quantity!r}; must be of {known}")
    return found


def _recognised(path: str, names: list[str], taken: dict[str, _Use]) -> dict[str, _Use]:
    """Add what the names of the columns say, where `columns` says nothing of a quantity."""
    used = {use.column for use in taken.values()}
    found: dict[str, list[tuple[bool, _Use]]] = {}
    for index, name in enumerate(names):
        if index in used:
            continue
        quantity, factor = _core.column_meaning(name)
        unit = "SI" if factor == 1.0 else f"factor {factor:.6g}"
        if name.lower() in _SPEEDS:
            quantity, unit = _SPEEDS[name.lower()]
        elif quantity not in ("t", "x", "y", "theta", "reverse"):
            continue
        found.setdefault(quantity, []).append((name == quantity, _Use(index, factor, unit)))
    result = dict(taken)
    for quantity, uses in found.items():
        if quantity in taken:
            continue
        exact = [use for is_exact, use in uses if is_exact]
        best = exact or [use for _, use in uses]
        if len(best) > 1:
            both = " and ".join(names[use.column] for use in best[:2])
            raise ValueError(
                f"{path}: columns {both} both stand for {quantity}; columns={{{quantity!r}: ...}} "
                "says which"
            )
        result[quantity] = best[0]
    return result


def _check_heading(path: str, name: str, theta: Array, x: Array, y: Array, sure: bool) -> str:
    """Refuse a heading that is in degrees, or far off the motion; say how it lies to the motion.

    Along a path a robot's heading is the direction of motion, or its opposite.
    """
    if not sure and np.abs(theta).max() > 4 * np.pi and np.ptp(np.diff(theta)) > np.pi:
        raise ValueError(
            f"{path}: column {name} reaches {theta[np.argmax(np.abs(theta))]:g} and its name has "
            "no unit; units={'theta': 'deg'} or 'rad' says which"
        )
    dx, dy = np.gradient(x), np.gradient(y)
    step = np.hypot(dx, dy)
    moving = step > 0.1 * step.max()
    off = wrap(theta - np.arctan2(dy, dx))[moving]
    line = np.abs(wrap(2 * off)) / 2  # neither forward nor backward counts as off
    if not sure and np.median(line) > _CHECKED:
        raise ValueError(
            f"{path}: column {name} is {np.median(np.abs(off)):.3g} rad off the direction of "
            f"motion at half of the {moving.sum()} moving samples or more: another zero (from the "
            f"y axis?), sense (clockwise?) or unit; columns={{'theta': {name!r}}} takes it as it "
            "is, columns={} of another column, or a table without it, the direction of motion"
        )
    backwards = np.abs(off) > np.pi / 2
    return (
        f"theta is {np.median(line):.2g} rad off the line of motion in the median, and against it "
        f"at {int(backwards.sum())} of {int(moving.sum())} moving samples"
    )


def read_csv(
    path: str | os.PathLike[str],
    columns: Mapping[str, str | int] | None = None,
    units: Mapping[str, str] | None = None,
) -> Log:
    """Return the states of a table of text.

    Any of comma, semicolon, tab and blanks separates; # and % begin comments, the last of which
    names the columns where no other line does; names may be quoted and have units (`x_m`, `t [s]`);
    cells of columns that are not used may hold anything. Columns named t (time, timestamp, stamp),
    x, y, theta (yaw), reverse are used, and speeds whose name has its unit. All others are only
    by `columns`. `notes` says what was made of each.

    Parameters
    ----------
    path
        of the file.
    columns
        The column, by name or number from 0, of t, x, y, theta, v, omega or reverse.
    units
        The unit of a quantity: s, ms, us, ns; m, cm, mm, ft, in; rad, deg; m/s, km/h, cm/s, mm/s,
        mph; rad/s, deg/s, rpm.

    Raises
    ------
    ValueError
        Names file, line and column; lists the columns found where x or y is missing.
    OSError
        The file cannot be read.
    """
    where = os.fspath(path)
    names, lines, rows = _core.read_table(path)
    units = {} if units is None else units
    given = _given(where, names, {} if columns is None else columns, units)
    uses = _recognised(where, names, given)
    missing = [name for name in ("x", "y") if name not in uses]
    if missing:
        raise ValueError(
            f"{where}: no column {' nor '.join(missing)}; the columns are {_listed(names)}; "
            f"columns={{{missing[0]!r}: ...}} says which it is"
        )
    if not rows:
        raise ValueError(f"{where}: no rows; the columns are {_listed(names)}")
    values: dict[str, Array] = {}
    said = []
    for quantity in QUANTITIES:
        if quantity not in uses:
            continue
        use = uses[quantity]
        name = names[use.column]
        factor, unit = use.factor, use.unit
        if quantity in units:
            known = UNITS[quantity]
            if units[quantity] not in known:
                raise ValueError(
                    f"units[{quantity!r}] is {units[quantity]!r}; must be one of {', '.join(known)}"
                )
            factor, unit = known[units[quantity]], units[quantity]
        cells = [
            _number(row[use.column] if use.column < len(row) else "", where, line, name)
            for row, line in zip(rows, lines, strict=True)
        ]
        if quantity == "t" and factor == 1e-9:
            values[quantity] = _nanoseconds([row[use.column] for row in rows], cells)
        else:
            values[quantity] = factor * np.array(cells)
        said.append(f"{quantity} from column {name or use.column} ({unit})")
    return _log(where, names, uses, values, said, given, units)


def _nanoseconds(cells: list[str], numbers: list[float]) -> Array:
    """Return seconds of whole nanoseconds since the epoch, which doubles round to 256 ns."""
    try:
        whole = [int(cell) for cell in cells]
    except ValueError:
        return 1e-9 * np.array(numbers)
    first = whole[0]
    return np.array([1e-9 * (one - first) for one in whole]) + round(first * 1e-9, 6)


def _log(
    where: str,
    names: list[str],
    uses: dict[str, _Use],
    values: dict[str, Array],
    said: list[str],
    given: dict[str, _Use],
    units: Mapping[str, str],
) -> Log:
    notes = [f"{where}: {', '.join(said)}"]
    taken = {use.column for use in uses.values()}
    unused = [
        (name or "(no name)") + (f" ({_WHY_NOT[name.lower()]})" if name.lower() in _WHY_NOT else "")
        for index, name in enumerate(names)
        if index not in taken
    ]
    if unused:
        notes.append("not used: " + ", ".join(unused))
    reverse = values.pop("reverse", None)
    if reverse is not None and not np.isin(reverse, (0, 1)).all():
        k = int(np.flatnonzero(~np.isin(reverse, (0, 1)))[0])
        raise ValueError(f"{where}: reverse[{k}] is {reverse[k]:g}; must be 0 or 1")
    if "theta" in values and len(values["x"]) > 2:
        sure = "theta" in given or "theta" in units
        name = names[uses["theta"].column]
        notes.append(_check_heading(where, name, values["theta"], values["x"], values["y"], sure))
    t = values.pop("t", None)
    start = 0.0 if t is None else float(t[0])
    kinds: dict[str, Any] = values
    return Log(
        t=None if t is None else t - start,
        start=start,
        reverse=None if reverse is None else reverse != 0,
        source=where,
        notes=tuple(notes),
        **kinds,
    )
