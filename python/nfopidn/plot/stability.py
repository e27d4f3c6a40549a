"""Figures of stability: operators in the z-plane, Floquet multipliers, basins of attraction."""

from typing import TYPE_CHECKING, Final, Literal

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from matplotlib.patches import Circle
from numpy.typing import NDArray

from nfopidn.plot import style
from nfopidn.plot.filters import draw_z_plane
from nfopidn.stability import Basin, LoopStability, operator

if TYPE_CHECKING:
    from matplotlib.image import AxesImage

_MULTIPLIER: Final[style.Stroke] = {
    "color": style.LEFT["color"],
    "linestyle": "none",
    "marker": "o",
    "markersize": 6,
    "markerfacecolor": "white",
    "markeredgewidth": 1.4,
    "zorder": 3,
}
_LARGEST: Final[style.Stroke] = {**_MULTIPLIER, "markerfacecolor": style.LEFT["color"]}
_DIVERGED: Final = "#6b6b6b"
_PATH: Final[style.Stroke] = {"color": "#16365c", "linewidth": 1.4, "zorder": 3}
_EDGE: Final[style.Stroke] = {"colors": "#b3261e", "linewidths": 1.3, "zorder": 3.5}
#: Best of the picture's scale of errors [m]; nobody sees the difference below.
_SMALLEST: Final = 0.01
#: Radius of the ring that stands for the largest multiplier's power of ten.
OUTER_RING: Final = 1.5
_RESOLVED: Final = 1e-12


def operator_z_plane(
    order: float,
    memory: int = 5,
    generator: Literal["tustin", "gl"] = "tustin",
    ax: Axes | None = None,
) -> Axes:
    """Draw zeros and poles of a truncated fractional operator: the paper's Fig. 3, for any order.

    Parameters
    ----------
    order, memory, generator
        as `nfopidn.stability.operator` takes them
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        imaginary against real part of z [-], equally scaled

    Raises
    ------
    ValueError
        If an argument is out of range.
    """
    plane = operator(order, memory, generator)
    ax = style.new_axes(ax, (4.8, 4.8))
    draw_z_plane(ax, plane, rf"$s^{{{order:.4g}}}$, $M$ = {memory}")
    return ax


def _drawn(values: NDArray[np.complex128], decades: float) -> NDArray[np.complex128]:
    """Return where multipliers are drawn: those outside the circle on a logarithmic radius."""
    size = np.abs(values)
    if decades == 0:
        return values
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = np.where(size > 1, 1 + (OUTER_RING - 1) * np.log10(size) / decades, size)
        return np.where(size > 0, values / size * radius, 0)


def drawn_multipliers(
    stability: LoopStability,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128], float]:
    """Return the multipliers that are drawn, largest first, where, and the outer ring's decades.

    Raises
    ------
    ValueError
        If no orbit was found, or its multipliers lie beyond every double.
    """
    if stability.verdict == "no_orbit":
        raise ValueError("stability has no orbit; there are no multipliers to draw")
    values = stability.multipliers
    if not np.all(np.isfinite(values)):
        raise ValueError(
            f"stability has log_radius {stability.log_radius:g}; must be at most 709 to be drawn"
        )
    largest = float(np.abs(values[0]))
    values = values[np.abs(values) >= _RESOLVED * largest]
    decades = float(np.ceil(np.log10(largest))) if largest > 2 else 0.0
    return values, _drawn(values, decades), decades


