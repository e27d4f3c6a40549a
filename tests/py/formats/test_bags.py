"""Bags of ROS 1 and ROS 2, and MCAP, written by rosbags and mcap and read back by either."""

import json
from math import pi

import numpy as np
import pytest
from nfopidn import Scenario, Trajectory, formats, simulate

rosbag1 = pytest.importorskip("rosbags.rosbag1")
rosbag2 = pytest.importorskip("rosbags.rosbag2")
typesys = pytest.importorskip("rosbags.typesys")

ROS1 = typesys.get_typestore(typesys.Stores.ROS1_NOETIC)
ROS1.register(
    typesys.get_types_from_msg(
        "geometry_msgs/TransformStamped[] transforms", "tf2_msgs/msg/TFMessage"
    )
)
ROS2 = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
COUNT = 30
START = 1_700_000_000 * 10**9
T = 0.05 * np.arange(COUNT)
ANGLE = 0.4 * T
X, Y, THETA = 2 * np.cos(ANGLE), 2 * np.sin(ANGLE), ANGLE + pi / 2
KINDS = {
    "odometry": "nav_msgs/msg/Odometry",
    "pose": "geometry_msgs/msg/PoseStamped",
    "covariance": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "path": "nav_msgs/msg/Path",
    "tf": "tf2_msgs/msg/TFMessage",
}


