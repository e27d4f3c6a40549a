"""What the page's figures share: how a figure is described, strokes, and colours of both themes.

A figure is a dictionary that the page's script draws:

- ``height`` [px], ``x`` the x axis, ``panels`` the y axes, one above the other;
- ``traces``: lines, markers, areas, bars and maps, each with its ``panel``;
- ``hover``: whether the values at one x, or those of the nearest point, are shown;
- ``equal``: whether both axes have one scale; ``marks_time``: whether the slider's time is marked.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nfopidn.plot import style

Figure = dict[str, Any]
Trace = dict[str, Any]
Axis = dict[str, Any]

#: Colour by name, on white and on the dark theme's background.
COLOURS: Mapping[str, tuple[str, str]] = {
    "reference": (style.REFERENCE["color"], "#7d838c"),
    "robot": (style.ROBOT["color"], "#a9cdf7"),
    "other": (style.RIGHT["color"], "#f0a04b"),
    "limit": (style.LIMIT["color"], "#a8adb5"),
    "error-x": (style.ERROR_X["color"], "#bda3f2"),
    "error-y": (style.ERROR_Y["color"], "#4fc797"),
    "error-theta": (style.ERROR_THETA["color"], "#f08fb4"),
    "accent": (style.LEFT["color"], "#7fb6f0"),
    "outline": ("#8f9fb3", "#5f7086"),
    "body": ("#f6d3a8", "#6b4f2c"),
    "bad": (style.DIVERGENCE["color"], "#ff8a80"),
    "mark": ("#6b6b6b", "#c3c7cd"),
    "ring": ("#8a8a8a", "#8a8a8a"),
    "on-map": (style.ROBOT["color"], style.ROBOT["color"]),  # a map is as bright in both themes
    "map-edge": (style.DIVERGENCE["color"], style.DIVERGENCE["color"]),
    "paper": ("#ffffff", "#16181c"),
}

# Strokes differ in luminance and dashes, so that they survive a print in grey.
_DASHES = [5, 2]
REFERENCE = {"colour": "reference", "width": 3}
ROBOT = {"colour": "robot", "width": 1.6}
OTHER = {"colour": "other", "width": 1.6, "dash": _DASHES}
LIMIT = {"colour": "limit", "width": 1.2, "dash": [1.5, 2]}
ERROR_X = {"colour": "error-x", "width": 1.6}
ERROR_Y = {"colour": "error-y", "width": 1.8, "dash": _DASHES}
ERROR_THETA = {"colour": "error-theta", "width": 1.6}
ON_MAP = {"colour": "on-map", "width": 1.6}
LOST = {"colour": "bad", "width": 1.4, "dash": [5, 2, 1, 2]}
MAP_EDGE = {"colour": "map-edge", "width": 2}


def style_sheet() -> str:
    """Return the colours as variables of a style sheet, for both themes."""
    light, dark = (
        " ".join(f"--line-{name}: {pair[theme]};" for name, pair in COLOURS.items())
        for theme in (0, 1)
    )
    return f":root {{ {light} }}\n@media (prefers-color-scheme: dark) {{ :root {{ {dark} }} }}\n"


def line(x: Any, y: Any, name: str, stroke: dict[str, Any], **more: Any) -> Trace:
    """Return a line; x and y are numbers, or "@column" of the scenario's run."""
    return {"kind": "line", "panel": 0, "x": x, "y": y, "name": name, **stroke, **more}


def markers(x: Any, y: Any, name: str, colour: str, **more: Any) -> Trace:
    """Return markers; ``fill`` is the colour within, `colour` that of their edge."""
    return {"kind": "markers", "panel": 0, "x": x, "y": y, "name": name, "colour": colour, **more}


def area(x: Any, y: Any, name: str, fill: str, **more: Any) -> Trace:
    """Return polygons, filled and outlined; gaps (None) part them."""
    return {"kind": "area", "panel": 0, "x": x, "y": y, "name": name, "fill": fill, **ROBOT, **more}


def words(x: Any, y: Any, text: list[str], colour: str) -> Trace:
    """Return texts that end a little left of their points."""
    place = {"x": x, "y": y, "columns": {"text": text}}
    return {"kind": "words", "panel": 0, "name": "", "legend": False, "colour": colour, **place}


def axis(title: str, **more: Any) -> Axis:
    """Return an axis with a title that has the unit.

    ``range``, ``log``, ``ticks`` with ``labels``, and ``integers`` are optional.
    """
    return {"title": title, **more}


def figure(traces: list[Trace], height: int, x: Axis, *panels: Axis, **more: Any) -> Figure:
    """Return a figure of a height [px]; it takes the width that the page gives it."""
    return {"height": height, "x": x, "panels": list(panels), "traces": traces, **more}


def stacked(traces: list[Trace], titles: tuple[str, str], end: float) -> Figure:
    """Return two panels, one above the other, against a shared time up to `end` [s].

    The page marks the slider's time in them.
    """
    time = axis("time [s]", range=[0, end])
    return figure(traces, 430, time, *map(axis, titles), hover="x", marks_time=True)