def multipliers(stability: LoopStability, ax: Axes | None = None) -> Axes:
    """Draw the Floquet multipliers of a loop's orbit, the largest one filled, in the unit circle.

    When the largest one has a modulus beyond 2, the radius outside the unit circle is logarithmic,
    with its end on an outer ring of the power of ten that the figure names. Those that rounding
    leaves no digit of, less than 1e-12 of the largest, are not drawn.

    Parameters
    ----------
    stability
        from `nfopidn.stability.loop`
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        imaginary against real part of the multipliers [-], equally scaled

    Raises
    ------
    ValueError
        If no orbit was found, or its multipliers lie beyond every double.
    """
    values, drawn, decades = drawn_multipliers(stability)
    ax = style.new_axes(ax, (4.8, 4.8))
    largest = float(np.abs(values[0]))
    ax.add_patch(Circle((0, 0), 1, fill=False, edgecolor="0.45", linewidth=0.9))
    if decades:
        ring = Circle((0, 0), OUTER_RING, fill=False, edgecolor="0.6", linewidth=0.8, linestyle=":")
        ax.add_patch(ring)
        ax.annotate(
            rf"$10^{{{decades:g}}}$",
            xy=(OUTER_RING * np.sqrt(0.5), OUTER_RING * np.sqrt(0.5)),
            xytext=(3, 3),
            textcoords="offset points",
            fontsize=style.TICK_SIZE,
        )
    for line in (ax.axhline, ax.axvline):
        line(0, color="0.75", linewidth=0.7, zorder=1)
    outer = np.abs(values) >= largest * (1 - 1e-9)
    of = "a sample" if stability.period == 1 else "a period"
    ax.plot(drawn.real, drawn.imag, label=f"multipliers of {of}", **_MULTIPLIER)
    label = f"largest, modulus {largest:.4g}"
    ax.plot(drawn[outer].real, drawn[outer].imag, label=label, **_LARGEST)
    ends = "" if not decades else ", beyond 1 on a logarithmic radius"
    style.finish(ax, f"real part [-]{ends}", "imaginary part [-]")
    if decades:
        ax.set_xticks([-1, 0, 1])
        ax.set_yticks([-1, 0, 1])
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    style.legend_above(
        ax, title=stability.verdict, title_fontsize=style.TICK_SIZE, alignment="left", ncols=2
    )
    return ax


def _edges(axis: NDArray[np.float64]) -> tuple[float, float]:
    """Return the outer edges of the cells around evenly spaced centres."""
    half = 0.5 * (axis[-1] - axis[0]) / (len(axis) - 1) if len(axis) > 1 else 0.5
    return float(axis[0] - half), float(axis[-1] + half)


def basin(basin: Basin, ax: Axes | None = None) -> Axes:
    """Draw a basin of attraction: how far from the path a run ends, by where it starts.

    Poses inside the red line converge; grey ones diverge. The grid is taken as evenly spaced.

    Parameters
    ----------
    basin
        from `nfopidn.stability.basin`
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        initial y against initial x [m], equally scaled
    """
    ax = style.new_axes(ax, (5.6, 4.9))
    errors = np.ma.masked_invalid(basin.position_error)
    colours = plt.get_cmap("viridis_r").with_extremes(bad=_DIVERGED)
    limit = max(basin.scenario.divergence_distance, 2 * _SMALLEST)
    image: AxesImage = ax.imshow(
        np.ma.maximum(errors, _SMALLEST),
        origin="lower",
        extent=(*_edges(basin.x), *_edges(basin.y)),
        cmap=colours,
        norm=LogNorm(_SMALLEST, limit),
        interpolation="nearest",
    )
    if min(basin.converged.shape) > 1 and 0 < basin.share < 1:
        ax.contour(basin.x, basin.y, basin.converged.astype(float), levels=[0.5], **_EDGE)
    window = ax.get_xlim(), ax.get_ylim()
    path = basin.scenario.trajectory
    ax.plot(path.x, path.y, label="path", **_PATH)
    ax.plot(path.x[0], path.y[0], "o", color="white", markeredgecolor="#16365c", label="its start")
    ax.set_xlim(window[0])
    ax.set_ylim(window[1])
    style.finish(ax, "initial x [m]", "initial y [m]")
    ax.grid(False)
    ax.set_aspect("equal")
    bar = ax.figure.colorbar(image, ax=ax, shrink=0.85)
    bar.set_label("position error at the end [m], grey: diverged", fontsize=style.LABEL_SIZE)
    bar.ax.axhline(basin.tolerance, color=_EDGE["colors"], linewidth=_EDGE["linewidths"])
    bar.ax.tick_params(labelsize=style.TICK_SIZE)
    title = (
        rf"initial $\theta$ = {basin.theta:.3g} rad: {basin.share:.1%} end within "
        f"{basin.tolerance:g} m"
    )
    style.legend_above(ax, title=title, title_fontsize=style.TICK_SIZE, alignment="left")
    return ax
