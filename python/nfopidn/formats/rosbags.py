"""Bags of ROS 1 and ROS 2, and MCAP files with ROS messages, by rosbags."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from nfopidn.arguments import suggestion
from nfopidn.formats.log import Array, Log, extra
from nfopidn.formats.rotation import yaw_of

#: What is read, by the type's name without "msg".
TYPES = (
    "nav_msgs/Odometry",
    "nav_msgs/Path",
    "geometry_msgs/PoseStamped",
    "geometry_msgs/PoseWithCovarianceStamped",
    "tf2_msgs/TFMessage",
    "tf/tfMessage",
)
_TRANSFORMS = ("tf2_msgs/TFMessage", "tf/tfMessage")
_NANO = 10**9
#: Header and log stamps of one clock differ by a delay that hardly changes [s].
_ONE_CLOCK = 1.0


def _short(name: str) -> str:
    return name.replace("/msg/", "/")


@dataclass
class _Rows:
    """What messages say, in lists."""

    stamp: list[int] = field(default_factory=list)
    logged: list[int] = field(default_factory=list)
    pose: list[tuple[float, ...]] = field(default_factory=list)
    twist: list[tuple[float, float, float]] = field(default_factory=list)
    frames: Counter[str] = field(default_factory=Counter)

    def add(self, header: Any, logged: int, position: Any, turned: Any) -> None:
        self.stamp.append(header.stamp.sec * _NANO + header.stamp.nanosec)
        self.logged.append(logged)
        self.pose.append((position.x, position.y, turned.x, turned.y, turned.z, turned.w))
        self.frames[header.frame_id] += 1


def _listed(topics: dict[str, str]) -> str:
    return ", ".join(f"{name} ({_short(kind)})" for name, kind in sorted(topics.items()))


def _files(path: Path) -> list[Path]:
    """Return what rosbags reads: it takes a folder of ROS 2 that is called *.bag for ROS 1."""
    if path.is_dir() and path.suffix == ".bag":
        return sorted([*path.glob("*.db3"), *path.glob("*.mcap")]) or [path]
    return [path]


def _chosen(where: str, topics: dict[str, str], topic: str | None) -> str:
    """Return the topic that is asked for, or the only one that can be read."""
    if topic is not None:
        if topic not in topics:
            raise ValueError(
                f"{where}: no topic {topic!r}{suggestion(topic, topics)}; there are "
                f"{_listed(topics) or 'none'}"
            )
        if _short(topics[topic]) not in TYPES:
            raise ValueError(
                f"{where}: topic {topic} is of {_short(topics[topic])}; must be one of "
                f"{', '.join(TYPES)}"
            )
        return topic
    able = {name: kind for name, kind in topics.items() if _short(kind) in TYPES}
    if len(able) == 1:
        return next(iter(able))
    if not able:
        raise ValueError(
            f"{where}: no topic with poses ({', '.join(TYPES)}); there are "
            f"{_listed(topics) or 'none'}"
        )
    raise ValueError(f"{where}: topic says which of {_listed(able)}")


def _transforms(message: Any, child: str | None, found: Counter[str]) -> Iterator[Any]:
    for one in message.transforms:
        pair = f"{one.header.frame_id} -> {one.child_frame_id}"
        found[pair] += 1
        if child is None or one.child_frame_id.lstrip("/") == child.lstrip("/"):
            yield one


def _messages(reader: Any, name: str, kind: str, child: str | None, where: str) -> _Rows:
    rows = _Rows()
    pairs: Counter[str] = Counter()
    connections = [one for one in reader.connections if one.topic == name]
    for connection, logged, raw in reader.messages(connections=connections):
        message = reader.deserialize(raw, connection.msgtype)
        if kind == "nav_msgs/Path":  # each is a path of its own; the last one counts
            rows = _Rows()
            for pose in message.poses:
                rows.add(pose.header, logged, pose.pose.position, pose.pose.orientation)
            rows.frames[message.header.frame_id] += 1
        elif kind in _TRANSFORMS:
            for one in _transforms(message, child, pairs):
                moved = one.transform
                rows.add(one.header, logged, moved.translation, moved.rotation)
        else:
            pose = message.pose
            pose = getattr(pose, "pose", pose)
            rows.add(message.header, logged, pose.position, pose.orientation)
            if kind == "nav_msgs/Odometry":
                twist = message.twist.twist
                rows.twist.append((twist.linear.x, twist.linear.y, twist.angular.z))
    if kind in _TRANSFORMS and (not rows.pose or (child is None and len(pairs) > 1)):
        raise ValueError(f"{where}: child_frame says which of {', '.join(sorted(pairs))}")
    if not rows.pose:
        raise ValueError(f"{where}: no poses")
    return rows


def _times(
    where: str, rows: _Rows, kind: str, stamps: str
) -> tuple[Array | None, float, list[str]]:
    """Return the times since the first, the first stamp [s], and what is worth knowing."""
    header, logged = np.array(rows.stamp), np.array(rows.logged)
    if kind == "nav_msgs/Path" and (stamps == "log" or len(set(rows.stamp)) <= 1):
        return None, 0.0, ["the poses of the path have no stamps of their own: no times"]
    if stamps == "log":
        return (logged - logged[0]) * 1e-9, float(logged[0]) * 1e-9, ["times are the log's"]
    unstamped = int((header == 0).sum())
    if unstamped > 1 or unstamped == len(header):  # one may be a clock's start
        raise ValueError(
            f"{where}: the header stamps of {unstamped} messages are 0; stamps='log' takes the "
            "times of recording, which have the transport's delay and jitter"
        )
    late = (logged - header) * 1e-9
    notes = ["times are the headers'"]
    if kind != "nav_msgs/Path":
        notes.append(
            f"recorded {np.median(late):.4g} s after their stamps (median; {late.min():.4g} to "
            f"{late.max():.4g} s)"
        )
        if abs(np.median(late)) > _ONE_CLOCK or np.ptp(late) > _ONE_CLOCK:
            notes.append(
                "headers and log are of two clocks, as with simulated time: the headers' is used"
            )
    return (header - header[0]) * 1e-9, float(header[0]) * 1e-9, notes


def read_bag(
    path: str | os.PathLike[str],
    topic: str | None = None,
    *,
    stamps: Literal["header", "log"] = "header",
    child_frame: str | None = None,
) -> Log:
    """Return the states of a topic of a bag.

    Reads nav_msgs/Odometry, nav_msgs/Path (of its last message), geometry_msgs/PoseStamped and
    PoseWithCovarianceStamped, tf2_msgs/TFMessage and tf/tfMessage. An Odometry's twist is in the
    body's frame, as the message says: v is linear.x. Needs the extra `formats`.

    Parameters
    ----------
    path
        a ROS 1 bag, a folder of a ROS 2 bag, or a .db3 or .mcap file.
    topic
        None: the only one that can be read.
    stamps
        "header": when the pose was measured; "log": when the message was recorded.
    child_frame
        of tf: the frame whose transform is read.

    Raises
    ------
    ValueError
        No such topic (those present are listed), several, header stamps of 0, or quaternions that
        are none.
    ImportError
        rosbags is not installed.
    OSError
        The file cannot be read.
    """
    where = os.fspath(path)
    if stamps not in ("header", "log"):
        raise ValueError(f"stamps is {stamps!r}; must be 'header' or 'log'")
    highlevel = extra("rosbags.highlevel", "read_bag")
    typesys = extra("rosbags.typesys", "read_bag")
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    if not Path(where).exists():
        raise FileNotFoundError(f"{where}: no such file")
    try:
        with highlevel.AnyReader(_files(Path(where)), default_typestore=store) as reader:
            topics = {one.topic: one.msgtype for one in reader.connections}
            name = _chosen(where, topics, topic)
            kind = _short(topics[name])
            source = f"{where}: {name}"
            rows = _messages(reader, name, kind, child_frame, source)
    except highlevel.AnyReaderError as error:
        raise ValueError(f"{where}: {error}") from None
    t, start, notes = _times(source, rows, kind, stamps)
    x, y, *quaternion = np.array(rows.pose).T
    theta, of_rotation = yaw_of(source, *quaternion)
    twist = np.array(rows.twist) if rows.twist else None
    if twist is not None and np.abs(twist[:, 1]).max() > 0.05 * max(
        np.abs(twist[:, 0]).max(), 1e-9
    ):
        notes.append(
            f"linear.y of the twist reaches {np.abs(twist[:, 1]).max():.3g} m/s, which no "
            "differential drive has in its own frame: a twist in the world's frame?"
        )
    frames = ", ".join(name or "(none)" for name, _ in rows.frames.most_common())
    return Log(
        x=x,
        y=y,
        t=t,
        theta=theta,
        v=None if twist is None else twist[:, 0],
        omega=None if twist is None else twist[:, 2],
        start=start,
        source=source,
        notes=(f"{source}: {len(x)} poses of {kind} in frame {frames}", *notes, *of_rotation),
    )
