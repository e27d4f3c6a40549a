"""Figures of the search and of stability: convergence, multipliers, basin of attraction."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn.plot.stability import OUTER_RING, drawn_multipliers
from nfopidn.reporting.numbers import readable, short
from nfopidn.reporting.strokes import (
    MAP_EDGE,
    ON_MAP,
    OTHER,
    ROBOT,
    Figure,
    Trace,
    axis,
    figure,
    line,
    markers,
)
from nfopidn.stability import Basin, LoopStability

Array = NDArray[np.float64]

_SMALLEST = 0.01  # end of the basin's scale of errors [m]
_RING = {"colour": "ring", "width": 1.2}
_OUTER = {"colour": "ring", "width": 1, "dash": [2, 3]}
_MAP_COLOURS = 64


def convergence(history: Any) -> Figure:
    """Draw the best cost so far, and the mean of the cells, against evaluations."""
    best = history["best"]
    columns = {
        "nfev": short(history["nfev"], 12),
        "best": short(best),
        "mean": short(history["mean"]),
    }
    traces = [
        line("@nfev", "@mean", "mean of the cells", OTHER),
        line("@nfev", "@best", "best so far", {**ROBOT, "width": 2}, steps=True),
    ]
    logarithmic = len(best) > 0 and bool(np.all(best > 0))
    across, up = axis("evaluations of the cost"), axis("cost E [-]", log=logarithmic)
    return figure(traces, 320, across, up, columns=columns, hover="x")


def _circle(radius: float, name: str, stroke: dict[str, Any]) -> Trace:
    turn = np.linspace(0, 2 * np.pi, 121)
    return line(short(radius * np.cos(turn)), short(radius * np.sin(turn)), name, stroke)


def multipliers(stability: LoopStability) -> Figure:
    """Draw the Floquet multipliers and the unit circle.

    Raises
    ------
    ValueError
        If no orbit was found, or its multipliers lie beyond every double.
    """
    values, places, decades = drawn_multipliers(stability)
    sizes = np.abs(values)
    outer = sizes >= sizes[0] * (1 - 1e-9)
    traces = [_circle(1, "unit circle", _RING)]
    if decades:
        ring = readable(10.0**decades)
        traces.append(_circle(OUTER_RING, f"modulus {ring}, logarithmic beyond 1", _OUTER))
    for chosen, name, fill in ((~outer, "others", "paper"), (outer, "largest", "accent")):
        found = places[chosen]
        traces.append(
            markers(
                *(short(found.real), short(found.imag), name, "accent"),
                fill=fill,
                columns={"modulus": short(sizes[chosen], 5)},
                hover=[["modulus", "modulus", ""]],
            )
        )
    reach = 1.1 * (OUTER_RING if decades else max(1.0, float(np.max(np.abs(places)))))
    ticks = {"ticks": [-1, 0, 1]} if decades else {}
    across, up = (
        axis(f"{part} part [-]", range=[-reach, reach], **ticks) for part in ("real", "imaginary")
    )
    return figure(traces, 430, across, up, equal=True)


def _boundary(found: Basin) -> tuple[list[float], list[float]]:
    """Return the sides between cells that converge and cells that do not."""
    inside, x, y = found.converged, found.x, found.y
    half_x, half_y = 0.5 * (x[1] - x[0]), 0.5 * (y[1] - y[0])
    across: list[float] = []
    up: list[float] = []
    for row, column in np.argwhere(inside[:, 1:] != inside[:, :-1]):
        side = x[column] + half_x
        across += [side, side, np.nan]
        up += [y[row] - half_y, y[row] + half_y, np.nan]
    for row, column in np.argwhere(inside[1:] != inside[:-1]):
        side = y[row] + half_y
        across += [x[column] - half_x, x[column] + half_x, np.nan]
        up += [side, side, np.nan]
    return across, up


def basin(found: Basin) -> Figure:
    """Draw how far from the path a run ends, by where it starts; a cross where it diverges."""
    limit = max(found.scenario.divergence_distance, 2 * _SMALLEST)
    error = found.position_error
    rows, places = np.nonzero(~np.isfinite(error))
    edge_x, edge_y = _boundary(found)
    short_edge = short(edge_x), short(edge_y)
    path = found.scenario.trajectory
    step = max(1, len(path) // 1000)
    heat = {
        "kind": "map",
        "panel": 0,
        "name": "position error at the end [m]",
        "x": short(found.x),
        "y": short(found.y),
        "z": [short(row, 4) for row in error],
        "low": _SMALLEST,
        "high": limit,
        "palette": _map_colours(),
        "hover": [["x", "x", "m"], ["y", "y", "m"], ["error", "z", "m"]],
    }
    crosses = short(found.x[places]), short(found.y[rows])
    traces = [
        heat,
        markers(*crosses, "diverges", "ring", symbol="x", size=4, legend=rows.size > 0),
        line(*short_edge, f"{found.tolerance:g} m from the path", MAP_EDGE, legend=len(edge_x) > 0),
        line(short(path.x[::step]), short(path.y[::step]), "path", ON_MAP),
    ]
    across = axis("initial x [m]", range=_reach(found.x))
    return figure(traces, 430, across, axis("initial y [m]", range=_reach(found.y)), equal=True)


def _map_colours() -> list[str]:
    """Return the map's colours, from the smallest value to the largest."""
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    return [
        to_hex(colour)
        for colour in colormaps["viridis_r"].resampled(_MAP_COLOURS)(range(_MAP_COLOURS))
    ]


def _reach(centres: Array) -> list[float]:
    half = 0.5 * float(centres[1] - centres[0])
    return [float(centres[0]) - half, float(centres[-1]) + half]
