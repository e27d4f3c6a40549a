"""Windows of a log, each with a first state of its own, so that noise and drift do not add up."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nfopidn.identification.motion import Motion

Array = NDArray[np.float64]

_SMOOTHING = 0.5  # [s] to either side


@dataclass(frozen=True)
class Window:
    """Rows of a log that one run of the simulator explains.

    Attributes
    ----------
    first
        its first node: node k is at k dt.
    rows
        (n,) rows of the log's poses.
    cell, place
        (n,) the cell of the grid in which each row's stamp is, and where in it, in [0, 1).
    start
        (5,) x, y, theta, v, omega at the first node, of smoothed poses.
    """

    first: int
    rows: NDArray[np.intp]
    cell: NDArray[np.intp]
    place: Array
    start: Array


@dataclass(frozen=True)
class Smoothed:
    """Poses and their derivatives from local cubics, at the nodes.

    Attributes
    ----------
    pose, rate, second
        (n, 3) of x, y, theta: values, first and second derivatives.
    noise
        what the cubics leave of position [m] and heading [rad], as standard deviations.
    good
        (n,) whether there are rows enough around the node.
    """

    pose: Array
    rate: Array
    second: Array
    noise: tuple[float, float]
    good: NDArray[np.bool_]


def smoothed(motion: Motion, nodes: Array) -> Smoothed:
    """Fit a cubic around each node to the poses, after a running median has taken outliers out."""
    step = float(np.median(np.diff(motion.t)))
    half = max(_SMOOTHING, 4 * step)
    pose = _without_outliers(motion.pose)
    found = np.zeros((3, len(nodes), 3))
    good = np.zeros(len(nodes), dtype=bool)
    left: list[Array] = []
    low = np.searchsorted(motion.t, nodes - half)
    high = np.searchsorted(motion.t, nodes + half, side="right")
    for k, (a, b) in enumerate(zip(low, high, strict=True)):
        if b - a < 6:
            continue
        basis = np.vander((motion.t[a:b] - nodes[k]) / half, 4, increasing=True)
        coefficients, *_ = np.linalg.lstsq(basis, pose[a:b], rcond=None)
        found[:, k] = coefficients[:3] * np.array([[1], [1 / half], [2 / half**2]])
        good[k] = True
        middle = min(max(int(np.searchsorted(motion.t, nodes[k])), a), b - 1)
        freedom = np.sqrt(1 - 4 / (b - a))
        left.append((pose[middle] - basis[middle - a] @ coefficients) / freedom)
    rest = np.abs(np.array(left)) if left else np.ones((1, 3))
    typical = 1.4826 * np.median(rest, axis=0)
    noise = (max(float(np.hypot(*typical[:2]) / 2**0.5), 1e-6), max(float(typical[2]), 1e-6))
    return Smoothed(found[0], found[1], found[2], noise, good)


def _without_outliers(pose: Array) -> Array:
    """Return the poses with what lies far from a running median put there."""
    from scipy.ndimage import median_filter

    middle = median_filter(pose, size=(5, 1), mode="nearest")
    away = np.abs(pose - middle)
    limit = 10 * np.maximum(1.4826 * np.median(away, axis=0), 1e-9)
    result: Array = np.where(
        away > np.maximum(limit, 5 * np.percentile(away, 90, axis=0)), middle, pose
    )
    return result


def windows_of(motion: Motion, smooth: Smoothed, length: int, longest_delay: float) -> list[Window]:
    """Cut the log into windows of `length` cells that have poses and commands all through."""
    dt = motion.dt
    start = max(0.0, motion.command_t[0] + longest_delay)
    end = min(motion.t[-1], motion.command_t[-1] + dt + min(longest_delay, 0.0))
    position = motion.t / dt
    cells = np.floor(position + 1e-6).astype(np.intp)
    windows = []
    first = int(np.ceil(start / dt - 1e-6))
    while (first + length) * dt <= end + 1e-6 * dt:
        rows = np.flatnonzero((cells >= first) & (cells < first + length))
        if len(rows) >= max(8, length // 4) and smooth.good[first]:
            cell = cells[rows] - first
            place = np.clip(position[rows] - cells[rows], 0.0, 1.0)
            state = _state(smooth, first)
            windows.append(Window(first, rows, cell, place, state))
        first += length
    return windows


def _state(smooth: Smoothed, node: int) -> Array:
    x, y, theta = smooth.pose[node]
    rate = smooth.rate[node]
    forward = rate[0] * np.cos(theta) + rate[1] * np.sin(theta)
    return np.array([x, y, theta, forward, rate[2]])
