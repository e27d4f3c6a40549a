"""Figures of searches."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from nfopidn.plot import style


def convergence(result: Mapping[str, Any], ax: Axes | None = None) -> Axes:
    """Draw the best cost so far, and the mean of the cells, against evaluations.

    Parameters
    ----------
    result
        what tune() or bfoa() has returned
    ax
        where; None: a new figure
    """
    ax = style.new_axes(ax)
    history = result["history"]
    nfev = history["nfev"]
    mean = np.where(np.isfinite(history["mean"]), history["mean"], np.nan)
    ax.plot(nfev, mean, label="mean of the cells", **style.MEAN)
    ax.plot(nfev, history["best"], drawstyle="steps-post", label="best so far", **style.ROBOT)
    positive = history["best"][-1] > 0 if len(history) else False
    ax.set_yscale("log" if positive else "linear")
    style.finish(ax, "evaluations", "cost E" if "controller" in result else "cost")
    style.legend_above(ax)
    return ax
