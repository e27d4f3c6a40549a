"""Drawings of the robot, the closed loop and the controller (the paper's Figs. 1, 2 and 4)."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Arc, Circle, FancyArrowPatch, FancyBboxPatch, Patch, Rectangle
from matplotlib.transforms import Affine2D

from nfopidn.plot import style
from nfopidn.plot.style import Stroke

Point = tuple[float, float]

_INK: Final = "#222222"
_FACE: Final = "#eef2f7"
_ACCENT: Final[str] = style.LEFT["color"]
_OPTION: Final = (0, (3.5, 2))
_SIZE: Final = 9


def _canvas(ax: Axes | None, width: float, height: float, scale: float) -> Axes:
    """Return white Axes without ticks, `width` by `height` units of `scale` [inch]."""
    ax = style.new_axes(ax, (width * scale, height * scale))
    ax.set(xlim=(0, width), ylim=(0, height), xticks=[], yticks=[], facecolor="white")
    ax.set_aspect("equal")
    for spine in ax.spines.values():
        spine.set_visible(False)
    return ax


def _text(ax: Axes, at: Point, text: str, **options: Any) -> None:
    settings = {"ha": "center", "va": "center", "fontsize": _SIZE, "color": _INK, "zorder": 5}
    ax.text(*at, text, **{**settings, **options})


def _line(ax: Axes, points: Sequence[Point], stroke: Stroke) -> None:
    x, y = zip(*points, strict=True)
    ax.plot(x, y, **stroke)


def _arrow(ax: Axes, points: Sequence[Point], **options: Any) -> None:
    """Draw a line through `points` that ends in an arrow's head."""
    settings = {"color": _INK, "linewidth": 1.0, "linestyle": "-", "zorder": 2, **options}
    _line(ax, points, {**settings, "solid_capstyle": "butt"})
    # The head is drawn apart: its outline must not be dashed.
    head = {**settings, "linestyle": "-", "linewidth": 0}
    ax.add_patch(
        FancyArrowPatch(
            points[-2],
            points[-1],
            arrowstyle="-|>,head_length=5,head_width=2.2",
            mutation_scale=1,
            shrinkA=0,
            shrinkB=0,
            **head,
        )
    )


def _box(ax: Axes, centre: Point, size: Point, text: str = "", **options: Any) -> None:
    settings = {"facecolor": _FACE, "edgecolor": _INK, "linewidth": 1.0, "zorder": 3, **options}
    corner = centre[0] - size[0] / 2, centre[1] - size[1] / 2
    shape = "round,pad=0,rounding_size=0.12"
    ax.add_patch(FancyBboxPatch(corner, *size, boxstyle=shape, **settings))
    _text(ax, centre, text, linespacing=1.5)


def _sum(ax: Axes, centre: Point, signs: Sequence[tuple[Point, str]]) -> None:
    """Draw a summing point with `signs` at offsets from its centre."""
    ax.add_patch(Circle(centre, 0.28, facecolor="white", edgecolor=_INK, zorder=3))
    _text(ax, centre, "Σ")
    for (dx, dy), sign in signs:
        _text(ax, (centre[0] + dx, centre[1] + dy), sign)


def _branch(ax: Axes, at: Point) -> None:
    ax.add_patch(Circle(at, 0.07, facecolor=_INK, edgecolor="none", zorder=3))


# The robot's drawing, in units of its canvas.
_CENTRE: Final[Point] = (4.3, 4.2)
_HEADING: Final = 25.0  # [degrees]
_HALF_TRACK: Final = 1.45
_WHEEL_RADIUS: Final = 0.62
_ORIGIN: Final[Point] = (1.0, 1.35)
_GUIDE: Final[Stroke] = {"color": "0.55", "linewidth": 0.8, "linestyle": _OPTION, "zorder": 1}


def robot_schematic(ax: Axes | None = None) -> Axes:
    """Draw the robot from above: its pose, speeds, wheels and torques (the paper's Fig. 1).

    Parameters
    ----------
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        the drawing, without ticks
    """
    ax = _canvas(ax, 9.0, 7.6, 0.62)
    _draw_pose(ax)
    _draw_body(ax)
    _draw_motion(ax)
    _draw_dimensions(ax)
    equations = (
        r"$\dot v = (\tau_L + \tau_R)\,/\,(m\,r)$",
        r"$\dot\omega = L\,(\tau_L - \tau_R)\,/\,(2\,I\,r)$",
    )
    _text(ax, (4.5, 0.65), (10 * " ").join(equations))
    note = "The paper's sign: a positive left torque turns the robot counter-clockwise."
    _text(ax, (4.5, 0.2), note, fontsize=8, color="0.35")
    return ax


