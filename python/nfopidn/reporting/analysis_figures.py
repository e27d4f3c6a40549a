"""Figures of the search and of stability: convergence, multipliers, basin of attraction."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from nfopidn.plot.stability import OUTER_RING, drawn_multipliers
from nfopidn.reporting.numbers import readable, short
from nfopidn.reporting.strokes import ACCENT, EDGE, OTHER, ROBOT, Figure, axis, figure, line
from nfopidn.stability import Basin, LoopStability

Array = NDArray[np.float64]

_SMALLEST = 0.01  # end of the basin's scale of errors [m]
_RING = {"color": "#8a8a8a", "width": 1.2}
_OUTER = {"color": "#8a8a8a", "width": 1, "dash": "2px,3px"}


def convergence(history: Any) -> Figure:
    """Draw the best cost so far, and the mean of the cells, against evaluations."""
    nfev, best = short(history["nfev"], 12), history["best"]
    traces = [
        line(nfev, short(history["mean"]), "mean of the cells", OTHER),
        line(nfev, short(best), "best so far", {**ROBOT, "width": 2, "shape": "hv"}),
    ]
    logarithmic = len(best) > 0 and bool(np.all(best > 0))
    scale = {"type": "log", "dtick": "D2", "tickformat": "~g"} if logarithmic else {}
    return figure(
        traces,
        320,
        xaxis=axis("evaluations of the cost", rangemode="tozero", exponentformat="none"),
        yaxis=axis("cost E [-]", hoverformat=".5g", **scale),
        hovermode="x",
    )


def _circle(radius: float, name: str, stroke: dict[str, Any]) -> dict[str, Any]:
    turn = np.linspace(0, 2 * np.pi, 121)
    x, y = short(radius * np.cos(turn)), short(radius * np.sin(turn))
    return line(x, y, name, stroke, hoverinfo="skip")


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
    for chosen, name, colour in ((~outer, "others", "#ffffff"), (outer, "largest", ACCENT)):
        text = [f"{readable(size)}, modulus of the multiplier" for size in sizes[chosen]]
        traces.append(
            {
                **line(short(places.real[chosen]), short(places.imag[chosen]), name, ROBOT),
                "mode": "markers",
                "marker": {"size": 9, "color": colour, "line": {"color": ACCENT, "width": 1.6}},
                "text": text,
                "hovertemplate": "%{text}<extra></extra>",
            }
        )
    ticks = {"tickvals": [-1, 0, 1]} if decades else {"dtick": 0.5}
    reach = 1.1 * (OUTER_RING if decades else max(1.0, float(np.max(np.abs(places)))))
    return figure(
        traces,
        430,
        xaxis=axis("real part [-]", zeroline=True, zerolinecolor="#bdbdbd", **ticks)
        | {"range": [-reach, reach]},
        yaxis=axis("imaginary part [-]", zeroline=True, zerolinecolor="#bdbdbd", **ticks)
        | {"range": [-reach, reach], "scaleanchor": "x", "scaleratio": 1},
        hovermode="closest",
    )


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
    decades = np.arange(-2, int(np.floor(np.log10(limit))) + 1)
    error = found.position_error
    heat = np.log10(
        np.maximum(error, _SMALLEST), where=np.isfinite(error), out=np.full_like(error, np.nan)
    )
    rows, places = np.nonzero(~np.isfinite(error))
    edge_x, edge_y = _boundary(found)
    path = found.scenario.trajectory
    step = max(1, len(path) // 1000)
    traces: list[dict[str, Any]] = [
        {
            "type": "heatmap",
            "x": short(found.x),
            "y": short(found.y),
            "z": [short(row, 4) for row in heat],
            "customdata": [short(row, 4) for row in error],
            "zmin": float(np.log10(_SMALLEST)),
            "zmax": float(np.log10(limit)),
            "colorscale": "Viridis",
            "reversescale": True,
            "colorbar": {
                "title": {"text": "position error at the end [m]", "side": "right"},
                "tickvals": decades.tolist(),
                "ticktext": [f"{10.0**power:g}" for power in decades],
                "thickness": 14,
                "outlinewidth": 0,
            },
            "hovertemplate": "x = %{x:.3g} m<br>y = %{y:.3g} m<br>"
            "error %{customdata:.3g} m<extra></extra>",
        },
        {
            **line(short(found.x[places]), short(found.y[rows]), "diverges", ROBOT),
            "mode": "markers",
            "hoverinfo": "skip",
            "showlegend": rows.size > 0,
            "marker": {"symbol": "x-thin", "size": 4, "line": {"color": "#8a8a8a", "width": 1}},
        },
        line(
            *(short(edge_x), short(edge_y), f"{found.tolerance:g} m from the path"),
            {"color": EDGE, "width": 2},
            hoverinfo="skip",
            showlegend=len(edge_x) > 0,
        ),
        line(short(path.x[::step]), short(path.y[::step]), "path", ROBOT, hoverinfo="skip"),
    ]
    return figure(
        traces,
        430,
        xaxis=axis("initial x [m]", range=_reach(found.x), constrain="domain"),
        yaxis=axis("initial y [m]", range=_reach(found.y), constrain="domain")
        | {"scaleanchor": "x", "scaleratio": 1},
        hovermode="closest",
    )


def _reach(centres: Array) -> list[float]:
    half = 0.5 * float(centres[1] - centres[0])
    return [float(centres[0]) - half, float(centres[-1]) + half]
