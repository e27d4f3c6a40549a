"""A differential drive's numbers from its URDF, by yourdfpy."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from nfopidn._core import Robot
from nfopidn.arguments import suggestion
from nfopidn.formats.log import Array, extra

_TOGETHER = 1e-3


@dataclass(frozen=True)
class RobotDescription:
    """A robot that was read from a URDF.

    Attributes
    ----------
    robot
        its Robot.
    wheels
        names of the joints of left and right wheel.
    center_of_mass
        in the frame of the wheels' axle, forward and left [m]; the Robot has it in the middle.
    notes
        where each number is from, and what is left out.
    """

    robot: Robot
    wheels: tuple[str, str]
    center_of_mass: tuple[float, float]
    notes: tuple[str, ...]


def _wheel_joints(where: str, model: Any, given: tuple[str, str] | None) -> tuple[str, str]:
    """Return the joints of the wheels: those given, or the only two that turn without end."""
    names = list(model.joint_map)
    if given is not None:
        if len(given) != 2:
            raise ValueError(f"wheels is {given!r}; must be two joints, left and right")
        for name in given:
            if name not in names:
                raise ValueError(
                    f"{where}: no joint {name!r}{suggestion(name, names)}; there are "
                    f"{', '.join(names)}"
                )
        return (given[0], given[1])
    turning = [name for name, joint in model.joint_map.items() if joint.type == "continuous"]
    driven = [name for name in turning if "caster" not in name.lower()]
    if len(driven) != 2:
        raise ValueError(
            f"{where}: wheels says which two joints are the wheels, left and right; those that "
            f"turn without end are {', '.join(turning) or 'none'}"
        )
    return (driven[0], driven[1])


def _radius(where: str, link: Any) -> tuple[float, str]:
    """Return a wheel's radius [m] and what it is from."""
    for kind in ("collisions", "visuals"):
        for shape in getattr(link, kind) or []:
            geometry = shape.geometry
            for name in ("cylinder", "sphere"):
                found = getattr(geometry, name, None)
                if found is not None:
                    return float(found.radius), f"the {name} of {link.name}'s {kind}"
    raise ValueError(
        f"{where}: link {link.name} has neither a cylinder nor a sphere; wheel_radius says its "
        "radius [m]"
    )


def _moved(link: Any, transform: Array) -> tuple[float, Array, Array]:
    """Return mass, centre (3,) and tensor of inertia (3, 3) of a link in the robot's axes."""
    inertial = link.inertial
    if inertial is None or inertial.mass is None:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    own = np.eye(4) if inertial.origin is None else np.asarray(inertial.origin, dtype=float)
    place = transform @ own
    tensor = np.zeros((3, 3)) if inertial.inertia is None else np.asarray(inertial.inertia)
    turned = place[:3, :3] @ tensor @ place[:3, :3].T
    return float(inertial.mass), place[:3, 3], turned


def read_urdf(
    path: str | os.PathLike[str],
    *,
    wheels: tuple[str, str] | None = None,
    wheel_radius: float | None = None,
) -> RobotDescription:
    """Return the Robot of a URDF: mass, inertia about the axle's middle, track and wheel radius.

    The mass is that of all links, the inertia theirs about the vertical axis through the middle of
    the axle, by Steiner. The track is the distance between the wheels' joints. What turns in the
    wheels, beside the robot, is not added. Needs the extra `formats`.

    Parameters
    ----------
    path
        of the URDF; a xacro file must be expanded before.
    wheels
        names of the wheels' joints, left and right; None: the only two that turn without end.
    wheel_radius
        [m]; None: that of the wheels' cylinders or spheres.

    Raises
    ------
    ValueError
        The joints that may be wheels; a link without shape; no mass at all.
    ImportError
        yourdfpy is not installed.
    OSError
        The file cannot be read.
    """
    where = os.fspath(path)
    with open(where, "rb"):
        pass
    yourdfpy = extra("yourdfpy", "read_urdf")
    try:
        model = yourdfpy.URDF.load(
            where, build_scene_graph=True, load_meshes=False, build_collision_scene_graph=False
        )
    except Exception as error:  # of XML, or what yourdfpy makes of it
        raise ValueError(f"{where}: not a URDF: {error}") from None
    joints = _wheel_joints(where, model, wheels)
    links = [model.link_map[model.joint_map[name].child] for name in joints]
    base = model.base_link
    places = [model.get_transform(link.name, base)[:3, 3] for link in links]
    if places[0][1] < places[1][1]:  # the first is the right one
        joints, links, places = joints[::-1], links[::-1], places[::-1]
    middle = 0.5 * (places[0] + places[1])
    track = float(np.hypot(*(places[0] - places[1])[:2]))
    notes = [
        f"{where}: wheels {joints[0]} (left) and {joints[1]} (right), {track:.6g} m apart",
    ]
    if wheel_radius is None:
        found = [_radius(where, link) for link in links]
        wheel_radius = 0.5 * (found[0][0] + found[1][0])
        notes.append(f"wheel radius {wheel_radius:.6g} m from {found[0][1]}")
        if abs(found[0][0] - found[1][0]) > _TOGETHER * wheel_radius:
            notes.append(
                f"the wheels' radii differ, {found[0][0]:g} and {found[1][0]:g} m: their mean"
            )
    mass, inertia, moment = 0.0, 0.0, np.zeros(3)
    light, points = [], []
    for name, link in model.link_map.items():
        own, centre, tensor = _moved(link, model.get_transform(name, base))
        if own == 0.0:
            light.append(name)
        elif link.inertial.inertia is None:
            points.append(name)
        elif tensor[2, 2] > own * track * track:
            notes.append(
                f"the inertia of {name}, {tensor[2, 2]:.3g} kg m^2 for {own:.3g} kg, is that of a "
                "body wider than the robot: a placeholder?"
            )
        mass += own
        moment += own * centre
        away = centre - middle
        inertia += float(tensor[2, 2]) + own * float(away[0] ** 2 + away[1] ** 2)
    if mass <= 0.0:
        raise ValueError(f"{where}: no link has a mass")
    offset = moment / mass - middle
    notes.append(
        f"mass {mass:.6g} kg of {len(model.link_map) - len(light)} links, inertia "
        f"{inertia:.6g} kg m^2 about the middle of the axle"
    )
    if points:
        notes.append(f"with a mass but no inertia of their own: {', '.join(points)}")
    if light:
        notes.append(f"without mass: {', '.join(light)}")
    if np.hypot(offset[0], offset[1]) > _TOGETHER:
        notes.append(
            f"the centre of mass lies {offset[0]:.4g} m ahead and {offset[1]:.4g} m left of the "
            "axle's middle; the Robot's model has it there"
        )
    robot = Robot(mass=mass, inertia=inertia, track_width=track, wheel_radius=wheel_radius)
    return RobotDescription(robot, joints, (float(offset[0]), float(offset[1])), tuple(notes))