def _at(ahead: float, aside: float) -> Point:
    """Return a point of the robot's frame, `aside` to its left."""
    theta = np.deg2rad(_HEADING)
    cosine, sine = float(np.cos(theta)), float(np.sin(theta))
    return _CENTRE[0] + ahead * cosine - aside * sine, _CENTRE[1] + ahead * sine + aside * cosine


def _draw_pose(ax: Axes) -> None:
    (x, y), (x0, y0) = _CENTRE, _ORIGIN
    _arrow(ax, [_ORIGIN, (8.6, y0)])
    _arrow(ax, [_ORIGIN, (x0, 7.4)])
    _text(ax, (8.6, y0 - 0.3), "X")
    _text(ax, (x0 - 0.3, 7.3), "Y")
    _text(ax, (x0 - 0.25, y0 - 0.25), "O")
    _line(ax, [(x, y0), _CENTRE], _GUIDE)
    _line(ax, [(x0, y), (7.4, y)], _GUIDE)
    _text(ax, (x, y0 - 0.3), "$x$")
    _text(ax, (x0 - 0.3, y), "$y$")
    _arc(ax, _CENTRE, 2.2, (0, _HEADING))
    _text(ax, (x + 2.45, y + 0.5), r"$\theta$", fontsize=11)


def _draw_body(ax: Axes) -> None:
    parts: list[Patch] = [
        Circle((0, 0), 1.2, facecolor=_FACE, edgecolor=_INK, linewidth=1.2),
        Circle((-0.85, 0), 0.14, facecolor="white", edgecolor=_INK, linewidth=0.9),
    ]
    for side, name in ((1, "left"), (-1, "right")):
        corner = (-_WHEEL_RADIUS, side * _HALF_TRACK - 0.16)
        parts.append(Rectangle(corner, 2 * _WHEEL_RADIUS, 0.32, facecolor=_INK))
        _text(ax, _at(0.0, side * (_HALF_TRACK + 0.5)), name)
    place = Affine2D().rotate_deg(_HEADING).translate(*_CENTRE) + ax.transData
    for part in parts:
        part.set(transform=place, zorder=3)
        ax.add_patch(part)
    axle = [_at(0, -_HALF_TRACK), _at(0, _HALF_TRACK)]
    _line(ax, axle, {"color": _INK, "linewidth": 0.8, "zorder": 3})
    ax.add_patch(Circle(_CENTRE, 0.08, facecolor=_INK, zorder=5))


def _draw_motion(ax: Axes) -> None:
    strong: Stroke = {"linewidth": 1.8, "zorder": 4}
    _arrow(ax, [_CENTRE, _at(3.1, 0)], color=_ACCENT, **strong)
    _text(ax, _at(3.35, 0.0), "$v$", color=_ACCENT, fontsize=11)
    _arc(ax, _CENTRE, 0.55, (75, 245), color=_ACCENT, **strong)
    omega_at = (_CENTRE[0] - 0.42, _CENTRE[1] - 0.72)
    _text(ax, omega_at, r"$\omega$", color=_ACCENT, fontsize=11)
    for side, name in ((_HALF_TRACK, "L"), (-_HALF_TRACK, "R")):
        _arrow(ax, [_at(_WHEEL_RADIUS, side), _at(_WHEEL_RADIUS + 1.0, side)], **strong)
        _text(ax, _at(_WHEEL_RADIUS + 1.3, side), rf"$\tau_{name}$", fontsize=11)