class Messages:
    """Messages of a robot on a circle, with a store's types."""

    def __init__(self, store):
        self.store = store
        self.is1 = store is ROS1

    def make(self, name, **fields):
        return self.store.types[name](**fields)

    def header(self, stamp, frame="odom"):
        time = self.make("builtin_interfaces/msg/Time", sec=stamp // 10**9, nanosec=stamp % 10**9)
        more = {"seq": 0} if self.is1 else {}
        return self.make("std_msgs/msg/Header", stamp=time, frame_id=frame, **more)

    def pose(self, k):
        point = self.make("geometry_msgs/msg/Point", x=X[k], y=Y[k], z=0.0)
        half = THETA[k] / 2
        turn = self.make(
            "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=np.sin(half), w=np.cos(half)
        )
        return self.make("geometry_msgs/msg/Pose", position=point, orientation=turn)

    def vector(self, x=0.0, y=0.0, z=0.0):
        return self.make("geometry_msgs/msg/Vector3", x=x, y=y, z=z)

    def message(self, kind, k, stamp, lateral=0.0):
        header, pose = self.header(stamp), self.pose(k)
        if kind == "pose":
            return self.make(KINDS[kind], header=header, pose=pose)
        with_covariance = self.make(
            "geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=np.zeros(36)
        )
        if kind == "covariance":
            return self.make(KINDS[kind], header=header, pose=with_covariance)
        if kind == "path":
            stamped = [self.message("pose", i, stamp + i * 50_000_000) for i in range(COUNT)]
            return self.make(KINDS[kind], header=header, poses=stamped)
        if kind == "tf":
            moved = self.make(
                "geometry_msgs/msg/Transform",
                translation=self.vector(X[k], Y[k]),
                rotation=pose.orientation,
            )
            name = "geometry_msgs/msg/TransformStamped"
            one = self.make(name, header=header, child_frame_id="base_link", transform=moved)
            still = self.make(name, header=header, child_frame_id="laser", transform=moved)
            return self.make(KINDS[kind], transforms=[one, still])
        twist = self.make(
            "geometry_msgs/msg/Twist",
            linear=self.vector(0.8, lateral),
            angular=self.vector(z=0.4),
        )
        with_twist = self.make(
            "geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=np.zeros(36)
        )
        return self.make(
            KINDS[kind],
            header=header,
            child_frame_id="base_link",
            pose=with_covariance,
            twist=with_twist,
        )


def write(path, kinds, *, storage="sqlite3", stamp=START, delay=3_000_000, **settings):
    """A bag with a topic a kind, recorded `delay` ns after the stamps; `ros1`: of ROS 1."""
    ros1 = storage == "ros1"
    messages = Messages(ROS1 if ros1 else ROS2)
    if ros1:
        writer = rosbag1.Writer(path)
    else:
        plugin = rosbag2.StoragePlugin[storage.upper()]
        writer = rosbag2.Writer(path, version=9, storage_plugin=plugin)
    store = messages.store
    with writer:
        for topic, kind in kinds.items():
            name = KINDS[kind]
            connection = writer.add_connection(topic, name, typestore=store)
            serialise = store.serialize_ros1 if ros1 else store.serialize_cdr
            for k in range(1 if kind == "path" else COUNT):
                at = 0 if stamp == 0 else stamp + k * 50_000_000
                message = messages.message(kind, k, at, **settings)
                writer.write(connection, START + k * 50_000_000 + delay, serialise(message, name))
    return path


@pytest.mark.parametrize("storage", ["ros1", "sqlite3", "mcap"])
@pytest.mark.parametrize("kind", KINDS)
def test_bags(storage, kind, tmp_path):
    path = write(tmp_path / "run.bag", {"/topic": kind}, storage=storage)
    choice = {"child_frame": "base_link"} if kind == "tf" else {}
    log = formats.read_bag(path, **choice)
    np.testing.assert_allclose(log.t, T, atol=1e-9)
    np.testing.assert_allclose(log.x, X)
    np.testing.assert_allclose(log.y, Y)
    np.testing.assert_allclose(log.theta, THETA, atol=1e-12)
    assert log.start == pytest.approx(START * 1e-9)
    if kind == "odometry":
        assert set(log.v) == {0.8}
        assert set(log.omega) == {0.4}
    if kind not in ("path", "tf"):
        assert "recorded 0.003 s after their stamps" in log.notes[2]
    made = log.trajectory(dt=0.05)
    np.testing.assert_allclose(made.v[1:-1], 0.8, rtol=1e-3)


def test_a_file_of_a_bag(tmp_path):
    write(tmp_path / "run", {"/topic": "pose"}, storage="mcap")
    assert len(formats.read_bag(tmp_path / "run" / "run.mcap")) == COUNT


def test_topics_are_listed(tmp_path):
    path = write(tmp_path / "run", {"/odom": "odometry", "/amcl_pose": "covariance"})
    with pytest.raises(ValueError, match=r"no topic '/odm' \(did you mean '/odom'\?\); there are"):
        formats.read_bag(path, "/odm")
    both = r"topic says which of /amcl_pose \(geometry_msgs/PoseWith\w+\), /odom \(nav_msgs/Odom"
    with pytest.raises(ValueError, match=both):
        formats.read_bag(path)
    assert len(formats.read_bag(path, "/odom")) == COUNT
    other = tmp_path / "other"
    with rosbag2.Writer(other, version=9) as writer:
        name = "std_msgs/msg/String"
        connection = writer.add_connection("/chatter", name, typestore=ROS2)
        writer.write(connection, 1, ROS2.serialize_cdr(ROS2.types[name](data="hello"), name))
    with pytest.raises(ValueError, match=r"no topic with poses .* there are /chatter \(std_msgs/S"):
        formats.read_bag(other)
    with pytest.raises(ValueError, match=r"topic /chatter is of std_msgs/String; must be one of"):
        formats.read_bag(other, "/chatter")


def test_frames_of_tf_are_listed(tmp_path):
    path = write(tmp_path / "run", {"/tf": "tf"})
    with pytest.raises(
        ValueError, match="child_frame says which of odom -> base_link, odom -> las"
    ):
        formats.read_bag(path)
    with pytest.raises(ValueError, match="child_frame says which"):
        formats.read_bag(path, child_frame="wheel")


def test_two_clocks_are_told(tmp_path):
    """Headers of a simulation's clock: theirs is used, and the log's on demand."""
    path = write(tmp_path / "run", {"/odom": "odometry"}, stamp=5 * 10**9)
    log = formats.read_bag(path)
    assert log.start == 5.0
    assert "headers and log are of two clocks" in log.notes[3]
    by_log = formats.read_bag(path, stamps="log")
    assert by_log.start == pytest.approx(1.7e9)
    np.testing.assert_allclose(by_log.t, T, atol=1e-9)


def test_stamps_of_zero_are_refused(tmp_path):
    path = write(tmp_path / "run", {"/odom": "odometry"}, stamp=0)
    with pytest.raises(ValueError, match=r"header stamps of 30 messages are 0; stamps='log'"):
        formats.read_bag(path)
    np.testing.assert_allclose(formats.read_bag(path, stamps="log").t, T, atol=1e-9)
    with pytest.raises(ValueError, match="stamps is 'wall'"):
        formats.read_bag(path, stamps="wall")


def test_a_twist_in_the_world_s_frame_is_told(tmp_path):
    path = write(tmp_path / "run", {"/odom": "odometry"}, lateral=0.4)
    assert "a twist in the world's frame?" in " ".join(formats.read_bag(path).notes)


def test_no_bag(tmp_path):
    with pytest.raises(FileNotFoundError, match="no such file"):
        formats.read_bag(tmp_path / "none")
    (tmp_path / "run.bag").write_text("no bag")
    with pytest.raises(ValueError, match=r"run.bag: "):
        formats.read_bag(tmp_path / "run.bag")


@pytest.fixture
def run():
    path = Trajectory.eight(period=20, dt=0.1)
    far = Trajectory.from_samples(path.x, path.y, 0.1, origin=(1000, 2000))
    return simulate(Scenario(far, rng=0))


def test_mcap_is_ros_2_s(run, tmp_path):
    formats.write_mcap(run, tmp_path / "run.mcap", start=1.7e9)
    log = formats.read_bag(tmp_path / "run.mcap", "/odom")
    np.testing.assert_array_equal(log.x, run.columns["x"] + 1000)
    np.testing.assert_array_equal(log.v, run.columns["v"])
    np.testing.assert_allclose(log.t, run.columns["t"], atol=1e-9)
    assert "recorded 0 s after their stamps" in log.notes[2]
    reference = formats.read_bag(tmp_path / "run.mcap", "/reference")
    np.testing.assert_array_equal(reference.y, run.columns["y_ref"] + 2000)


def test_whole_numbers_are_floats(tmp_path):
    """Which rosbags would write as 5e-324 in arrays."""
    line = Trajectory.from_samples([0, 1, 2, 3], [0, 0, 0, 0], 1.0)
    formats.write_mcap(line, tmp_path / "line.mcap")
    log = formats.read_bag(tmp_path / "line.mcap")
    assert log.x.tolist() == [0, 1, 2, 3]
    assert log.v.tolist() == [1, 1, 1, 1]


def test_mcap_is_foxglove_s(run, tmp_path):
    reader = pytest.importorskip("mcap.reader")
    formats.write_mcap(run, tmp_path / "run.mcap", schema="foxglove", topic="/robot", frame="map")
    with open(tmp_path / "run.mcap", "rb") as file:
        found = [
            (schema.name, channel.topic, message.log_time, message.publish_time, message.data)
            for schema, channel, message in reader.make_reader(file).iter_messages("/robot")
        ]
    assert len(found) == len(run.columns["t"])
    for k, (schema, _, logged, published, data) in enumerate(found):
        message = json.loads(data)
        stamp = message["timestamp"]["sec"] * 10**9 + message["timestamp"]["nsec"]
        assert schema == "foxglove.PoseInFrame"
        assert stamp == logged == published == round(run.columns["t"][k] * 1e9)
        assert message["pose"]["position"]["x"] == run.columns["x"][k] + 1000
        assert message["frame_id"] == "map"


def test_bad_mcap_is_refused(run, tmp_path):
    with pytest.raises(ValueError, match="schema is 'ros1'"):
        formats.write_mcap(run, tmp_path / "run.mcap", schema="ros1")
    with pytest.raises(ValueError, match=r"start is -1; must be in"):
        formats.write_mcap(run, tmp_path / "run.mcap", start=-1)


@pytest.mark.parametrize(
    ("package", "call"),
    [
        ("rosbags.highlevel", formats.read_bag),
        ("mcap.writer", lambda path: formats.write_mcap(Trajectory.circle(), path)),
        ("yourdfpy", formats.read_urdf),
    ],
)
def test_a_missing_extra_says_how_to_get_it(package, call, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, package, None)
    (tmp_path / "file").write_text("")
    name = package.split(".")[0]
    with pytest.raises(ImportError, match=rf"needs {name}: pip install 'nfopidn\[formats\]'"):
        call(tmp_path / "file")
