"""Casters and bumps: what a model has besides the robot's body and wheels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from nfopidn._core import Robot
from nfopidn.arguments import is_number, real_number, shown

WHEEL_KINDS = ("ellipsoid", "cylinder", "sphere")
#: Time constant of the contacts [s], MuJoCo's own default.
CONTACT_TIME = 0.02
LONGEST_CONTACT_TIME = 10.0  # [s]
SHORTEST_CONTACT_TIME = 1e-4  # [s]


@dataclass(frozen=True)
class Caster:
    """A ball caster: a sphere without friction under the robot's body.

    Casters decide how much load the wheels have, and so how well these grip and how much wide ones
    scrub. Two wheels and two casters share the weight in a way that statics does not tell; MuJoCo
    shares it by its contacts' softness, whatever their places: two thirds of Eddie's weight lie on
    casters as hard as the wheels. A larger contact_time makes a caster softer; ten times that of
    the wheels leaves these nearly all of the weight.

    Attributes
    ----------
    x
        Place ahead of the axle [m], in the robot's frame.
    y
        Place to the left [m].
    radius
        Of the ball [m]; less than the wheels'.
    clearance
        Gap between ball and floor while the wheels stand on it [m], at most a twentieth of the
        wheels' radius.
    contact_time
        Time constant of the contact [s], in [1e-4, 10]; at least two steps of the engine.
    """

    x: float
    y: float = 0.0
    radius: float = 0.02
    clearance: float = 0.0
    contact_time: float = CONTACT_TIME

    def check(self, name: str, robot: Robot) -> None:
        """Refuse a caster that is not one of this robot.

        Raises
        ------
        ValueError
            Names the caster, its value and the range.
        """
        wheel = robot.wheel_radius
        for field, most in (("x", 100.0), ("y", 100.0)):
            real_number(f"{name}.{field}", getattr(self, field), -most, most, " m")
        if not is_number(self.radius) or not 0 < self.radius < wheel:
            raise ValueError(
                f"{name}.radius is {shown(self.radius)}; must be above 0 and under the wheels' "
                f"radius, {wheel:g} m: a caster is not higher than the wheels"
            )
        real_number(f"{name}.clearance", self.clearance, 0.0, wheel / 20, " m")
        check_contact_time(f"{name}.contact_time", self.contact_time)


@dataclass(frozen=True)
class Bump:
    """A smooth bump on the floor: the upper half of an ellipsoid.

    Attributes
    ----------
    x, y
        Where it is [m], in the world.
    height
        Of its top above the floor [m].
    radius
        Of its foot [m].
    """

    x: float
    y: float
    height: float = 0.005
    radius: float = 0.1

    def check(self, name: str, robot: Robot) -> None:
        """Refuse a bump that the wheels cannot take.

        Raises
        ------
        ValueError
            Names the bump, its value and the range.
        """
        real_number(f"{name}.x", self.x, -1e6, 1e6, " m")
        real_number(f"{name}.y", self.y, -1e6, 1e6, " m")
        real_number(f"{name}.height", self.height, 1e-6, robot.wheel_radius / 2, " m")
        real_number(f"{name}.radius", self.radius, 1e-3, 1e3, " m")


def check_contact_time(name: str, value: Any) -> None:
    """Refuse a time constant of a contact that is out of range.

    Raises
    ------
    ValueError
        Names it, its value and the range.
    """
    real_number(name, value, SHORTEST_CONTACT_TIME, LONGEST_CONTACT_TIME, " s")


def default_casters(robot: Robot, contact_time: float) -> tuple[Caster, ...]:
    """Give one caster before the axle and one behind it, at three quarters of half the track."""
    reach = 0.375 * robot.track_width
    radius = min(0.02, 0.5 * robot.wheel_radius)
    ball = Caster(reach, radius=radius, contact_time=contact_time)
    return ball, replace(ball, x=-reach)


def checked_parts(name: str, kind: type[Any], given: Any, robot: Robot) -> tuple[Any, ...]:
    """Give the casters or bumps of an argument.

    Raises
    ------
    ValueError
        No list, another type in it, or one that the robot cannot have.
    """
    if not isinstance(given, Sequence) or isinstance(given, str):
        raise ValueError(f"{name} is {given!r}; must be a list of {kind.__name__}")
    for place, part in enumerate(given):
        if not isinstance(part, kind):
            known = ", ".join(field.name for field in fields(kind))
            raise ValueError(f"{name}[{place}] is {part!r}; must be a {kind.__name__}({known})")
        part.check(f"{name}[{place}]", robot)
    return tuple(given)
