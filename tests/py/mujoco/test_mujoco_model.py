"""Models of robots in MuJoCo: their mass, their contacts, their friction, their text."""

import mujoco
import numpy as np
import pytest
from nfopidn import Robot
from nfopidn.mujoco import Bump, Caster, build_model

SMALL = Robot(mass=5.0, inertia=0.08, track_width=0.30, wheel_radius=0.033)


def compiled(model, step=0.002):
    spec = model.spec.copy()
    spec.option.timestep = step
    return spec.compile()


def settled(model, seconds=1.0, step=0.002):
    engine = compiled(model, step)
    data = mujoco.MjData(engine)
    mujoco.mj_step(engine, data, nstep=round(seconds / step))
    mujoco.mj_forward(engine, data)
    return engine, data


def mass_matrix(engine):
    """The whole inertia of the robot at its start: what MuJoCo moves, not what was asked for."""
    data = mujoco.MjData(engine)
    mujoco.mj_forward(engine, data)
    columns = []
    for place in range(engine.nv):
        unit = np.zeros(engine.nv)
        unit[place] = 1.0
        column = np.zeros(engine.nv)
        mujoco.mj_mulM(engine, data, column, unit)
        columns.append(column)
    return np.array(columns)


@pytest.mark.parametrize("wheels", ["ellipsoid", "cylinder", "sphere"])
@pytest.mark.parametrize(
    ("robot", "settings"),
    [
        (Robot.eddie(), {}),
        (Robot.eddie(), {"wheel_mass": 2.0, "armature": 0.01, "wheel_width": 0.06}),
        (SMALL, {"wheel_width": 0.02}),
    ],
)
def test_mass_and_yaw_inertia_are_the_robot_s(robot, wheels, settings):
    matrix = mass_matrix(compiled(build_model(robot, wheels, **settings)))
    np.testing.assert_allclose(np.diag(matrix)[:3], robot.mass, rtol=1e-12)
    assert matrix[5, 5] == pytest.approx(robot.inertia, rel=1e-12)
    # The centre of mass is on the axle: nothing couples moving and turning.
    np.testing.assert_allclose(matrix[:3, 3:], 0.0, atol=1e-12)
    mass = settings.get("wheel_mass", 0.01 * robot.mass)
    spin = mass * robot.wheel_radius**2 / 2
    rotor = settings.get("armature", 0.002 * robot.mass * robot.wheel_radius**2)
    np.testing.assert_allclose(np.diag(matrix)[6:], spin + rotor, rtol=1e-12)


def test_the_text_is_the_same_model():
    model = build_model(
        SMALL, "cylinder", joint_friction=0.02, torque_limit=0.5, slope=0.1, wheel_mass=0.3
    )
    read = mujoco.MjModel.from_xml_string(model.mjcf)
    own = compiled(model)
    # MuJoCo writes six digits.
    np.testing.assert_allclose(mass_matrix(read), mass_matrix(own), rtol=2e-6, atol=1e-15)
    for name in (
        "dof_frictionloss",
        "dof_solimp",
        "geom_condim",
        "geom_priority",
        "jnt_actfrcrange",
    ):
        np.testing.assert_allclose(getattr(read, name), getattr(own, name), rtol=1e-5)
    np.testing.assert_allclose(read.opt.gravity, own.opt.gravity, rtol=1e-5)
    assert read.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_AUTORESET
    assert read.opt.integrator == mujoco.mjtIntegrator.mjINT_EULER


@pytest.mark.parametrize(("wheels", "points"), [("ellipsoid", 1), ("sphere", 1), ("cylinder", 2)])
def test_contacts(wheels, points):
    """One or two points a wheel with friction, one a caster without; together the weight."""
    engine, data = settled(build_model(wheels=wheels))
    dims, load = {}, 0.0
    for number, contact in enumerate(data.contact):
        body = engine.body(engine.geom_bodyid[contact.geom2]).name
        dims.setdefault(body, []).append(contact.dim)
        force = np.zeros(6)
        mujoco.mj_contactForce(engine, data, number, force)
        load += force[0]
    assert dims == {"base": [1, 1], "left": [3] * points, "right": [3] * points}
    assert load == pytest.approx(11.5 * 9.81, rel=1e-4)


def coasting(caster_friction_matters):
    """How fast a robot on locked-out wheels still slides after a push along its axle."""
    robot = Robot.eddie()
    model = build_model(robot)
    for name in ("left", "right"):
        model.spec.geom(name).condim, model.spec.geom(name).priority = 1, 1
    if caster_friction_matters:
        for geom in model.spec.geoms:
            if geom.name.startswith("caster"):
                geom.priority = 0
    engine, data = settled(model)
    data.qvel[1] = 1.0
    mujoco.mj_step(engine, data, nstep=100)
    return data.qvel[1]


def test_casters_slide():
    """Without their priority the floor's friction would count."""
    assert coasting(False) == pytest.approx(1.0, abs=1e-6)
    assert coasting(True) < 0.8


