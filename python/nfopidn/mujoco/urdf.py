"""A robot of one's own, from its URDF."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike, fspath
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from nfopidn import _core
from nfopidn._core import Robot
from nfopidn.arguments import names_in, real_number, suggestion
from nfopidn.mujoco.engine import load
from nfopidn.mujoco.model import (
    Model,
    add_floor,
    check_joints,
    check_kind,
    drive_joint,
    make_slippery,
    prepare_options,
    wheel_shape,
)
from nfopidn.mujoco.parts import CONTACT_TIME

Array = NDArray[np.float64]

_BASE = "nfopidn_base"
_CASTER = "nfopidn_caster"
_TURNING = ("continuous", "revolute")


def read_urdf(
    path: str | PathLike[str],
    left: str,
    right: str,
    *,
    wheels: str | None,
    casters: Sequence[str],
    floor: float,
    joint_friction: float,
    armature: float,
    torque_limit: float | None,
) -> Model:
    """Read a URDF; see Model.from_urdf, which has the parameters.

    Raises
    ------
    ImportError
        MuJoCo is not installed.
    ValueError
        What is wrong, and in which file.
    """
    check_joints(floor, joint_friction, 0.0, torque_limit)
    if wheels is not None:
        check_kind(wheels)
    real_number("armature", armature, 0.0, 1e6, " kg m^2")
    where = fspath(path)
    root = _parsed(where)
    sliding = names_in("casters", casters)
    _check_names(where, root, left, right, sliding)
    _name_shapes(where, root, sliding)
    base = _free_base(where, root)
    mujoco = load()
    try:
        spec = mujoco.MjSpec.from_string(ElementTree.tostring(root, encoding="unicode"))
        compiled = spec.compile()
    except ValueError as error:
        raise ValueError(f"{where}: MuJoCo reads no robot in it: {error}") from None
    _check_axes(where, compiled, mujoco, left, right)
    prepare_options(spec)
    sides = {_body_of(spec, left), _body_of(spec, right)}
    lowest = _prepare_shapes(where, spec, compiled, mujoco, sides, floor)
    if wheels is not None:
        _replace_wheels(where, spec, mujoco, sides, wheels)
    robot = _measured(where, compiled, mujoco, (left, right), lowest)
    height = -lowest
    spec.body(base).pos = [0, 0, height]
    add_floor(spec, floor)
    for name in (left, right):
        limit = torque_limit
        if limit is None:
            limit = _effort(root, name)
        drive_joint(spec, name, joint_friction, 0.0, armature, limit)
    return Model(spec, robot, left=left, right=right, body=base, wheels="urdf", height=height)


def _parsed(where: str) -> ElementTree.Element:
    """Read the file as XML and leave out what is for the eye."""
    try:
        root = ElementTree.fromstring(_core.read_text(where))
    except ElementTree.ParseError as error:
        raise ValueError(f"{where}: is no XML: {error}") from None
    if root.tag != "robot":
        raise ValueError(f"{where}: is no URDF: its root is <{root.tag}>, not <robot>")
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    folder = Path(where).resolve().parent
    for mesh in root.iter("mesh"):
        name = mesh.get("filename", "")
        if "://" in name:
            raise ValueError(
                f"{where}: the collision shape {name} is found by ROS alone; give its path"
            )
        mesh.set("filename", str(folder / name))
    extension = root.find("mujoco")
    if extension is None:
        extension = ElementTree.SubElement(root, "mujoco")
    compiler = extension.find("compiler")
    if compiler is None:
        compiler = ElementTree.SubElement(extension, "compiler")
    compiler.set("strippath", "false")
    return root


def _check_names(
    where: str, root: ElementTree.Element, left: Any, right: Any, casters: list[str]
) -> None:
    """Refuse names that are not in the file."""
    joints = [joint.get("name", "") for joint in root.findall("joint")]
    links = [link.get("name", "") for link in root.findall("link")]
    for argument, name, known, what in (
        ("left", left, joints, "joint"),
        ("right", right, joints, "joint"),
        *(("casters", name, links, "link") for name in casters),
    ):
        if name not in known:
            raise ValueError(
                f"{where}: {argument} is {name!r}; is no {what} of it{suggestion(name, known)}; "
                f"it has {', '.join(known) or 'none'}"
            )
    for joint in root.findall("joint"):
        if joint.get("name") in (left, right) and joint.get("type") not in _TURNING:
            raise ValueError(
                f"{where}: the joint {joint.get('name')} is {joint.get('type')}; a wheel's is "
                "continuous"
            )
    if left == right:
        raise ValueError(f"{where}: left and right are both {left!r}")


def _name_shapes(where: str, root: ElementTree.Element, casters: list[str]) -> None:
    """Mark the casters' shapes: links on fixed joints lose their names when they are read."""
    for link in root.findall("link"):
        if link.get("name") not in casters:
            continue
        shapes = link.findall("collision")
        if not shapes:
            raise ValueError(f"{where}: the caster {link.get('name')} has no collision shape")
        for number, shape in enumerate(shapes):
            shape.set("name", f"{_CASTER}_{link.get('name')}_{number}")