def _draw_dimensions(ax: Axes) -> None:
    behind, outside = -2.2, -_HALF_TRACK - 0.95
    for side in (-_HALF_TRACK, _HALF_TRACK):
        _line(ax, [_at(-_WHEEL_RADIUS - 0.1, side), _at(behind - 0.15, side)], _GUIDE)
    _dimension(ax, _at(behind, _HALF_TRACK), _at(behind, -_HALF_TRACK))
    _text(ax, _at(behind - 0.3, 0.0), "$L$", fontsize=11)
    for end in (-_WHEEL_RADIUS, _WHEEL_RADIUS):
        _line(ax, [_at(end, -_HALF_TRACK - 0.22), _at(end, outside - 0.15)], _GUIDE)
    _dimension(ax, _at(-_WHEEL_RADIUS, outside), _at(_WHEEL_RADIUS, outside))
    _text(ax, _at(0.0, outside - 0.3), "$2r$", fontsize=11)


def _arc(
    ax: Axes, centre: Point, radius: float, degrees: tuple[float, float], **options: Any
) -> None:
    """Draw an arc [degrees] that ends in an arrow's head."""
    settings: dict[str, Any] = {"color": _INK, "linewidth": 1.0, "zorder": 4, **options}
    ax.add_patch(
        Arc(centre, 2 * radius, 2 * radius, theta1=degrees[0], theta2=degrees[1], **settings)
    )
    # The head is a chord of the arc's end.
    end = np.deg2rad([degrees[1] - np.rad2deg(0.16 / radius), degrees[1]])
    x, y = centre[0] + radius * np.cos(end), centre[1] + radius * np.sin(end)
    _arrow(ax, [(x[0], y[0]), (x[1], y[1])], **{**settings, "linewidth": 0.0})


def _dimension(ax: Axes, start: Point, end: Point) -> None:
    ax.add_patch(
        FancyArrowPatch(
            start,
            end,
            arrowstyle="<|-|>,head_length=4,head_width=1.6",
            mutation_scale=1,
            shrinkA=0,
            shrinkB=0,
            color=_INK,
            linewidth=0.8,
            zorder=2,
        )
    )


def control_system_schematic(ax: Axes | None = None) -> Axes:
    """Draw the closed loop of trajectory, feedforward, controller and robot (the paper's Fig. 2).

    Parameters
    ----------
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        the drawing, without ticks
    """
    ax = _canvas(ax, 18.0, 6.4, 0.56)
    row, top, bottom = 3.0, 5.4, 0.8
    _box(ax, (1.9, row), (2.8, 1.6), "reference\ntrajectory")
    _box(ax, (8.0, row), (2.8, 1.6), "NFOPIDN\ncontroller")
    _box(ax, (8.0, top), (2.8, 1.2), "feedforward\n(eqs. 5 to 10)")
    _box(ax, (12.6, row), (1.5, 1.6))
    _box(ax, (15.6, row), (1.9, 1.6), "robot\n(eqs. 1 to 4)")
    _saturation(ax, (12.6, row))
    _text(ax, (12.6, row - 1.1), "torque limit")
    _sum(ax, (5.2, row), (((-0.48, -0.3), "+"), ((0.3, -0.5), "$-$")))
    _sum(ax, (10.7, row), (((-0.48, -0.3), "+"), ((0.3, 0.5), "+")))

    _arrow(ax, [(3.3, row), (4.92, row)])
    _text(ax, (4.0, row + 0.35), r"$x_r, y_r, \theta_r$")
    _arrow(ax, [(1.9, row + 0.8), (1.9, top), (6.6, top)])
    _text(ax, (4.25, top + 0.35), r"$V_r,\ W_r$ and their derivatives")
    _arrow(ax, [(5.48, row), (6.6, row)])
    _text(ax, (6.02, row + 0.35), "$e$")
    _arrow(ax, [(9.4, row), (10.42, row)])
    _text(ax, (9.85, row + 0.35), r"$\tau_\mathrm{fb}$")
    _arrow(ax, [(9.4, top), (10.7, top), (10.7, row + 0.28)])
    _text(ax, (10.15, top + 0.35), r"$\tau_\mathrm{ref}$")
    _arrow(ax, [(10.98, row), (11.85, row)])
    _arrow(ax, [(13.35, row), (14.65, row)])
    _text(ax, (14.0, row + 0.35), r"$\tau_L, \tau_R$")
    _arrow(ax, [(15.6, top - 0.2), (15.6, row + 0.8)])
    _text(ax, (15.6, top + 0.15), r"disturbance $F_d, N_d$")
    _arrow(ax, [(16.55, row), (17.9, row)])
    _text(ax, (17.25, row + 0.35), r"$x, y, \theta$")
    _branch(ax, (17.2, row))
    _arrow(ax, [(17.2, row), (17.2, bottom), (5.2, bottom), (5.2, row - 0.28)])
    _text(ax, (11.2, bottom - 0.35), "measured pose")
    return ax


