"""The command `nfopidn trajectory`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np

from nfopidn._core import Robot, Scenario, Trajectory
from nfopidn.arguments import suggestion
from nfopidn.commands.parsing import pairs
from nfopidn.files import check_outputs, replace_file
from nfopidn.formats import (
    Log,
    read_bag,
    read_choreo,
    read_csv,
    read_pathweaver,
    read_tum,
    read_urdf,
    write_mcap,
    write_pathweaver,
    write_tum,
)
from nfopidn.trajectories import Limits, plan_waypoints

_BY_SUFFIX = {
    ".csv": "csv",
    ".txt": "csv",
    ".tum": "tum",
    ".bag": "bag",
    ".db3": "bag",
    ".mcap": "bag",
    ".path": "pathweaver",
    ".json": "pathweaver",
    ".traj": "choreo",
}
_FORMATS = tuple(dict.fromkeys(_BY_SUFFIX.values()))
_LIMITS = tuple(field.name for field in fields(Limits))
_OF_WAYPOINTS = ("laps", "tolerance", "corner", "smoothing")


def _columns(words: Sequence[str]) -> dict[str, str | int]:
    given = pairs(words, "column", 0)
    return {name: int(value) if value.isdigit() else value for name, value in given.items()}


def _format(arguments: argparse.Namespace) -> str:
    if arguments.format:
        return str(arguments.format)
    path = Path(arguments.input)
    found = "bag" if path.is_dir() else _BY_SUFFIX.get(path.suffix.lower())
    if found is None:
        raise ValueError(f"{path}: --format says which of {', '.join(_FORMATS)} it is")
    return found


def _read(arguments: argparse.Namespace) -> Log:
    kind = _format(arguments)
    if kind != "csv" and (arguments.column or arguments.unit):
        raise ValueError(f"--column and --unit are of tables; {arguments.input} is read as {kind}")
    if kind != "bag" and (arguments.topic or arguments.stamps or arguments.child_frame):
        raise ValueError(
            f"--topic, --stamps and --child-frame are of bags; {arguments.input} is read as {kind}"
        )
    if kind == "csv":
        units = pairs(arguments.unit, "unit", 0)
        return read_csv(arguments.input, _columns(arguments.column), units)
    if kind == "bag":
        return read_bag(
            arguments.input,
            arguments.topic,
            stamps=arguments.stamps or "header",
            child_frame=arguments.child_frame,
        )
    readers = {"tum": read_tum, "pathweaver": read_pathweaver, "choreo": read_choreo}
    return readers[kind](arguments.input)


def _limits(words: Sequence[str]) -> Limits | None:
    given = pairs(words, "limit", 1)
    for name in given:
        if name not in _LIMITS:
            hint = suggestion(name, _LIMITS)
            raise ValueError(f"--limit {name}: no limit{hint}; known: {', '.join(_LIMITS)}")
    return Limits(**given) if given else None


def _robot(arguments: argparse.Namespace, scenario: Scenario | None) -> Robot | None:
    if arguments.urdf:
        if scenario is not None:
            raise ValueError("--urdf and --scenario both have a robot; give one")
        found = read_urdf(arguments.urdf)
        for note in found.notes:
            print(f"nfopidn: {note}", file=sys.stderr)
        return found.robot
    return scenario.robot if scenario is not None else None


def _made(arguments: argparse.Namespace, log: Log, robot: Robot | None) -> Trajectory:
    """Return the trajectory: as fast as the limits allow where there are any, else as it was."""
    limits = _limits(arguments.limit)
    if limits is None:
        unused = [name for name in _OF_WAYPOINTS if getattr(arguments, name) is not None]
        if unused or arguments.closed:
            name = unused[0] if unused else "closed"
            raise ValueError(f"--{name} is of waypoints, which need --limit")
        return log.trajectory(arguments.dt, arguments.speed_limit)
    if arguments.dt is None:
        raise ValueError("--limit needs --dt, the sample time [s]")
    if arguments.speed_limit is not None:
        raise ValueError("--speed-limit is of a log's outliers; --limit speed=... of the motion")
    given = {
        name: getattr(arguments, name)
        for name in _OF_WAYPOINTS
        if getattr(arguments, name) is not None
    }
    speed = None if log.v is None else np.abs(log.v)
    return plan_waypoints(
        log.points,
        limits,
        arguments.dt,
        robot,
        theta=log.theta,
        speed=speed if arguments.use_speed else None,
        reverse=log.reverse,
        closed=arguments.closed,
        lower_speeds=True,
        **given,
    ).trajectory


def _table(trajectory: Trajectory) -> str:
    east, north = trajectory.origin
    columns = (trajectory.t, trajectory.x + east, trajectory.y + north, trajectory.theta)
    rows = np.column_stack([*columns, trajectory.reverse]).tolist()
    lines = [",".join([*map(repr, row[:4]), str(int(row[4]))]) for row in rows]
    return "\n".join(["t,x,y,theta,reverse", *lines]) + "\n"


def _write(
    path: str, trajectory: Trajectory, scenario: Scenario | None, robot: Robot | None
) -> None:
    name = path.lower()
    if name.endswith(".wpilib.json"):
        write_pathweaver(trajectory, path)
    elif name.endswith(".json"):
        if scenario is None:
            if robot is None:
                robot = Robot()
                print(f"nfopidn: no --scenario and no --urdf; {robot}", file=sys.stderr)
            scenario = Scenario(trajectory, robot, rng=0)
        scenario.replace(trajectory=trajectory).save(path)
    elif name.endswith(".tum"):
        write_tum(trajectory, path)
    elif name.endswith(".mcap"):
        write_mcap(trajectory, path)
    else:
        replace_file(path, _table(trajectory))


def _run(arguments: argparse.Namespace) -> int:
    scenario = Scenario.load(arguments.scenario) if arguments.scenario else None
    robot = _robot(arguments, scenario)
    known = (".csv", ".json", ".tum", ".mcap")
    if not arguments.output.lower().endswith(known):
        raise ValueError(f"--output {arguments.output}: must end in one of {', '.join(known)}")
    inputs = [
        one for one in (arguments.input, arguments.scenario, arguments.urdf) if one is not None
    ]
    check_outputs({"--output": arguments.output}, inputs=inputs)
    log = _read(arguments)
    if arguments.limit:
        for note in log.notes:
            print(f"nfopidn: {note}", file=sys.stderr)
    trajectory = _made(arguments, log, robot)
    for note in trajectory.notes:
        print(f"nfopidn: {note}", file=sys.stderr)
    _write(arguments.output, trajectory, scenario, robot)
    if not arguments.quiet:
        print(
            f"{len(trajectory)} samples, {trajectory.t[-1]:.6g} s, peak speed "
            f"{trajectory.peak_speed:.4g} m/s: {arguments.output}"
        )
    return 0


def add_trajectory(commands: Any) -> None:
    """Add the command to those of `nfopidn`."""
    parser = commands.add_parser(
        "trajectory",
        help="make a trajectory from waypoints or a log",
        description="Reads waypoints or a log and writes a trajectory. With --limit it is the "
        "fastest through the points that keeps the limits, from rest to rest; without, the log's "
        "own motion in equal steps. What was made of each column goes to standard error. Exit "
        "code: 0 done, 2 bad usage or bad file.",
    )
    add = parser.add_argument
    add("input", metavar="FILE", help="table, TUM file, bag, PathWeaver or Choreo trajectory")
    add(
        "-o",
        "--output",
        default="trajectory.csv",
        metavar="FILE",
        help="a table (.csv), a scenario (.json), .tum, .mcap or .wpilib.json (%(default)s)",
    )
    add("--format", choices=_FORMATS, help="of the input; default: by its name")
    add("--column", action="append", default=[], metavar="QUANTITY=NAME", help="of a table")
    add("--unit", action="append", default=[], metavar="QUANTITY=UNIT", help="of a table's column")
    add("--topic", help="of a bag")
    add("--stamps", choices=("header", "log"), help="of a bag: when measured, or when recorded")
    add("--child-frame", metavar="NAME", help="of a bag's tf")
    add("--dt", type=float, help="sample time [s]; default: the log's median step")
    add("--speed-limit", type=float, metavar="SPEED", help="refuse steps of a log that are faster")
    add(
        "--limit",
        action="append",
        default=[],
        metavar="NAME=NUMBER",
        help=f"of the motion: {', '.join(_LIMITS)}",
    )
    add(
        "--use-speed",
        action="store_true",
        help="no faster at a point than the file says",
    )
    add("--closed", action="store_true", help="the path goes on from its last point to its first")
    add("--laps", type=int, help="of a closed path (1)")
    add("--tolerance", type=float, metavar="METRES", help="how far the path may pass points (0)")
    add("--corner", type=float, metavar="RADIANS", help="turns beyond are made on the spot (2)")
    add("--smoothing", type=float, metavar="SECONDS", help="mean of the acceleration over (5 dt)")
    add("--scenario", metavar="FILE", help="has the robot; a scenario that is written is like it")
    add("--urdf", metavar="FILE", help="has the robot")
    add("--quiet", action="store_true", help="print nothing to standard output")
    parser.set_defaults(run=_run)
