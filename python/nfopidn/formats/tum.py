"""Trajectories of the TUM RGB-D benchmark: timestamp tx ty tz qx qy qz qw."""

from __future__ import annotations

import os

import numpy as np

from nfopidn import _core
from nfopidn._core import SimulationResult, Trajectory
from nfopidn.formats.log import Log, poses_of
from nfopidn.formats.rotation import yaw_of

_COLUMNS = 8


def read_tum(path: str | os.PathLike[str]) -> Log:
    """Return the states of a TUM file; # begins a comment.

    x and y are tx and ty, the heading is the yaw of qx qy qz qw.

    Raises
    ------
    ValueError
        Names file and line; a quaternion that is none, or whose w comes first.
    OSError
        The file cannot be read.
    """
    where = os.fspath(path)
    rows = []
    for number, line in enumerate(_core.read_text(path).splitlines(), start=1):
        text = line.partition("#")[0].replace(",", " ").split()
        if not text:
            continue
        if len(text) != _COLUMNS:
            raise ValueError(
                f"{where}:{number}: {len(text)} numbers; a TUM file has 8: timestamp tx ty tz qx "
                "qy qz qw"
            )
        try:
            rows.append([float(cell) for cell in text])
        except ValueError:
            raise ValueError(f"{where}:{number}: {line.strip()[:80]!r} is not 8 numbers") from None
        if not np.isfinite(rows[-1]).all():
            raise ValueError(f"{where}:{number}: {line.strip()[:80]!r} is not finite")
    if not rows:
        raise ValueError(f"{where}: no poses")
    t, x, y, z, *quaternion = np.array(rows).T
    theta, notes = yaw_of(where, *quaternion)
    heights = bool(np.ptp(z) > 0.1)
    if t[0] > 1e15:
        raise ValueError(f"{where}: the first stamp is {t[0]:g}; a TUM file's are seconds")
    said = [f"{where}: t, x, y, theta from timestamp, tx, ty and the yaw of qx qy qz qw", *notes]
    if heights:
        said.append(f"the robot moves {np.ptp(z):.3g} m up and down, which is not used")
    return Log(
        x=x, y=y, t=t - t[0], theta=theta, start=float(t[0]), source=where, notes=tuple(said)
    )


def write_tum(
    source: Trajectory | SimulationResult,
    path: str | os.PathLike[str],
    *,
    reference: bool = False,
    start: float = 0.0,
) -> None:
    """Write the poses of a trajectory or a run as a TUM file, as evo reads it.

    evo's absolute pose error of a run against its reference, without alignment, is the run's
    `position_rms`.

    Parameters
    ----------
    source
        a Trajectory, or a SimulationResult.
    path
        of the file.
    reference
        of a run: its reference, not the robot.
    start
        added to the stamps [s].
    """
    poses = poses_of(source, reference)
    lines = ["# timestamp tx ty tz qx qy qz qw"]
    half = 0.5 * poses.theta
    for t, x, y, c, s in zip(
        poses.t + start, poses.x, poses.y, np.cos(half), np.sin(half), strict=True
    ):
        numbers = " ".join(repr(float(number)) for number in (x, y, 0, 0, 0, s, c))
        lines.append(f"{t:.9f} {numbers}")
    _core.write_file(path, ("\n".join(lines) + "\n").encode())
