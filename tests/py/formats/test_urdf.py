"""A differential drive's numbers from its URDF."""

import pytest
from nfopidn import formats

pytest.importorskip("yourdfpy")


def wheel(side, y, radius=0.05, kind="continuous"):
    return f"""
    <link name="{side}_wheel">
      <inertial><mass value="0.5"/>
        <inertia ixx="0.001" iyy="0.002" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>
      <collision><geometry><cylinder radius="{radius}" length="0.02"/></geometry></collision>
    </link>
    <joint name="{side}_joint" type="{kind}"><parent link="base_link"/><child link="{side}_wheel"/>
      <origin xyz="0 {y} 0" rpy="-1.5707963267948966 0 0"/><axis xyz="0 0 1"/></joint>"""


BODY = """
  <link name="base_footprint"/>
  <joint name="base_joint" type="fixed"><parent link="base_footprint"/><child link="base_link"/>
    <origin xyz="0 0 0.05"/></joint>
  <link name="base_link"><inertial><origin xyz="0.1 0 0.1"/><mass value="9"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="caster"/>
  <joint name="caster_joint" type="continuous"><parent link="base_link"/><child link="caster"/>
    <origin xyz="-0.1 0 0"/><axis xyz="0 0 1"/></joint>"""


def written(tmp_path, *parts):
    path = tmp_path / "robot.urdf"
    path.write_text(f'<?xml version="1.0"?><robot name="r">{BODY}{"".join(parts)}</robot>')
    return path


def test_a_robot(tmp_path):
    path = written(tmp_path, wheel("right", -0.2), wheel("left", 0.2))
    found = formats.read_urdf(path)
    robot = found.robot
    assert found.wheels == ("left_joint", "right_joint")
    assert robot.track_width == pytest.approx(0.4)
    assert robot.wheel_radius == 0.05
    assert robot.mass == pytest.approx(10)
    # Of the body 0.3 and 9 * 0.1^2; of each wheel, which lies on its side, iyy and 0.5 * 0.2^2.
    assert robot.inertia == pytest.approx(0.3 + 0.09 + 2 * (0.002 + 0.02))
    assert found.center_of_mass == pytest.approx((0.09, 0))
    assert "without mass: base_footprint, caster" in found.notes
    assert "the centre of mass lies 0.09 m ahead" in found.notes[-1]


def test_wheels_are_asked_for(tmp_path):
    path = written(tmp_path, wheel("a", 0.2), wheel("b", -0.2), wheel("c", 0.1))
    with pytest.raises(ValueError, match=r"wheels says which two .* caster_joint, a_joint, b_j"):
        formats.read_urdf(path)
    assert formats.read_urdf(path, wheels=("b_joint", "a_joint")).wheels == ("a_joint", "b_joint")
    with pytest.raises(ValueError, match=r"no joint 'a_joynt' \(did you mean 'a_joint'\?\)"):
        formats.read_urdf(path, wheels=("a_joynt", "b_joint"))
    with pytest.raises(ValueError, match="must be two joints"):
        formats.read_urdf(path, wheels=("a_joint",))


def test_a_radius_is_asked_for(tmp_path):
    bare = wheel("left", 0.2).replace(
        '<cylinder radius="0.05" length="0.02"/>', '<box size="1 1 1"/>'
    )
    path = written(tmp_path, bare, wheel("right", -0.2))
    with pytest.raises(ValueError, match="link left_wheel has neither a cylinder nor a sphere"):
        formats.read_urdf(path)
    assert formats.read_urdf(path, wheel_radius=0.06).robot.wheel_radius == 0.06
    uneven = written(tmp_path, wheel("left", 0.2, radius=0.06), wheel("right", -0.2))
    found = formats.read_urdf(uneven)
    assert found.robot.wheel_radius == pytest.approx(0.055)
    assert any("radii differ" in note for note in found.notes)


def test_a_mass_without_inertia_is_told(tmp_path):
    bare = '<link name="box"><inertial><mass value="1"/></inertial></link>'
    rough = (
        bare.replace("box", "caster_back")
        .replace('"1"', '"0.005"')
        .replace(
            "</inertial>",
            '<inertia ixx="1" iyy="1" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial>',
        )
    )
    joint = '<joint name="j" type="fixed"><parent link="base_link"/><child link="box"/></joint>'
    second = joint.replace('"j"', '"k"').replace("box", "caster_back")
    wheels = wheel("right", -0.2) + wheel("left", 0.2)
    path = written(tmp_path, wheels, bare, joint, rough, second)
    found = formats.read_urdf(path)
    assert found.robot.mass == pytest.approx(11.005)
    assert any("caster_back, 0.001 kg m^2 for 0.005 kg, is that" in note for note in found.notes)
    assert "with a mass but no inertia of their own: box" in found.notes


def test_no_urdf(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text("no xml")
    with pytest.raises(ValueError, match="not a URDF"):
        formats.read_urdf(path)
    with pytest.raises(FileNotFoundError):
        formats.read_urdf(tmp_path / "none.urdf")
