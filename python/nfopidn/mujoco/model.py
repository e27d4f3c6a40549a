"""A differential-drive robot as a MuJoCo model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from os import PathLike
from typing import Any

from nfopidn._core import Robot
from nfopidn.arguments import is_number, real_number, shown, suggestion
from nfopidn.mujoco.engine import load
from nfopidn.mujoco.parts import (
    CONTACT_TIME,
    WHEEL_KINDS,
    Bump,
    Caster,
    check_contact_time,
    checked_parts,
    default_casters,
)

#: Friction as a constraint that hardly creeps: impedance 0.9999 in place of 0.9.
FRICTION_IMPEDANCE = (0.9999, 0.9999, 0.001, 0.5, 2.0)
WHEEL_MASS_SHARE = 0.01
ARMATURE_SHARE = 0.002
CONES = {"pyramidal": "mjCONE_PYRAMIDAL", "elliptic": "mjCONE_ELLIPTIC"}
MOST_SLOPE = 0.5  # [rad]


@dataclass(frozen=True)
class Model:
    """A robot in MuJoCo, ready to be compiled and run.

    Attributes
    ----------
    spec
        The mujoco.MjSpec, to be edited further; `run` compiles a copy.
    robot
        The Robot that the model is: its mass and yaw inertia are those of body and wheels together.
    left, right
        Names of the wheels' joints, left and right as one sees them from behind (REP-103): the
        paper's left torque acts on the right one.
    body
        Name of the body that has the free joint.
    wheels
        "ellipsoid", "cylinder", "sphere", or "urdf".
    height
        Height of the body's frame at the start [m].
    """

    spec: Any
    robot: Robot
    left: str = "left"
    right: str = "right"
    body: str = "base"
    wheels: str = "ellipsoid"
    height: float = 0.0

    @property
    def mjcf(self) -> str:
        """The model as MJCF text, in which MuJoCo writes six digits of each number."""
        spec = self.spec.copy()
        spec.compile()
        return str(spec.to_xml())

    @staticmethod
    def from_urdf(
        path: str | PathLike[str],
        left: str,
        right: str,
        *,
        wheels: str | None = None,
        casters: Sequence[str] = (),
        floor: float = 1.0,
        joint_friction: float = 0.0,
        armature: float = 0.0,
        torque_limit: float | None = None,
    ) -> Model:
        """Read a robot of one's own from its URDF.

        In a URDF the base is bolted to the world and nothing drives the wheels: a free joint, two
        motors and a floor are added. Pictures (visual elements) are left out. The Robot is measured
        on the model: its mass, its yaw inertia about the middle of the axle, its track, and the
        wheels' radius as their height above the lowest point of the wheels' collision shapes.

        Parameters
        ----------
        path
            The URDF file.
        left, right
            Names of the wheels' joints, as one sees them from behind.
        wheels
            "ellipsoid" or "sphere" puts these in the place of the wheels' collision cylinders, of
            the same radius and width: one contact each, and no scrub. None leaves them as they are.
        casters
            Names of the links whose shapes slide on the floor without friction.
        floor
            Coefficient of sliding friction of wheels on the floor.
        joint_friction
            Coulomb friction of each wheel's joint [N m].
        armature
            Inertia of each motor's rotor, as seen at the wheel [kg m^2].
        torque_limit
            Of each motor [N m]; None: the joints' own effort limits, or the scenario's.

        Returns
        -------
        Model

        Raises
        ------
        ImportError
            MuJoCo is not installed.
        ValueError
            The file is no URDF, a joint or link is not in it, the wheels' axes are not along y,
            or a number out of range.
        """
        from nfopidn.mujoco.urdf import read_urdf

        return read_urdf(
            path,
            left,
            right,
            wheels=wheels,
            casters=casters,
            floor=floor,
            joint_friction=joint_friction,
            armature=armature,
            torque_limit=torque_limit,
        )


def build_model(
    robot: Robot | None = None,
    wheels: str = "ellipsoid",
    *,
    wheel_width: float = 0.03,
    wheel_mass: float | None = None,
    armature: float | None = None,
    casters: Sequence[Caster] | None = None,
    floor: float = 1.0,
    slope: float | tuple[float, float] = 0.0,
    bumps: Sequence[Bump] = (),
    joint_friction: float = 0.0,
    joint_damping: float = 0.0,
    torque_limit: float | None = None,
    contact_time: float = CONTACT_TIME,
    cone: str = "pyramidal",
) -> Model:
    """Make a MuJoCo model of a robot: body, two wheels, casters, motors, a plane floor.

    The whole has the Robot's mass and its yaw inertia. Each wheel is a solid disc of wheel_mass at
    half the track; the body has the rest of the mass, its centre of mass in the middle of the axle,
    and the rest of the yaw inertia. What the wheels' own spin and the motors' rotors add is not in
    the paper's equations: the effective mass grows by 2 (J + armature) / r^2, the effective yaw
    inertia by (J + armature) L^2 / (2 r^2), with J = wheel_mass r^2 / 2.

    Parameters
    ----------
    robot
        By default the paper's.
    wheels
        "ellipsoid" and "sphere" touch the floor at one point, as the paper's equations have it.
        "cylinder" touches it with both rims, which scrub in every turn.
    wheel_width
        Of an ellipsoid or a cylinder [m], less than the track.
    wheel_mass
        Of each wheel [kg]; None: a hundredth of the robot's.
    armature
        Inertia of each motor's rotor, as seen at the wheel [kg m^2]; None: 0.002 m r^2.
    casters
        Casters; None: one before and one behind, at 0.375 of the track. They slide without
        friction: condim 1 and a priority over the floor, without which MuJoCo would take the
        floor's.
    floor
        Coefficient of sliding friction of wheels on the floor, in [0.01, 10].
    slope
        Of the floor [rad]: rising along x, or a pair: along x and along y. Gravity is turned, so
        that x and y lie in the floor.
    bumps
        Bumps on the floor.
    joint_friction
        Coulomb friction of each wheel's joint [N m], with an impedance at which it holds instead of
        creeping.
    joint_damping
        Viscous friction of each wheel's joint [N m s/rad].
    torque_limit
        Of each motor [N m]; None: no other than the controller's.
    contact_time
        Time constant of the wheels' contacts, and of casters that are not given [s]; at least two
        steps of the engine. MuJoCo leaves the acceleration of a turning wheel's axle out of its
        constraints, so that in a turn a wheel slips outward by about v omega times this time, and
        no smaller step makes that less.
    cone
        Of friction: "pyramidal", as MuJoCo has it by default, or "elliptic", which is nearer to
        Coulomb's law. Wheels of one contact are the same under both; cylinders scrub twice as much
        under the latter.

    Returns
    -------
    Model
        spec is the mujoco.MjSpec, mjcf its text.

    Raises
    ------
    ImportError
        MuJoCo is not installed.
    ValueError
        An argument out of its range; wheels wider than the track allows or too heavy; a caster
        higher than the wheels.
    """
    robot = Robot.eddie() if robot is None else robot
    if not isinstance(robot, Robot):
        raise ValueError(f"robot is {robot!r}; must be a Robot")
    check_kind(wheels)
    mass, rotor = _wheel_numbers(robot, wheels, wheel_width, wheel_mass, armature)
    check_contact_time("contact_time", contact_time)
    balls = default_casters(robot, contact_time) if casters is None else casters
    balls = checked_parts("casters", Caster, balls, robot)
    bumps = checked_parts("bumps", Bump, bumps, robot)
    check_joints(floor, joint_friction, joint_damping, torque_limit)
    across = _wheel_inertia(robot, wheel_width, mass)[1]
    rest = robot.inertia - 2 * (mass * (robot.track_width / 2) ** 2 + across)
    if rest < 0.05 * robot.inertia:
        raise ValueError(
            f"wheel_mass is {mass:g} kg: the wheels alone have "
            f"{robot.inertia - rest:.4g} kg m^2 of the robot's yaw inertia, "
            f"{robot.inertia:g} kg m^2; at most 95 % of it can be theirs"
        )
    mujoco = load()
    spec = mujoco.MjSpec()
    prepare_options(spec, slope, cone)
    add_floor(spec, floor, contact_time, bumps)
    body = spec.worldbody.add_body(name="base", pos=[0, 0, robot.wheel_radius])
    body.add_freejoint(name="base")
    _set_inertia(body, robot.mass - 2 * mass, (0.6 * rest, 0.6 * rest, rest))
    for number, caster in enumerate(balls):
        place = [caster.x, caster.y, caster.radius + caster.clearance - robot.wheel_radius]
        ball = body.add_geom(
            name=f"caster{number + 1}",
            type=mujoco.mjtGeom.mjGEOM_SPHERE,
            size=[caster.radius, 0, 0],
            pos=place,
            mass=0,
            solref=[caster.contact_time, 1.0],
        )
        make_slippery(ball)
    half = robot.track_width / 2
    for side, y in (("left", half), ("right", -half)):
        wheel = body.add_body(name=side, pos=[0, y, 0])
        spin, other = _wheel_inertia(robot, wheel_width, mass)
        _set_inertia(wheel, mass, (other, spin, other))
        wheel.add_joint(name=side, axis=[0, 1, 0])
        shape, size = wheel_shape(wheels, robot.wheel_radius, wheel_width)
        wheel.add_geom(
            name=side,
            type=getattr(mujoco.mjtGeom, shape),
            size=size,
            quat=[math.sqrt(0.5), math.sqrt(0.5), 0, 0],
            mass=0,
            friction=[floor, 0.005, 0.0001],
            solref=[contact_time, 1.0],
        )
        drive_joint(spec, side, joint_friction, joint_damping, rotor, torque_limit)
    return Model(spec, robot, wheels=wheels, height=robot.wheel_radius)


def check_kind(wheels: Any) -> None:
    """Refuse an unknown kind of wheel.

    Raises
    ------
    ValueError
        Names those that there are.
    """
    if wheels not in WHEEL_KINDS:
        raise ValueError(
            f"wheels is {wheels!r}; must be one of {', '.join(WHEEL_KINDS)}"
            f"{suggestion(wheels, WHEEL_KINDS)}"
        )


def check_joints(floor: Any, joint_friction: Any, joint_damping: Any, torque_limit: Any) -> None:
    """Refuse numbers of floor and joints that are out of range.

    Raises
    ------
    ValueError
        Names the argument, its value and the range.
    """
    real_number("floor", floor, 0.01, 10.0, ", a coefficient of friction")
    real_number("joint_friction", joint_friction, 0.0, 1e3, " N m")
    real_number("joint_damping", joint_damping, 0.0, 1e3, " N m s/rad")
    if torque_limit is not None:
        real_number("torque_limit", torque_limit, 1e-6, 1e6, " N m")


def prepare_options(
    spec: Any, slope: float | tuple[float, float] = 0.0, cone: str = "pyramidal"
) -> None:
    """Set what every run needs: no restart after a divergence, the friction cones, gravity.

    The integrator is MuJoCo's semi-implicit Euler. Under its implicit ones wheels on servos skid.

    Raises
    ------
    ValueError
        The slope is out of range, or no such cone.
    """
    mujoco = load()
    if cone not in CONES:
        raise ValueError(
            f"cone is {shown(cone)}; must be one of {', '.join(CONES)}{suggestion(cone, CONES)}"
        )
    along, across = slope if isinstance(slope, tuple | list) and len(slope) == 2 else (slope, 0.0)
    for name, angle in (("slope", along), ("slope[1]", across)):
        if not is_number(angle) or not -MOST_SLOPE <= angle <= MOST_SLOPE:
            raise ValueError(
                f"{name} is {shown(angle)}; must be an angle, or a pair, in "
                f"[-{MOST_SLOPE:g}, {MOST_SLOPE:g}] rad"
            )
    option = spec.option
    option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    option.cone = getattr(mujoco.mjtCone, CONES[cone])
    option.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET
    g = 9.81
    down = math.sqrt(max(0.0, 1 - math.sin(along) ** 2 - math.sin(across) ** 2))
    option.gravity = [-g * math.sin(along), -g * math.sin(across), -g * down]


def add_floor(
    spec: Any, friction: float, contact_time: float = CONTACT_TIME, bumps: Sequence[Bump] = ()
) -> None:
    """Add a plane, and bumps; never a height field, which would steer a robot that stands still."""
    mujoco = load()
    sliding = [friction, 0.005, 0.0001]
    spec.worldbody.add_geom(
        name="floor",
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=[0, 0, 1],
        friction=sliding,
        solref=[contact_time, 1.0],
        rgba=[0.82, 0.84, 0.86, 1],
    )
    for number, bump in enumerate(bumps):
        spec.worldbody.add_geom(
            name=f"bump{number + 1}",
            type=mujoco.mjtGeom.mjGEOM_ELLIPSOID,
            size=[bump.radius, bump.radius, bump.height],
            pos=[bump.x, bump.y, 0],
            friction=sliding,
            solref=[contact_time, 1.0],
            rgba=[0.7, 0.55, 0.4, 1],
        )


def make_slippery(geom: Any) -> None:
    """Let a shape slide: without the priority the floor's friction would count."""
    geom.condim = 1
    geom.priority = 1


