"""Robots of one's own, from URDF files."""

import mujoco
import numpy as np
import pytest
from nfopidn import Controller, Scenario, Trajectory
from nfopidn.mujoco import Model, run

WHEEL = """
  <link name="{side}_wheel"><inertial><mass value="0.4"/>
    <inertia ixx="0.0003" iyy="0.0005" izz="0.0003" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin rpy="1.5707963267948966 0 0"/>
      <geometry><cylinder radius="0.05" length="0.02"/></geometry></collision></link>
  <joint name="{side}" type="continuous"><parent link="base_link"/><child link="{side}_wheel"/>
    <origin xyz="0.02 {y} 0"/><axis xyz="{axis}"/>
    <limit effort="{effort}" velocity="20"/></joint>"""
ROBOT = """
<robot name="cart">
  <link name="base_footprint"/>
  <joint name="up" type="fixed"><parent link="base_footprint"/><child link="base_link"/>
    <origin xyz="0 0 0.05"/></joint>
  <link name="base_link">
    <visual><geometry><mesh filename="package://cart/nothing.dae"/></geometry></visual>
    <inertial><mass value="5"/><origin xyz="0.01 0 0.02"/>
      <inertia ixx="0.04" iyy="0.05" izz="0.06" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
  {wheels}
  <link name="caster"><inertial><mass value="0.05"/>
    <inertia ixx="1e-5" iyy="1e-5" izz="1e-5" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><sphere radius="0.02"/></geometry></collision></link>
  <joint name="rear" type="fixed"><parent link="base_link"/><child link="caster"/>
    <origin xyz="-0.12 0 -0.03"/></joint>
  <link name="nose"/>
  <joint name="front" type="fixed"><parent link="base_link"/><child link="nose"/></joint>
</robot>"""


def text(axis="0 1 0", effort="1.2", **changes):
    wheels = "".join(
        WHEEL.format(side=side, y=y, axis=axis, effort=effort)
        for side, y in (("left", 0.15), ("right", -0.15))
    )
    robot = ROBOT.format(wheels=wheels)
    for old, new in changes.items():
        robot = robot.replace(old, new)
    return robot


@pytest.fixture
def urdf(tmp_path):
    path = tmp_path / "cart.urdf"
    path.write_text(text())
    return path


def test_the_robot_is_measured(urdf):
    """Against sums by hand: mass, yaw inertia about the middle of the axle, track, radius."""
    model = Model.from_urdf(urdf, "left", "right", casters=["caster"])
    inertia = 0.06 + 5 * 0.01**2 + 2 * (0.0003 + 0.4 * 0.15**2) + 1e-5 + 0.05 * 0.14**2
    assert model.robot.mass == pytest.approx(5.85)
    assert model.robot.inertia == pytest.approx(inertia, rel=1e-9)
    assert model.robot.track_width == pytest.approx(0.3)
    assert model.robot.wheel_radius == pytest.approx(0.05)


def test_it_stands_and_is_free(urdf):
    """MuJoCo alone bolts it to the world and forgets five kilograms."""
    alone = mujoco.MjModel.from_xml_string(
        text()
        .replace('<visual><geometry><mesh filename="package://cart/nothing.dae"/>', "<visual>")
        .replace("<visual></geometry></visual>", "")
    )
    assert (alone.nv, alone.body_mass.sum()) == (2, pytest.approx(0.8))
    engine = Model.from_urdf(urdf, "left", "right", casters=["caster"]).spec.compile()
    assert (engine.nv, engine.nu) == (8, 2)
    assert engine.body_mass.sum() == pytest.approx(5.85)
    data = mujoco.MjData(engine)
    mujoco.mj_step(engine, data, nstep=1000)
    assert abs(data.qpos[2]) < 1e-3
    dims = sorted(contact.dim for contact in data.contact)
    assert dims == [1, 3, 3, 3, 3]