def _free_base(where: str, root: ElementTree.Element) -> str:
    """Put a floating joint above the root link, which would be bolted to the world; give its name.

    MuJoCo takes the root link of a URDF for the world and forgets its mass.
    """
    children = {child.get("link") for child in root.iterfind("joint/child")}
    tops = [link.get("name", "") for link in root.findall("link")]
    tops = [name for name in tops if name not in children]
    if len(tops) != 1:
        raise ValueError(f"{where}: has {len(tops)} root links ({', '.join(tops)}); must have one")
    ElementTree.SubElement(root, "link", name=_BASE)
    joint = ElementTree.SubElement(root, "joint", name=f"{_BASE}_joint", type="floating")
    ElementTree.SubElement(joint, "parent", link=_BASE)
    ElementTree.SubElement(joint, "child", link=tops[0])
    return tops[0]


def _check_axes(where: str, compiled: Any, mujoco: Any, left: str, right: str) -> None:
    """Refuse wheels whose axes do not point to the left: they would turn the other way."""
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    for name in (left, right):
        joint = compiled.joint(name)
        axis = data.xaxis[joint.id]
        if axis[1] < 0.999:
            raise ValueError(
                f"{where}: the axis of the joint {name} is "
                f"({axis[0]:.3g}, {axis[1]:.3g}, {axis[2]:.3g}) in the base's frame; must be "
                "(0, 1, 0), so that a positive torque drives forward along x"
            )


def _body_of(spec: Any, joint: str) -> str:
    return str(spec.joint(joint).parent.name)


def _prepare_shapes(
    where: str,
    spec: Any,
    compiled: Any,
    mujoco: Any,
    wheels: set[str],
    floor: float,
) -> float:
    """Set the shapes' friction; give the height of the lowest point of the wheels' shapes."""
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    lowest = np.inf
    for number in range(compiled.ngeom):
        name = compiled.body(int(compiled.geom_bodyid[number])).name
        if name in wheels:
            lowest = min(lowest, _lowest_point(compiled, data, mujoco, number))
    if not np.isfinite(lowest):
        raise ValueError(f"{where}: the wheels have no collision shapes to stand on")
    for body in spec.bodies:
        for geom in body.geoms:
            if geom.name.startswith(_CASTER):
                make_slippery(geom)
            elif body.name in wheels:
                geom.friction = [floor, 0.005, 0.0001]
            geom.solref = [CONTACT_TIME, 1.0]
    return float(lowest)


def _replace_wheels(where: str, spec: Any, mujoco: Any, sides: set[str], kind: str) -> None:
    """Put other shapes in the place of the wheels' cylinders.

    Raises
    ------
    ValueError
        A wheel has no cylinder.
    """
    types = mujoco.mjtGeom
    for name in sorted(sides):
        cylinders = [g for g in spec.body(name).geoms if g.type == types.mjGEOM_CYLINDER]
        if not cylinders:
            raise ValueError(
                f"{where}: wheels is {kind!r}, but the link {name} has no collision cylinder"
            )
        for geom in cylinders:
            shape, size = wheel_shape(kind, float(geom.size[0]), 2 * float(geom.size[1]))
            geom.type, geom.size = getattr(types, shape), size


def _lowest_point(compiled: Any, data: Any, mujoco: Any, geom: int) -> float:
    """Give the height of a shape's lowest point in the base's frame [m]."""
    kind = int(compiled.geom_type[geom])
    size = compiled.geom_size[geom]
    axis = data.geom_xmat[geom].reshape(3, 3)[2]
    place = float(data.geom_xpos[geom][2])
    types = mujoco.mjtGeom
    if kind == int(types.mjGEOM_SPHERE):
        return float(place - size[0])
    if kind == int(types.mjGEOM_CYLINDER):
        return float(place - size[0] * np.hypot(axis[0], axis[1]) - size[1] * abs(axis[2]))
    if kind == int(types.mjGEOM_CAPSULE):
        return float(place - size[0] - size[1] * abs(axis[2]))
    if kind == int(types.mjGEOM_ELLIPSOID):
        return float(place - np.linalg.norm(size * axis))
    if kind == int(types.mjGEOM_BOX):
        return float(place - np.abs(size * axis).sum())
    box = compiled.geom_aabb[geom]
    return float(place + axis @ box[:3] - np.abs(axis * box[3:]).sum())


def _measured(
    where: str, compiled: Any, mujoco: Any, joints: tuple[str, str], lowest: float
) -> Robot:
    """Give the Robot that a model is, about the middle of its axle."""
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    axle = [data.xanchor[compiled.joint(name).id] for name in joints]
    track = float(axle[0][1] - axle[1][1])
    if track <= 0:
        raise ValueError(
            f"{where}: the joint {joints[0]} is not to the left of {joints[1]}, along y"
        )
    middle = (axle[0] + axle[1]) / 2
    mass, inertia = 0.0, 0.0
    for body in range(1, compiled.nbody):
        own = float(compiled.body_mass[body])
        turn = data.ximat[body].reshape(3, 3)
        offset = data.xipos[body] - middle
        about = (turn * compiled.body_inertia[body]) @ turn.T
        mass += own
        inertia += float(about[2, 2]) + own * float(offset[0] ** 2 + offset[1] ** 2)
    return Robot(mass, inertia, track, float(middle[2] - lowest))


def _effort(root: ElementTree.Element, joint: str) -> float | None:
    """Give a joint's effort limit, if it has one."""
    for element in root.findall("joint"):
        if element.get("name") == joint:
            limit = element.find("limit")
            effort = float(limit.get("effort", "0")) if limit is not None else 0.0
            return effort if effort > 0 else None
    return None