def test_friction_holds_and_breaks_loose():
    """Half of the friction torque moves nothing; twice of it leaves half for the motion."""
    model = build_model(joint_friction=0.1)
    engine, data = settled(model)
    before = data.qpos[0]
    data.ctrl[:] = 0.05
    mujoco.mj_step(engine, data, nstep=1000)
    assert abs(data.qvel[6]) < 1e-3
    assert abs(data.qpos[0] - before) < 1e-4
    data.ctrl[:] = 0.2
    mujoco.mj_step(engine, data, nstep=500)
    effective = 11.5 * (1 + 0.01 + 0.004)
    assert data.qvel[0] == pytest.approx(2 * 0.1 / 0.076 / effective, rel=0.01)


def test_damping_is_each_joint_s():
    engine, data = settled(build_model(joint_damping=0.05))
    data.ctrl[:] = 0.1
    mujoco.mj_step(engine, data, nstep=60_000)
    np.testing.assert_allclose(data.qvel[6:8], 0.1 / 0.05, rtol=1e-3)


@pytest.mark.parametrize("wheels", ["ellipsoid", "cylinder"])
def test_a_parked_robot_stays(wheels):
    engine, data = settled(build_model(wheels=wheels, joint_friction=0.05), seconds=5.0)
    assert engine.nhfield == 0
    np.testing.assert_allclose(data.qpos[:2], 0.0, atol=1e-6)
    assert abs(data.qpos[6]) < 1e-7


@pytest.mark.parametrize(
    ("slope", "axis", "sign"), [(0.05, 0, -1.0), (-0.05, 0, 1.0), ((0.0, 0.05), 1, 0.0)]
)
def test_a_slope_pulls_downhill(slope, axis, sign):
    """Along it rolls back with g sin(slope); across it is held by the wheels."""
    engine, data = settled(build_model(slope=slope))
    np.testing.assert_allclose(np.linalg.norm(engine.opt.gravity), 9.81)
    expected = sign * 9.81 * np.sin(0.05) / (1 + 0.01 + 0.004)
    assert data.qvel[axis] == pytest.approx(expected, rel=0.01, abs=2e-3)


def test_a_bump_lifts_a_wheel():
    model = build_model(bumps=[Bump(0.4, -0.226, height=0.01, radius=0.1)])
    engine, data = settled(model)
    data.ctrl[:] = 0.2
    highest = 0.0
    for _ in range(1500):
        mujoco.mj_step(engine, data)
        right = data.body("right").xpos[2] - data.body("left").xpos[2]
        highest = max(highest, right)
    assert 0.006 < highest < 0.02


def test_soft_casters_leave_the_weight_to_the_wheels():
    def share(contact_time):
        balls = [Caster(x, contact_time=contact_time) for x in (0.17, -0.17)]
        engine, data = settled(build_model(casters=balls), seconds=3.0)
        wheels = 0.0
        for number, contact in enumerate(data.contact):
            if engine.geom(contact.geom2).name in ("left", "right"):
                force = np.zeros(6)
                mujoco.mj_contactForce(engine, data, number, force)
                wheels += force[0]
        return wheels / (11.5 * 9.81)

    assert 0.3 < share(0.02) < 0.4
    assert share(0.2) > 0.9


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"robot": 3}, "robot is 3; must be a Robot"),
        ({"wheels": "elipsoid"}, "did you mean 'ellipsoid'"),
        ({"wheel_width": 0.5}, "wheel_width is 0.5; must be above 0 and under the track, 0.452"),
        ({"wheel_width": 0.0}, "wheel_width is 0.0"),
        ({"robot": SMALL.replace(wheel_radius=0.16), "wheels": "sphere"}, "wider than the track"),
        ({"wheel_mass": -1.0}, r"wheel_mass is -1.0; must be in \[1.15e-05, 4.6\]"),
        ({"wheel_mass": 4.6, "robot": Robot(inertia=0.3)}, "wheels alone have 0.48"),
        ({"armature": np.nan}, "armature is nan"),
        ({"casters": "front"}, "casters is 'front'; must be a list of Caster"),
        ({"casters": [0.1]}, r"casters\[0\] is 0.1; must be a Caster\(x, y, radius"),
        ({"casters": [Caster(0.1, radius=0.08)]}, r"casters\[0\].radius is 0.08; .* not higher"),
        (
            {"casters": [Caster(0.1, clearance=0.01)]},
            r"clearance is 0.01; must be in \[0, 0.0038\]",
        ),
        ({"casters": [Caster(np.inf)]}, r"casters\[0\].x is inf"),
        ({"casters": [Caster(0.1, contact_time=0.0)]}, r"contact_time is 0.0"),
        ({"bumps": [Bump(0, 0, height=0.05)]}, r"bumps\[0\].height is 0.05"),
        ({"floor": 0.0}, "floor is 0.0"),
        ({"slope": 0.7}, r"slope is 0.7; must be an angle, or a pair, in \[-0.5, 0.5\]"),
        ({"slope": (0.0, "steep")}, r"slope\[1\] is 'steep'"),
        ({"joint_friction": -0.1}, "joint_friction is -0.1"),
        ({"joint_damping": "much"}, "joint_damping is 'much'"),
        ({"torque_limit": 0.0}, "torque_limit is 0.0"),
        ({"contact_time": 20.0}, "contact_time is 20.0"),
        ({"cone": "eliptic"}, "did you mean 'elliptic'"),
    ],
)
def test_what_cannot_be_is_refused(arguments, message):
    with pytest.raises(ValueError, match=message):
        build_model(**arguments)