def test_it_drives_its_path(urdf):
    model = Model.from_urdf(urdf, "left", "right", wheels="ellipsoid", casters=["caster"])
    path = Trajectory.eight(period=40.0, dt=0.05, scale=0.5)
    scenario = Scenario(path, model.robot, torque_limit=1.2, rng=0)
    law = Controller.recommended(model.robot, 0.05, 1.2, path.peak_speed)
    assert run(scenario, law, model=model).metrics["position_rms"] < 0.04
    scrubbing = Model.from_urdf(urdf, "left", "right", casters=["caster"])
    assert run(scenario, law, model=scrubbing).metrics["position_rms"] > 0.1


def test_motors_have_the_file_s_limits_friction_and_rotors(urdf, tmp_path):
    model = Model.from_urdf(urdf, "left", "right", joint_friction=0.05, armature=0.002)
    engine = model.spec.compile()
    np.testing.assert_allclose(engine.jnt_actfrcrange[1:], [[-1.2, 1.2]] * 2)
    np.testing.assert_allclose(engine.dof_frictionloss[6:], 0.05)
    np.testing.assert_allclose(engine.dof_armature[6:], 0.002)
    limited = Model.from_urdf(urdf, "left", "right", torque_limit=0.3).spec.compile()
    np.testing.assert_allclose(limited.jnt_actfrcrange[1:], [[-0.3, 0.3]] * 2)
    free = tmp_path / "free.urdf"
    free.write_text(text(effort="0"))
    assert not any(Model.from_urdf(free, "left", "right").spec.compile().jnt_actfrclimited)


@pytest.mark.parametrize(
    ("content", "arguments", "message"),
    [
        ("<robot", {}, "is no XML"),
        ("<sdf/>", {}, "is no URDF: its root is <sdf>"),
        (text(), {"left": "lefft"}, "left is 'lefft'; is no joint of it .did you mean 'left'"),
        (text(), {"right": "left"}, "left and right are both 'left'"),
        (text(), {"left": "right", "right": "left"}, "right is not to the left of left"),
        (text(), {"casters": ["ball"]}, "casters is 'ball'; is no link of it"),
        (text(), {"casters": "caster"}, "casters is 'caster'; must be a list"),
        (text(), {"casters": ["nose"]}, "the caster nose has no collision shape"),
        (text(), {"left": "rear"}, "the joint rear is fixed; a wheel's is continuous"),
        (text(axis="0 0 1"), {}, r"axis of the joint left is \(0, 0, 1\)"),
        (text(axis="0 -1 0"), {}, r"axis of the joint left is \(0, -1, 0\)"),
        (text(), {"floor": -1.0}, "floor is -1.0"),
        (text(), {"armature": -1.0}, "armature is -1.0"),
        (text(), {"wheels": "square"}, "wheels is 'square'"),
        (text(**{'<cylinder radius="0.05" length="0.02"/>': '<sphere radius="0.05"/>'}),
         {"wheels": "ellipsoid"}, "has no collision cylinder"),
        (text(**{'<cylinder radius="0.05" length="0.02"/>':
                 '<mesh filename="package://cart/wheel.stl"/>'}),
         {}, "found by ROS alone"),
        (text(**{'<cylinder radius="0.05" length="0.02"/>': '<mesh filename="wheel.stl"/>'}),
         {}, "MuJoCo reads no robot in it"),
        (text(**{"</robot>": '<link name="other"/></robot>'}), {}, "has 2 root links"),
    ],
)  # fmt: skip
def test_bad_files_are_refused(tmp_path, content, arguments, message):
    path = tmp_path / "bad.urdf"
    path.write_text(content)
    words = {"left": "left", "right": "right"} | arguments
    with pytest.raises(ValueError, match=message) as caught:
        Model.from_urdf(path, words.pop("left"), words.pop("right"), **words)
    if "is -1.0" not in message and "is 'square'" not in message and "list" not in message:
        assert str(path) in str(caught.value)


def test_a_missing_file_is_told(tmp_path):
    with pytest.raises((OSError, ValueError), match=r"nowhere\.urdf"):
        Model.from_urdf(tmp_path / "nowhere.urdf", "left", "right")
