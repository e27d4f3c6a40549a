"""Where the search starts: linear least squares with the accelerations as dependent variables.

The other way round, torques as a sum over noisy accelerations, the accelerations' noise pulls their
factors, mass and inertia, towards zero.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nfopidn._core import Robot
from nfopidn.identification.windows import Smoothed

Array = NDArray[np.float64]

_STANDSTILL = 0.2  # of the root mean square speed of the wheels: friction's sign rises over it
_SEEN = 1e-3  # least share of an effect's size beside the others' that counts as excited


def speeds(smooth: Smoothed) -> tuple[Array, Array]:
    """Return v, omega (n, 2) and their derivatives (n, 2)."""
    theta = smooth.pose[:, 2]
    c, s = np.cos(theta), np.sin(theta)
    v = smooth.rate[:, 0] * c + smooth.rate[:, 1] * s
    a = smooth.second[:, 0] * c + smooth.second[:, 1] * s
    return (
        np.column_stack([v, smooth.rate[:, 2]]),
        np.column_stack([a, smooth.second[:, 2]]),
    )


def averaged(values: Array, cells: int) -> Array:
    """Return running means over as much as the cubics of the poses take for a second derivative."""
    window = np.hanning(2 * cells + 3)[1:-1]
    window /= window.sum()
    return np.column_stack([np.convolve(column, window, mode="same") for column in values.T])


def drive_start(
    smooth: Smoothed, torque: Array, robot: Robot, half: int
) -> tuple[dict[str, float], float]:
    """Return parameters of a drive and the share of the accelerations that they leave.

    Parameters
    ----------
    torque
        (n, 2) mean over the cells around each node [N m].
    half
        nodes on either side over which the poses' derivatives are taken.

    Returns
    -------
    dict
        mass, inertia, friction; those whose effect does not show are left out. An inertia or mass
        below zero: the signs of the torques are not those of the motion.
    """
    r, half_track = robot.wheel_radius, robot.track_width / 2
    speed, acceleration = speeds(smooth)
    wheels = np.column_stack(
        [speed[:, 0] + speed[:, 1] * half_track, speed[:, 0] - speed[:, 1] * half_track]
    )
    soft = max(_STANDSTILL * float(np.sqrt(np.mean(wheels**2))), 1e-9)
    sign = np.tanh(wheels / soft)
    use = (
        smooth.good
        & (np.arange(len(torque)) >= half)
        & (np.arange(len(torque)) < len(torque) - half)
    )
    found: dict[str, float] = {}
    friction: list[tuple[float, float]] = []
    left = total = 0.0
    for axis, (name, side) in enumerate((("mass", 1.0), ("inertia", -1.0))):
        lever = 1.0 if axis == 0 else half_track
        terms = np.column_stack(
            [
                (torque[:, 0] + side * torque[:, 1]) * lever / r,
                -(wheels[:, 0] + side * wheels[:, 1]) * lever / r**2,
                -(sign[:, 0] + side * sign[:, 1]) * lever / r,
            ]
        )
        terms = averaged(terms, half)[use]
        goal = acceleration[use, axis]
        size = np.sqrt(np.mean(terms**2, axis=0))
        seen = size > _SEEN * max(float(size.max()), 1e-12)
        if not seen[0]:
            continue
        factors = np.zeros(3)
        factors[seen] = np.linalg.lstsq(terms[:, seen] / size[seen], goal, rcond=1e-6)[0]
        factors[seen] /= size[seen]
        spread = max(float(np.var(goal)), 1e-12)
        left += float(np.var(goal - terms @ factors)) / spread
        total += 1
        if factors[0] != 0:
            found[name] = 1 / factors[0]
            friction.append((factors[1] / factors[0], factors[2] / factors[0]))
    if friction:
        found["viscous_friction"] = max(float(np.mean([f[0] for f in friction])), 0.0)
        found["coulomb_friction"] = max(float(np.mean([f[1] for f in friction])), 0.0)
    return found, left / max(total, 1.0)


def velocity_start(
    smooth: Smoothed, command: Array, dt: float, half: int
) -> tuple[dict[str, float], float]:
    """Return gains and lag, and the share of the speeds that they leave.

    For each of a row of lags the commands are let lag, and the speeds fitted to what comes out.
    """
    from scipy.signal import lfilter

    speed, _ = speeds(smooth)
    place = np.arange(len(command))
    use = smooth.good & (place >= half) & (place < len(command) - half)
    best: tuple[dict[str, float], float] = ({}, np.inf)
    for lag in dt * 2.0 ** np.arange(-2, 6):
        keep = np.exp(-dt / lag)
        late = averaged(lfilter([1 - keep], [1, -keep], command, axis=0), half)[use]
        found = {"lag": float(lag)}
        left = total = 0.0
        for axis, name in enumerate(("gain", "turn_gain")):
            power = float(late[:, axis] @ late[:, axis])
            if power < 1e-12 * len(late):
                continue
            found[name] = float(late[:, axis] @ speed[use, axis]) / power
            rest = speed[use, axis] - found[name] * late[:, axis]
            left += float(np.var(rest)) / max(float(np.var(speed[use, axis])), 1e-12)
            total += 1
        if total and left / total < best[1]:
            best = (found, left / total)
    return best


def odometry_start(smooth: Smoothed, rates: Array, half: int) -> tuple[dict[str, float], float]:
    """Return radii and track width, and the share of the speeds that they leave.

    The radii are taken to be alike. A track width below zero: left and right are the other ones.
    """
    speed, _ = speeds(smooth)
    place = np.arange(len(rates))
    use = smooth.good & (place >= half) & (place < len(rates) - half)
    mean = averaged(rates, half)[use]
    terms = (0.5 * mean.sum(axis=1), mean[:, 0] - mean[:, 1])
    factors, left, total = [np.nan, np.nan], 0.0, 0
    for axis, term in enumerate(terms):
        power = float(term @ term)
        if power < 1e-6 * max(float(np.sum(mean**2)), 1e-12):
            continue
        factors[axis] = float(term @ speed[use, axis]) / power
        rest = speed[use, axis] - factors[axis] * term
        left += float(np.var(rest)) / max(float(np.var(speed[use, axis])), 1e-12)
        total += 1
    radius, per_track = factors
    found = {}
    if np.isfinite(radius):
        found = {"wheel_radius_left": radius, "wheel_radius_right": radius}
        if np.isfinite(per_track) and per_track != 0:
            found["track_width"] = radius / per_track
    return found, left / max(total, 1)
