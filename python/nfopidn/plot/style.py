"""What the figures share: colours and strokes, axes, legends, the robot's outline."""

from collections.abc import Sequence
from typing import Any, Final

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, Rectangle
from matplotlib.transforms import Affine2D
from numpy.typing import NDArray

Panels = NDArray[np.object_]
Stroke = dict[str, Any]

# Colours of one figure differ in luminance, and strokes in their dashes, so that both survive a
# print in grey.
REFERENCE: Final[Stroke] = {"color": "#a3a3a3", "linewidth": 2.4, "zorder": 2.0}
ROBOT: Final[Stroke] = {"color": "#16365c", "linewidth": 1.2, "zorder": 3.0}
LEFT: Final[Stroke] = {"color": "#1c5a99", "linewidth": 1.3, "zorder": 3.0}
RIGHT: Final[Stroke] = {
    "color": "#e98a2b",
    "linewidth": 1.3,
    "linestyle": (0, (4, 1.6)),
    "zorder": 3.1,
}
ERROR_X: Final[Stroke] = {"color": "#4b2a83", "linewidth": 1.2, "zorder": 3.0}
ERROR_Y: Final[Stroke] = {
    "color": "#3fae82",
    "linewidth": 1.4,
    "linestyle": (0, (4, 1.6)),
    "zorder": 3.1,
}
ERROR_THETA: Final[Stroke] = {"color": "#a3305f", "linewidth": 1.2, "zorder": 3.0}
MEAN: Final[Stroke] = {
    "color": "#e98a2b",
    "linewidth": 1.2,
    "linestyle": (0, (4, 1.6)),
    "zorder": 2.5,
}
LIMIT: Final[Stroke] = {"color": "#6b6b6b", "linewidth": 0.9, "linestyle": (0, (1.5, 1.5))}
DIVERGENCE: Final[Stroke] = {"color": "#b3261e", "linewidth": 0.9, "linestyle": (0, (5, 2, 1, 2))}

LABEL_SIZE: Final = 9
TICK_SIZE: Final = 8


def new_axes(ax: Axes | None, size: tuple[float, float] = (6.4, 3.4)) -> Axes:
    """Return `ax`, or the Axes of a new figure of `size` [inch]."""
    if ax is not None:
        return ax
    return plt.figure(figsize=size, layout="constrained").add_subplot()


def new_panels(axes: Sequence[Axes] | Panels | None, count: int) -> Panels:
    """Return `axes` as an array of `count` Axes, or a new figure's, one above the other."""
    if axes is None:
        figure = plt.figure(figsize=(6.4, 0.5 + 1.75 * count), layout="constrained")
        axes = figure.subplots(count, sharex=True)
    panels = np.asarray(axes, dtype=np.object_).ravel()
    if panels.size != count:
        raise ValueError(f"axes has {panels.size} Axes; must have {count}")
    return panels


def finish(ax: Axes, xlabel: str, ylabel: str) -> None:
    """Label the axes and draw a thin grid behind the data."""
    ax.set_xlabel(xlabel, fontsize=LABEL_SIZE)
    ax.set_ylabel(ylabel, fontsize=LABEL_SIZE)
    ax.tick_params(labelsize=TICK_SIZE, width=0.6, length=3)
    ax.grid(True, color="0.9", linewidth=0.5)
    ax.set_axisbelow(True)
    for side, spine in ax.spines.items():
        spine.set_linewidth(0.6)
        spine.set_visible(side in {"left", "bottom"})


def legend_above(ax: Axes, **options: Any) -> None:
    """Put the legend above the axes, where no data are."""
    settings: dict[str, Any] = {
        "loc": "lower left",
        "bbox_to_anchor": (0.0, 1.0),
        "ncols": 4,
        "frameon": False,
        "fontsize": TICK_SIZE,
        "handlelength": 2.2,
        "columnspacing": 1.2,
        "borderpad": 0.0,
        "borderaxespad": 0.4,
    }
    ax.legend(**{**settings, **options})


def draw_robot(ax: Axes, pose: Sequence[float], width: float) -> None:
    """Draw a robot from above: body, wheels and a line to its front.

    Parameters
    ----------
    ax
        where
    pose
        x, y [m], theta [rad]
    width
        distance of its wheels [m]
    """
    x, y, theta = (float(number) for number in pose)
    radius = 0.5 * width
    place = Affine2D().rotate(theta).translate(x, y) + ax.transData
    body = Circle((0, 0), radius, facecolor="white", edgecolor=ROBOT["color"], linewidth=1.0)
    wheels = [
        Rectangle((-0.5 * radius, side * radius - 0.15 * radius), radius, 0.3 * radius)
        for side in (-1, 1)
    ]
    for patch in (body, *wheels):
        patch.set(transform=place, zorder=4)
        ax.add_patch(patch)
    for wheel in wheels:
        wheel.set(facecolor=ROBOT["color"], edgecolor="none")
    front = [x + radius * np.cos(theta), y + radius * np.sin(theta)]
    ax.plot([x, front[0]], [y, front[1]], color=ROBOT["color"], linewidth=1.2, zorder=5)
