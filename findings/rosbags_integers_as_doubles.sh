#!/usr/bin/env bash
# rosbags: an array of integers in a float64 field of a ROS message is written as 5e-324s.
#
# One would guess: np.eye(6, dtype=int).ravel() as a covariance, or wheel angles [0, 10] that NumPy made integers, are
#   converted like the scalars of the same message, or refused.
# What happens: scalars are converted (x=1 arrives as 1.0), float32 arrays are refused, but an int64 array is taken bit
#   by bit, as its items have 8 bytes, too. The message has the right length and reads back without an error, with
#   1 as 4.9e-324, which prints as 0 or 5e-324. ROS 1 and ROS 2 serialisation agree.
# Why it matters: a covariance of almost exactly zero tells an estimator that a sensor is perfect; a reference speed or
#   a wheel angle of 5e-324 is a robot that stands still. The file is valid for every reader.
# Seen with: rosbags 0.11.9.
# Source: https://ternaris.gitlab.io/rosbags/topics/serde.html (serialisation code is generated from the types; it
#   speaks of no conversion).
set -euo pipefail

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
python3 -m venv "$work/venv"
"$work/venv/bin/pip" install --quiet --disable-pip-version-check rosbags==0.11.9 numpy==2.4.6

"$work/venv/bin/python" - <<'PYTHON'
import numpy as np
from rosbags.typesys import Stores, get_typestore

ros2 = get_typestore(Stores.ROS2_HUMBLE)
types = ros2.types
NAME = "geometry_msgs/msg/PoseWithCovariance"


def round_trip(covariance):
    point = types["geometry_msgs/msg/Point"](x=1, y=2, z=0)  # Whole numbers on purpose.
    turn = types["geometry_msgs/msg/Quaternion"](x=0, y=0, z=0, w=1)
    pose = types["geometry_msgs/msg/Pose"](position=point, orientation=turn)
    return ros2.deserialize_cdr(ros2.serialize_cdr(types[NAME](pose=pose, covariance=covariance), NAME), NAME)


right = round_trip(np.eye(6).ravel())
wrong = round_trip(np.eye(6, dtype=np.int64).ravel())
print("float64 covariance, first items:", right.covariance[:3])
print("int64 covariance, first items:  ", wrong.covariance[:3])
print("the scalars of the same message:", wrong.pose.position.x, wrong.pose.position.y)
try:
    round_trip(np.eye(6, dtype=np.float32).ravel())
    refused = False
except ValueError as error:
    refused = True
    print("float32 covariance:", error)

ros1 = get_typestore(Stores.ROS1_NOETIC)
ARRAY = "std_msgs/msg/Float64MultiArray"
layout = ros1.types["std_msgs/msg/MultiArrayLayout"](dim=[], data_offset=0)
raw = ros1.serialize_ros1(ros1.types[ARRAY](layout=layout, data=np.array([1, 2, 3])), ARRAY)
first = ros1.deserialize_ros1(raw, ARRAY).data
print("ROS 1, [1, 2, 3]:", first)

assert right.covariance[0] == 1.0 and wrong.pose.position.x == 1.0 and refused
assert wrong.covariance[0] == np.nextafter(0.0, 1.0), "integers in a float64 field are no longer taken bit by bit"
assert first[2] == 3 * np.nextafter(0.0, 1.0), "ROS 1 serialisation has changed"
PYTHON
