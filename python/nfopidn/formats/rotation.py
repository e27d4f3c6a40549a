"""Quaternions of robots on a floor."""

from __future__ import annotations

import numpy as np

from nfopidn.formats.log import Array

#: A quaternion whose square is farther from 1 than this is none.
_UNIT = 0.05
_TILTED = 0.2
#: Cosine of a tilt that no robot drives at.
_UPRIGHT = 0.5


def yaw_of(where: str, x: Array, y: Array, z: Array, w: Array) -> tuple[Array, list[str]]:
    """Return the yaw (N,) [rad] of quaternions x, y, z, w, and what is worth knowing of them.

    Raises
    ------
    ValueError
        Names the sample whose quaternion is not of unit length, or on its side: w first, perhaps.
    """
    size = x * x + y * y + z * z + w * w
    for k in np.flatnonzero(np.abs(size - 1.0) > _UNIT):
        raise ValueError(
            f"{where}: the quaternion of sample {k}, ({x[k]:g}, {y[k]:g}, {z[k]:g}, {w[k]:g}), is "
            f"{np.sqrt(size[k]):.3g} long; must be 1"
        )
    upright = 1.0 - 2.0 * (x * x + y * y) / size
    for k in np.flatnonzero(upright < _UPRIGHT):
        raise ValueError(
            f"{where}: the robot of sample {k} lies on its side: quaternion ({x[k]:g}, {y[k]:g}, "
            f"{z[k]:g}, {w[k]:g}) in the order x y z w; a file with w first?"
        )
    tilt = np.arccos(np.clip(upright, -1.0, 1.0))
    notes = []
    if tilt.max() > _TILTED:
        worst = int(np.argmax(tilt))
        notes.append(
            f"the robot tilts by up to {tilt[worst]:.3g} rad (sample {worst}); its yaw is used"
        )
    return np.arctan2(2 * (w * z + x * y), size - 2 * (y * y + z * z)), notes