def drive_joint(
    spec: Any,
    name: str,
    friction: float,
    damping: float,
    armature: float,
    torque_limit: float | None,
) -> None:
    """Give a wheel's joint its friction, its rotor and its motor."""
    mujoco = load()
    joint = spec.joint(name)
    joint.frictionloss = friction
    joint.solimp_friction = list(FRICTION_IMPEDANCE)
    joint.damping = [damping, 0, 0]
    joint.armature = armature
    if torque_limit is not None:
        joint.actfrclimited = mujoco.mjtLimited.mjLIMITED_TRUE
        joint.actfrcrange = [-torque_limit, torque_limit]
    motor = spec.add_actuator(name=name, trntype=mujoco.mjtTrn.mjTRN_JOINT, target=name)
    motor.set_to_motor()


def _wheel_numbers(
    robot: Robot, wheels: str, width: Any, mass: Any, armature: Any
) -> tuple[float, float]:
    """Give mass and armature of a wheel, both checked, and check its width."""
    track = robot.track_width
    if not is_number(width) or not 0 < width < track:
        raise ValueError(
            f"wheel_width is {shown(width)}; must be above 0 and under the track, {track:g} m"
        )
    if wheels == "sphere" and 2 * robot.wheel_radius >= track:
        raise ValueError(
            f"wheels of {2 * robot.wheel_radius:g} m as spheres are wider than the track, "
            f"{track:g} m; take ellipsoid"
        )
    given = WHEEL_MASS_SHARE * robot.mass if mass is None else mass
    least, most = 1e-6 * robot.mass, 0.4 * robot.mass
    given = real_number("wheel_mass", given, least, most, " kg, 1e-6 to 0.4 of the robot's")
    scale = robot.mass * robot.wheel_radius**2
    rotor = ARMATURE_SHARE * scale if armature is None else armature
    return given, real_number("armature", rotor, 0.0, 10 * scale, " kg m^2")


def _wheel_inertia(robot: Robot, width: float, mass: float) -> tuple[float, float]:
    """Give a solid disc's moments of inertia: about its axle, and about a diameter."""
    square = robot.wheel_radius**2
    return mass * square / 2, mass * (3 * square + width**2) / 12


def _set_inertia(body: Any, mass: float, inertia: tuple[float, float, float]) -> None:
    """Set a body's inertia about its own frame.

    The place is given too: without it the model has the mass and its MJCF text has not.
    """
    body.mass = mass
    body.ipos = [0, 0, 0]
    body.iquat = [1, 0, 0, 0]
    body.inertia = list(inertia)
    body.explicitinertial = True


def wheel_shape(kind: str, radius: float, width: float) -> tuple[str, list[float]]:
    """Give MuJoCo's name of a wheel's shape, and its size along x, y and the axle."""
    if kind == "sphere":
        return "mjGEOM_SPHERE", [radius, 0, 0]
    if kind == "cylinder":
        return "mjGEOM_CYLINDER", [radius, width / 2, 0]
    return "mjGEOM_ELLIPSOID", [radius, radius, width / 2]
