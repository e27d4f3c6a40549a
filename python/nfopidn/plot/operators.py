"""Figures of fractional operators."""

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from nfopidn.fractional import METHODS, discretise
from nfopidn.fractional import orders as checks
from nfopidn.plot import style
from nfopidn.plot.style import Panels

_STROKES: tuple[style.Stroke, ...] = (
    {"color": "#1c5a99", "linestyle": "-"},
    {"color": "#e98a2b", "linestyle": (0, (4, 1.6))},
    {"color": "#3fae82", "linestyle": (0, (1.5, 1.2))},
    {"color": "#4b2a83", "linestyle": (0, (6, 1.5, 1.5, 1.5))},
    {"color": "#a3305f", "linestyle": (0, (3, 1, 1, 1, 1, 1))},
    {"color": "#6b6b6b", "linestyle": (0, (8, 2))},
)


def discretisation(
    alpha: float,
    dt: float = 0.2,
    *,
    memory: int = 100,
    sections: int = 9,
    methods: Sequence[str] = METHODS,
    axes: Sequence[Axes] | Panels | None = None,
) -> Panels:
    """Draw the methods' magnitude, phase and error against s^alpha.

    Parameters
    ----------
    alpha
        order in (-2, 2)
    dt
        sample time [s]
    memory
        of the truncated series [samples]
    sections
        of the others
    methods
        which of METHODS
    axes
        three; None: a new figure

    Returns
    -------
    array of Axes
        magnitude [dB], phase [degree] and relative error [-] against frequency [rad/s]

    Raises
    ------
    ValueError
        As discretise().
    """
    panels = style.new_panels(axes, 3)
    nyquist = np.pi / checks.sample_time(dt)
    omega = np.geomspace(nyquist / 1000, nyquist * 0.999, 600)
    ideal = (1j * omega) ** checks.order("alpha", alpha)
    magnitude, phase, error = panels
    magnitude.plot(omega, 20 * np.log10(np.abs(ideal)), label="ideal", **style.REFERENCE)
    phase.plot(omega, np.full(omega.size, 90 * alpha), **style.REFERENCE)
    for method, stroke in zip(methods, _STROKES, strict=False):
        model = discretise(alpha, dt, method, memory=memory, sections=sections)
        ratio = model.response(omega) / ideal
        line = {"linewidth": 1.2, "zorder": 3.0, **stroke}
        magnitude.plot(omega, 20 * np.log10(np.abs(ratio * ideal)), label=method, **line)
        phase.plot(omega, 90 * alpha + np.angle(ratio, deg=True), **line)
        error.plot(omega, np.maximum(np.abs(ratio - 1), 1e-17), **line)
    for panel in panels:
        panel.set_xscale("log")
    error.set_yscale("log")
    style.finish(magnitude, "", "magnitude [dB]")
    style.finish(phase, "", "phase [degree]")
    style.finish(error, "frequency [rad/s]", "relative error [-]")
    style.legend_above(magnitude)
    return panels
