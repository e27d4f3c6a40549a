"""MCAP files, with ROS 2's messages or Foxglove's schemas."""

from __future__ import annotations

import json
import os
from io import BytesIO
from typing import Any, Literal

import numpy as np

from nfopidn import _core
from nfopidn._core import SimulationResult, Trajectory
from nfopidn.arguments import real_number
from nfopidn.formats.log import Poses, extra, poses_of

_NANO = 10**9
_POSE_IN_FRAME = {
    "title": "foxglove.PoseInFrame",
    "type": "object",
    "properties": {
        "timestamp": {
            "type": "object",
            "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
        },
        "frame_id": {"type": "string"},
        "pose": {
            "type": "object",
            "properties": {
                "position": {
                    "type": "object",
                    "properties": {name: {"type": "number"} for name in "xyz"},
                },
                "orientation": {
                    "type": "object",
                    "properties": {name: {"type": "number"} for name in "xyzw"},
                },
            },
        },
    },
}


def _split(stamp: int) -> tuple[int, int]:
    return stamp // _NANO, stamp % _NANO


class _Foxglove:
    """JSON messages of foxglove.PoseInFrame."""

    profile = ""
    encoding = "json"
    schema_encoding = "jsonschema"
    schema = "foxglove.PoseInFrame"

    def definition(self) -> bytes:
        return json.dumps(_POSE_IN_FRAME).encode()

    def message(self, stamp: int, frame: str, poses: Poses, k: int) -> bytes:
        seconds, rest = _split(stamp)
        half = 0.5 * float(poses.theta[k])
        return json.dumps(
            {
                "timestamp": {"sec": seconds, "nsec": rest},
                "frame_id": frame,
                "pose": {
                    "position": {"x": float(poses.x[k]), "y": float(poses.y[k]), "z": 0.0},
                    "orientation": {
                        "x": 0.0,
                        "y": 0.0,
                        "z": float(np.sin(half)),
                        "w": float(np.cos(half)),
                    },
                },
            },
            allow_nan=False,
        ).encode()


class _Ros2:
    """CDR messages of nav_msgs/msg/Odometry."""

    profile = "ros2"
    encoding = "cdr"
    schema_encoding = "ros2msg"
    schema = "nav_msgs/msg/Odometry"

    def __init__(self, child: str) -> None:
        typesys = extra("rosbags.typesys", "write_mcap with schema='ros2'")
        self._store: Any = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
        self._child = child

    def definition(self) -> bytes:
        text: str = self._store.generate_msgdef(self.schema, ros_version=2)[0]
        return text.encode()

    def message(self, stamp: int, frame: str, poses: Poses, k: int) -> bytes:
        types = self._store.types
        seconds, rest = _split(stamp)
        half = 0.5 * float(poses.theta[k])

        def vector(x: float, z: float) -> Any:
            return types["geometry_msgs/msg/Vector3"](x=x, y=0.0, z=z)

        header = types["std_msgs/msg/Header"](
            stamp=types["builtin_interfaces/msg/Time"](sec=seconds, nanosec=rest), frame_id=frame
        )
        pose = types["geometry_msgs/msg/Pose"](
            position=types["geometry_msgs/msg/Point"](
                x=float(poses.x[k]), y=float(poses.y[k]), z=0.0
            ),
            orientation=types["geometry_msgs/msg/Quaternion"](
                x=0.0, y=0.0, z=float(np.sin(half)), w=float(np.cos(half))
            ),
        )
        twist = types["geometry_msgs/msg/Twist"](
            linear=vector(float(poses.v[k]), 0.0), angular=vector(0.0, float(poses.omega[k]))
        )
        odometry = types[self.schema](
            header=header,
            child_frame_id=self._child,
            pose=types["geometry_msgs/msg/PoseWithCovariance"](pose=pose, covariance=np.zeros(36)),
            twist=types["geometry_msgs/msg/TwistWithCovariance"](
                twist=twist, covariance=np.zeros(36)
            ),
        )
        return bytes(self._store.serialize_cdr(odometry, self.schema))


def write_mcap(
    source: Trajectory | SimulationResult,
    path: str | os.PathLike[str],
    *,
    schema: Literal["ros2", "foxglove"] = "ros2",
    topic: str | None = None,
    frame: str = "odom",
    child_frame: str = "base_link",
    start: float = 0.0,
) -> None:
    """Write the poses of a trajectory, or of a run and its reference, as an MCAP file.

    With "ros2" the messages are nav_msgs/Odometry with the twist in the robot's frame, with
    "foxglove" foxglove.PoseInFrame as JSON. The log time is the message's own. Needs the extra
    `formats`.

    Parameters
    ----------
    source
        a Trajectory, written to `/reference`, or a SimulationResult, written to `/odom` with its
        reference on `/reference`.
    path
        of the file.
    schema
        of the messages.
    topic
        instead of `/reference` or, of a run, `/odom`.
    frame, child_frame
        names of the frames.
    start
        added to the stamps [s].

    Raises
    ------
    ValueError
        The argument at fault.
    ImportError
        mcap or rosbags is not installed.
    """
    if schema not in ("ros2", "foxglove"):
        raise ValueError(f"schema is {schema!r}; must be 'ros2' or 'foxglove'")
    start = real_number("start", start, 0.0, 4e9, " s")  # what ROS 2's stamps hold, nearly
    writer_module = extra("mcap.writer", "write_mcap")
    kind: _Ros2 | _Foxglove = _Ros2(child_frame) if schema == "ros2" else _Foxglove()
    series = {}
    if isinstance(source, SimulationResult):
        series[topic or "/odom"] = poses_of(source)
        series["/reference"] = poses_of(source, reference=True)
    else:
        series[topic or "/reference"] = poses_of(source)
    stream = BytesIO()
    writer = writer_module.Writer(stream, compression=writer_module.CompressionType.NONE)
    writer.start(profile=kind.profile, library="nfopidn")
    identifier = writer.register_schema(kind.schema, kind.schema_encoding, kind.definition())
    channels = {
        name: writer.register_channel(
            topic=name, message_encoding=kind.encoding, schema_id=identifier
        )
        for name in series
    }
    base = round(start * _NANO)
    longest = max(len(poses.t) for poses in series.values())
    for k in range(longest):
        for name, poses in series.items():
            if k >= len(poses.t):
                continue
            stamp = base + round(float(poses.t[k]) * _NANO)
            writer.add_message(
                channel_id=channels[name],
                log_time=stamp,
                publish_time=stamp,
                sequence=k,
                data=kind.message(stamp, frame, poses, k),
            )
    writer.finish()
    _core.write_file(path, stream.getvalue())
