"""Trajectories of FIRST's tools: PathWeaver (WPILib) and Choreo."""

from __future__ import annotations

import json
import os
from typing import Any

import numpy as np

from nfopidn import _core
from nfopidn._core import SimulationResult, Trajectory
from nfopidn.formats.csv import read_csv
from nfopidn.formats.log import Array, Log, poses_of

_STILL = 1e-9
_TURNS = 1e-6


def _document(path: str | os.PathLike[str]) -> Any:
    where = os.fspath(path)
    try:
        return json.loads(_core.read_text(path))
    except (json.JSONDecodeError, RecursionError) as error:
        raise ValueError(f"{where}: not JSON: {error}") from None


def _at(where: str, thing: Any, keys: tuple[str, ...]) -> float:
    """Return a number of a state."""
    found = thing
    for key in keys:
        if not isinstance(found, dict) or key not in found:
            raise ValueError(f"{where} has no {'.'.join(keys)}")
        found = found[key]
    if isinstance(found, bool) or not isinstance(found, int | float) or not np.isfinite(found):
        raise ValueError(f"{where}.{'.'.join(keys)} is {found!r}; must be a finite number")
    return float(found)


def _column(where: str, states: list[Any], *keys: str) -> Array:
    return np.array([_at(f"{where}[{k}]", state, keys) for k, state in enumerate(states)])


def read_pathweaver(path: str | os.PathLike[str]) -> Log:
    """Return the states of a PathWeaver trajectory (.wpilib.json), or the points of a path (.path).

    The velocity is signed: the robot of a reversed trajectory drives backwards, its heading as in
    the file. A path's points come with their tangents; Fixed Theta is PathWeaver's own.

    Raises
    ------
    ValueError
        Names file and state.
    OSError
        The file cannot be read.
    """
    where = os.fspath(path)
    if where.lower().endswith((".path", ".csv")):
        return _read_path(where)
    states = _document(path)
    if not isinstance(states, list) or not states:
        raise ValueError(f"{where}: must be a list of states, as PathWeaver writes it")
    t = _column(where, states, "time")
    v = _column(where, states, "velocity")
    curvature = _column(where, states, "curvature")
    notes = [f"{where}: t, x, y, theta, v from time, pose and velocity; omega is v curvature"]
    if (v < 0).any():
        notes.append(f"drives backwards at {int((v < 0).sum())} of {len(v)} states")
    return Log(
        x=_column(where, states, "pose", "translation", "x"),
        y=_column(where, states, "pose", "translation", "y"),
        t=t - t[0],
        theta=np.unwrap(_column(where, states, "pose", "rotation", "radians")),
        v=v,
        omega=v * curvature,
        start=float(t[0]),
        source=where,
        notes=tuple(notes),
    )


def _read_path(where: str) -> Log:
    names, _, rows = _core.read_table(where)
    wanted = ["X", "Y", "Tangent X", "Tangent Y"]
    lacking = [name for name in wanted if name not in names]
    if lacking:
        raise ValueError(
            f"{where}: no column {lacking[0]}; a PathWeaver path has {', '.join(wanted)}; this "
            f"one has {', '.join(names)}"
        )
    log = read_csv(where, columns={"x": "X", "y": "Y"})
    try:
        tangents = np.array(
            [[float(row[names.index(name)]) for name in wanted[2:]] for row in rows]
        )
    except ValueError as error:
        raise ValueError(f"{where}: a tangent: {error}") from None
    reverse = np.zeros(len(rows), dtype=bool)
    if "Reversed" in names:
        reverse = np.array([row[names.index("Reversed")].lower() == "true" for row in rows])
    theta = np.arctan2(tangents[:, 1], tangents[:, 0]) + np.pi * reverse
    theta[~tangents.any(axis=1)] = np.nan
    note = f"{where}: x, y, theta from X, Y and the tangents, reverse from Reversed"
    return Log(
        x=log.x,
        y=log.y,
        theta=theta,
        reverse=reverse,
        source=where,
        notes=(note, "PathWeaver's y axis begins at the top of the field in versions before 2020"),
    )


