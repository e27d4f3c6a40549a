"""Weights of the fractional operators' truncated power series."""

import numpy as np
from numpy.typing import NDArray


def generator_weights(generator: str, order: float, memory: int) -> NDArray[np.float64]:
    """Return f_j of ((1 - w)/(1 + w))^order (tustin) or g_j of (1 - w)^order (gl), j <= memory."""
    weights = np.ones(memory + 1)
    for j in range(1, memory + 1):
        if generator == "gl":
            weights[j] = weights[j - 1] * (j - 1 - order) / j
        else:
            before = (j - 2) * weights[j - 2] if j > 1 else 0.0
            weights[j] = (before - 2 * order * weights[j - 1]) / j
    return weights