def _saturation(ax: Axes, centre: Point) -> None:
    """Draw the graph of a limit in a box."""
    x, y = centre
    ax.plot([x - 0.55, x + 0.55], [y, y], color="0.7", linewidth=0.7, zorder=4)
    ax.plot([x, x], [y - 0.55, y + 0.55], color="0.7", linewidth=0.7, zorder=4)
    across, up = np.array([-0.55, -0.28, 0.28, 0.55]), np.array([-0.4, -0.4, 0.4, 0.4])
    ax.plot(x + across, y + up, color=_ACCENT, linewidth=1.6, zorder=5)


def _neuron(ax: Axes, centre: Point) -> None:
    """Draw a neuron with the graph of its sigmoid."""
    ax.add_patch(Circle(centre, 0.62, facecolor="white", edgecolor=_INK, zorder=3))
    across = np.linspace(-0.42, 0.42, 41)
    ax.plot(
        centre[0] + across,
        centre[1] + 0.36 * np.tanh(7 * across),
        color=_ACCENT,
        linewidth=1.6,
        zorder=5,
    )


def controller_schematic(ax: Axes | None = None) -> Axes:
    """Draw the controller from errors to wheel torques (the paper's Fig. 4).

    What only the incremental form has is dashed.

    Parameters
    ----------
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        the drawing, without ticks
    """
    ax = _canvas(ax, 21.0, 9.0, 0.5)
    rows = {"x": 7.2, "y": 4.7, r"\theta": 2.2}
    _box(ax, (3.4, 5.95), (1.9, 4.0), "rotation\ninto the\nrobot's\nframe")
    _box(ax, (3.4, rows[r"\theta"]), (1.9, 1.5), "wrap\n" + r"$[-\pi, \pi)$")
    _arrow(ax, [(3.4, 8.75), (3.4, 7.95)])
    _text(ax, (3.75, 8.45), r"$\theta$")
    for name, y in rows.items():
        _arrow(ax, [(0.3, y), (2.45, y)])
        _text(ax, (1.3, y + 0.38), rf"${name}_r - {name}$")
        _arrow(ax, [(4.35, y), (5.9, y)])
        _text(ax, (5.1, y + 0.38), f"$e_{{{name}}}$")
        gains = r"$K_p + K_i\,s^{-\sigma} + K_d\,s^{\alpha}$"
        _box(ax, (7.9, y), (4.0, 1.5), gains + "\nFIR filter, $M + 2$ taps")
        _arrow(ax, [(9.9, y), (11.48, y)])
        _text(ax, (10.65, y + 0.38), rf"$\mathrm{{net}}_{{{name}}}$")
        _neuron(ax, (12.1, y))
        _arrow(ax, [(12.72, y), (14.0, y)])
        _text(ax, (13.35, y + 0.38), rf"$O_{{{name}}}$")
    _text(ax, (7.9, 8.55), "fractional PID", fontweight="bold")
    _text(ax, (12.1, 8.55), "neurons", fontweight="bold")
    _box(ax, (14.95, 4.7), (1.9, 6.6), "control\nallocation\n$2 \\times 3$")

    for y, wheel in ((6.3, "L"), (3.1, "R")):
        _arrow(ax, [(15.9, y), (17.12, y)])
        _sum(ax, (17.4, y), ())
        _arrow(ax, [(17.68, y), (20.6, y)])
        _text(ax, (19.95, y + 0.38), rf"$\tau_{{\mathrm{{fb}},{wheel}}}$")
        _branch(ax, (19.2, y))
        _arrow(
            ax,
            [(19.2, y), (19.2, y - 1.4), (17.4, y - 1.4), (17.4, y - 0.28)],
            linestyle=_OPTION,
        )
        _box(ax, (18.3, y - 1.4), (1.0, 0.8), "$z^{-1}$", linestyle=_OPTION)
    _text(ax, (18.3, 0.75), "dashed: incremental form only", fontsize=8, color="0.35")
    return ax