def write_pathweaver(
    source: Trajectory | SimulationResult,
    path: str | os.PathLike[str],
    *,
    reference: bool = False,
) -> None:
    """Write a trajectory or a run as WPILib's TrajectoryUtil reads it (.wpilib.json).

    WPILib's states have no turning rate, only curvature, omega/v, and between two states at one
    place its `Trajectory.sample()` gives poses of nan. So rests at both ends are left out, the
    times of the others being as they were, and what waits or turns on the spot in between cannot be
    written.

    Raises
    ------
    ValueError
        Names the sample that stands in between, or a motion without two places.
    """
    poses = poses_of(source, reference)
    moved = np.hypot(np.diff(poses.x), np.diff(poses.y)) > 0
    going = np.flatnonzero(moved)
    if not going.size:
        raise ValueError("source stands at one place; WPILib's trajectories move")
    first, last = int(going[0]), int(going[-1]) + 1
    for k in first + np.flatnonzero(~moved[first:last]):
        doing = "turns on the spot" if abs(poses.omega[k]) > _TURNS else "waits"
        raise ValueError(
            f"sample {k}, at {poses.t[k]:.4g} s, {doing}, which WPILib's states cannot say; cut "
            "the trajectory at its stops"
        )
    safe = np.where(np.abs(poses.v) < _STILL, 1.0, poses.v)
    curvature = np.where(np.abs(poses.v) < _STILL, 0.0, poses.omega / safe)
    states = [
        {
            "time": float(poses.t[k]),
            "velocity": float(poses.v[k]),
            "acceleration": float(poses.acceleration[k]),
            "pose": {
                "translation": {"x": float(poses.x[k]), "y": float(poses.y[k])},
                "rotation": {"radians": float(poses.theta[k])},
            },
            "curvature": float(curvature[k]),
        }
        for k in range(first, last + 1)
    ]
    _core.write_file(path, json.dumps(states, allow_nan=False).encode())


def read_choreo(path: str | os.PathLike[str]) -> Log:
    """Return the states of a Choreo trajectory (.traj) of a differential drive.

    v is the mean of the sides' speeds vl and vr, signed along the heading, and omega the file's
    own. `alpha` is not used: ChoreoLib documents it as an angular acceleration, which it is said
    not to be in files of differential drives. Nor are al, ar, fl, fr.

    Raises
    ------
    ValueError
        Names file and sample; a swerve trajectory, which a differential drive cannot follow.
    OSError
        The file cannot be read.
    """
    where = os.fspath(path)
    document = _document(path)
    inner = document.get("trajectory", document) if isinstance(document, dict) else None
    samples = inner.get("samples") if isinstance(inner, dict) else None
    if not isinstance(samples, list) or not samples:
        raise ValueError(f"{where}: no samples; a Choreo trajectory has them under trajectory")
    if samples and isinstance(samples[0], list):  # of early versions, one list a split
        samples = [one for split in samples for one in split]
    first = samples[0] if isinstance(samples[0], dict) else {}
    kind = inner.get("sampleType") if isinstance(inner, dict) else None
    if kind == "Swerve" or ("vl" not in first and "vx" in first):
        raise ValueError(
            f"{where}: a swerve trajectory, whose heading is free of its motion; a differential "
            "drive cannot follow it"
        )
    name = f"{where}: samples"
    t = _column(name, samples, "t")
    left, right = _column(name, samples, "vl"), _column(name, samples, "vr")
    omega = _column(name, samples, "omega") if "omega" in first else None
    v = 0.5 * (left + right)
    notes = [
        f"{where}: t, x, y, theta from t, x, y, heading; v is the mean of vl and vr"
        + ("; omega as it is" if omega is not None else "")
        + "; not used: "
        + ", ".join(sorted(set(first) - {"t", "x", "y", "heading", "vl", "vr", "omega"}))
    ]
    if (v < 0).any():
        notes.append(f"drives backwards at {int((v < 0).sum())} of {len(v)} samples")
    return Log(
        x=_column(name, samples, "x"),
        y=_column(name, samples, "y"),
        t=t - t[0],
        theta=np.unwrap(_column(name, samples, "heading")),
        v=v,
        omega=omega,
        start=float(t[0]),
        source=where,
        notes=tuple(notes),
    )
