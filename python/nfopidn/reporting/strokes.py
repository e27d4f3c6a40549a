"""What the page's figures share with those of nfopidn.plot, in Plotly's words: strokes and axes."""

from __future__ import annotations

from typing import Any

from nfopidn.plot import style

Figure = dict[str, Any]
Trace = dict[str, Any]

_TEXT = "#222222"
_GRID = "#e6e6e6"
_FONT = "Helvetica Neue, Helvetica, Arial, Liberation Sans, sans-serif"

# Strokes differ in luminance and dashes, so that they survive a print in grey.
REFERENCE = {"color": style.REFERENCE["color"], "width": 3}
ROBOT = {"color": style.ROBOT["color"], "width": 1.6}
OTHER = {"color": style.RIGHT["color"], "width": 1.6, "dash": "5px,2px"}
LIMIT = {"color": style.LIMIT["color"], "width": 1.2, "dash": "1.5px,2px"}
ERROR_X = {"color": style.ERROR_X["color"], "width": 1.6}
ERROR_Y = {"color": style.ERROR_Y["color"], "width": 1.8, "dash": "5px,2px"}
ERROR_THETA = {"color": style.ERROR_THETA["color"], "width": 1.6}
ACCENT = style.LEFT["color"]
EDGE = style.DIVERGENCE["color"]


def line(x: Any, y: Any, name: str, stroke: dict[str, Any], **more: Any) -> Trace:
    """Return a line; x and y are numbers, or "@column" of the scenario's run."""
    return {
        "type": "scatter",
        "mode": "lines",
        "x": x,
        "y": y,
        "name": name,
        "line": dict(stroke),
        **more,
    }


def axis(title: str, **more: Any) -> dict[str, Any]:
    """Return an axis with a title that has the unit."""
    return {
        "title": {"text": title, "standoff": 8},
        "gridcolor": _GRID,
        "zeroline": False,
        "linecolor": "#8a8a8a",
        "linewidth": 1,
        "ticks": "outside",
        "ticklen": 4,
        "tickcolor": "#8a8a8a",
        "automargin": True,
        **more,
    }


def figure(traces: list[Trace], height: int, **layout: Any) -> Figure:
    """Return a figure of a height [px]; it takes the width that the page gives it."""
    return {
        "height": height,
        "data": traces,
        "layout": {
            "font": {"family": _FONT, "size": 12, "color": _TEXT},
            "paper_bgcolor": "#ffffff",
            "plot_bgcolor": "#ffffff",
            "margin": {"l": 56, "r": 12, "t": 34, "b": 44},
            "legend": {
                "orientation": "h",
                "x": 0,
                "xanchor": "left",
                "y": 1,
                "yanchor": "bottom",
                "bgcolor": "rgba(0,0,0,0)",
            },
            "hoverlabel": {"font": {"family": _FONT, "size": 12}},
            **layout,
        },
    }


def stacked(traces: list[Trace], titles: tuple[str, str], end: float) -> Figure:
    """Return two panels, one above the other, against a shared time up to `end` [s].

    The page marks the slider's time in them.
    """
    found = figure(
        traces,
        400,
        xaxis=axis("time [s]", anchor="y2", range=[0, end], hoverformat=".6g"),
        yaxis=axis(titles[0], domain=[0.54, 1], hoverformat=".4g"),
        yaxis2=axis(titles[1], domain=[0, 0.46], hoverformat=".4g"),
        hovermode="x",
        shapes=[],
    )
    return {**found, "marks_time": True}
