"""Figures of a controller's fractional operators and of the filters that they become."""

from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle
from matplotlib.ticker import MaxNLocator

from nfopidn import stability
from nfopidn._core import Controller, series_weights
from nfopidn.arguments import no_rival
from nfopidn.plot import style
from nfopidn.plot.style import Stroke

_CHANNELS = {"x": "x", "y": "y", "theta": r"\theta"}
_CHANNEL_DASHES = ("-", "--", ":")
_DERIVATIVE: Stroke = {
    "color": style.LEFT["color"],
    "linewidth": 0.9,
    "marker": "o",
    "markersize": 5,
}
_INTEGRAL: Stroke = {
    "color": style.RIGHT["color"],
    "linewidth": 0.9,
    "marker": "s",
    "markersize": 6,
    "markerfacecolor": "none",
    "markeredgewidth": 1.3,
}
_ZERO: Stroke = {
    "color": style.LEFT["color"],
    "linestyle": "none",
    "marker": "o",
    "markerfacecolor": "white",
    "markeredgewidth": 1.4,
}
_POLE: Stroke = {
    "color": style.RIGHT["color"],
    "linestyle": "none",
    "marker": "x",
    "markersize": 8,
    "markeredgewidth": 1.8,
}


def weights(controller: Controller, ax: Axes | None = None) -> Axes:
    """Draw the weights of past errors in the fractional derivative and integral.

    They are f_j (generator tustin) or g_j (gl) of the orders alpha and 1 - sigma, for j up to the
    controller's memory. A controller with orders for each channel has a pair of lines for each.

    Parameters
    ----------
    controller
        whose generator, orders and memory are drawn
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        weights [-] against j [samples]

    Raises
    ------
    ValueError
        If the controller has free taps, that is no orders.
    """
    controller = no_rival(controller)
    alpha_or_none, sigma_or_none = controller.alpha, controller.sigma
    if alpha_or_none is None or sigma_or_none is None:
        raise ValueError("controller has free taps; its weights have no orders")
    ax = style.new_axes(ax, (6.4, 3.4))
    memory = int(controller.memory)
    j = np.arange(memory + 1)
    letter = "g" if controller.generator == "gl" else "f"
    alphas = np.broadcast_to(np.asarray(alpha_or_none, dtype=float), 3)
    sigmas = np.broadcast_to(np.asarray(sigma_or_none, dtype=float), 3)
    orders = list(zip(alphas.tolist(), sigmas.tolist(), _CHANNELS.values(), strict=True))
    shared = len({(alpha, sigma) for alpha, sigma, _ in orders}) == 1
    for i, (alpha, sigma, channel) in enumerate(orders[:1] if shared else orders):
        of_channel = "" if shared else rf"_{{{channel}}}"
        for order, symbol, stroke in (
            (alpha, rf"\alpha{of_channel}", _DERIVATIVE),
            (1 - sigma, rf"1-\sigma{of_channel}", _INTEGRAL),
        ):
            ax.plot(
                j,
                series_weights(0.0 if letter == "g" else 1.0, order, memory),
                label=rf"${letter}_j({symbol} = {order:.4g})$",
                linestyle=_CHANNEL_DASHES[i],
                **{**stroke, "markersize": stroke["markersize"] if memory <= 60 else 0},
            )
    style.finish(ax, "j, age of the error [samples]", f"weight ${letter}_j$ [-]")
    ax.axhline(0, color="0.5", linewidth=0.6, zorder=1)
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    style.legend_above(ax, ncols=3)
    return ax


def z_plane(
    controller: Controller, channel: Literal["x", "y", "theta"] = "x", ax: Axes | None = None
) -> Axes:
    """Draw zeros and poles of a channel's fused filter in the z-plane.

    The filter is sum_j taps[j] z^-j with memory + 2 taps: its zeros are the roots of the taps, and
    its poles are all at 0. In incremental form there is a pole at 1 besides. Above stand where they
    lie, inside, on or outside the unit circle, and what that makes the filter.

    Parameters
    ----------
    controller
        whose taps are drawn
    channel
        which error's filter
    ax
        where to draw; None makes a figure

    Returns
    -------
    Axes
        imaginary against real part of z [-], equally scaled
    """
    if channel not in _CHANNELS:
        raise ValueError(f"channel is {channel!r}; must be one of {', '.join(_CHANNELS)}")
    ax = style.new_axes(ax, (4.8, 4.8))
    plane = stability.controller(controller).channels[channel]
    draw_z_plane(ax, plane, f"channel ${_CHANNELS[channel]}$")
    return ax


def draw_z_plane(ax: Axes, plane: stability.ZPlane, title: str) -> None:
    """Draw zeros, poles and the unit circle, with the verdict above."""
    ax.add_patch(Circle((0, 0), 1, fill=False, edgecolor="0.45", linewidth=0.9))
    for line in (ax.axhline, ax.axvline):
        line(0, color="0.75", linewidth=0.7, zorder=1)
    size = 8 if len(plane.poles) <= 30 else 4
    ax.plot(plane.zeros.real, plane.zeros.imag, label="zeros", markersize=size, **_ZERO)
    ax.plot(plane.poles.real, plane.poles.imag, label="poles", **_POLE)
    _count(ax, int(np.count_nonzero(plane.poles == 0)), "pole", 7)
    _count(ax, int(np.count_nonzero(plane.zeros == 0)), "zero", -14)
    style.finish(ax, "real part of z [-]", "imaginary part of z [-]")
    ax.set_aspect("equal", adjustable="datalim")
    ax.margins(0.08)
    verdict = f"{plane.verdict}: poles {plane.poles_place}, zeros {plane.zeros_place}"
    style.legend_above(
        ax, title=f"{title}; {verdict}", title_fontsize=style.TICK_SIZE, alignment="left"
    )


def _count(ax: Axes, count: int, name: str, height: float) -> None:
    """Write the number of roots at 0, if any, `height` [pt] above it."""
    if count > 0:
        ax.annotate(
            f"{count} {name}s" if count > 1 else f"1 {name}",
            xy=(0, 0),
            xytext=(7, height),
            textcoords="offset points",
            fontsize=style.TICK_SIZE,
        )
