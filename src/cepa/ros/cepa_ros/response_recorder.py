"""Collects commanded velocities and odometry as a recording along the odometry's axes."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import rosbag
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry

from cepa.identification.recording import IdentificationError, Recording
from node_tools.bags import DAMAGE
from node_tools.conversions import xyz, yaw_of


class ResponseRecorder:
    """Takes messages in any order; commands are turned by the heading of their time."""

    def __init__(self, base_frame: str) -> None:
        self._body_frames = {"", base_frame.lstrip("/")}
        self._odom_frame = ""
        self._commands: list[tuple[float, str, tuple[float, float, float]]] = []
        self._odometry: list[tuple[float, float, float, float, float]] = []

    def on_command(self, message: TwistStamped) -> None:
        """Take a velocity command."""
        frame = message.header.frame_id.lstrip("/")
        self._commands.append((message.header.stamp.to_sec(), frame, xyz(message.twist.linear)))

    def on_odometry(self, message: Odometry) -> None:
        """Take an odometry message: its twist is in the body's axes (REP-105)."""
        self._odom_frame = message.header.frame_id.lstrip("/")
        self._body_frames.add(message.child_frame_id.lstrip("/"))
        q = message.pose.pose.orientation
        velocity = rotated((q.x, q.y, q.z, q.w), xyz(message.twist.twist.linear))
        self._odometry.append((message.header.stamp.to_sec(), yaw_of(q), *velocity))

    def recording(self) -> Recording:
        """Return what was taken.

        Raises:
            IdentificationError: a command is in an unknown frame, or a number is not finite.
        """
        odometry = np.array(sorted(self._odometry)).reshape(-1, 5)
        if not len(odometry):
            raise IdentificationError("There is no odometry; check its topic.")
        stamps_s, yaws = odometry[:, 0], odometry[:, 1]
        rows = []
        for t, frame, (ahead, left, up) in sorted(self._commands):
            yaw = 0.0
            if frame in self._body_frames:
                yaw = float(yaws[max(int(np.searchsorted(stamps_s, t + 1e-6)) - 1, 0)])
            elif frame != self._odom_frame:
                raise IdentificationError(
                    f"The commands are in the frame '{frame}'; they must be in the body's or in "
                    f"'{self._odom_frame}'."
                )
            c, s = math.cos(yaw), math.sin(yaw)
            rows.append((t, c * ahead - s * left, s * ahead + c * left, up))
        return Recording(np.array(rows).reshape(-1, 4), odometry[:, [0, 2, 3, 4]])


def rotated(
    rotation_xyzw: tuple[float, float, float, float], vector: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return a vector turned by a unit quaternion."""
    x, y, z, w = rotation_xyzw
    axis = np.array([x, y, z])
    across = 2.0 * np.cross(axis, vector)
    turned = np.asarray(vector) + w * across + np.cross(axis, across)
    return float(turned[0]), float(turned[1]), float(turned[2])


def read_bag(path: Path, command_topic: str, odometry_topic: str, base_frame: str) -> Recording:
    """Return the recording in a bag.

    Raises:
        IdentificationError: the bag cannot be read, lacks a topic, or has other messages on it.
    """
    recorder = ResponseRecorder(base_frame)
    try:
        with rosbag.Bag(str(path)) as bag:
            _require(bag, command_topic, TwistStamped._type)
            _require(bag, odometry_topic, Odometry._type)
            for topic, message, _ in bag.read_messages([command_topic, odometry_topic]):
                (recorder.on_command if topic == command_topic else recorder.on_odometry)(message)
    except rosbag.ROSBagUnindexedException:
        raise IdentificationError(
            f"The bag {path} has no index (its recording was cut off): rosbag reindex {path}"
        ) from None
    except DAMAGE as error:
        reason = getattr(error, "strerror", None) or error
        raise IdentificationError(f"The bag {path} cannot be read: {reason}.") from None
    return recorder.recording()


def _require(bag: rosbag.Bag, topic: str, kind: str) -> None:
    """Raise IdentificationError unless there are messages of this type on a topic."""
    types = {name: info.msg_type for name, info in bag.get_type_and_topic_info().topics.items()}
    if types.get(topic) != kind:
        there = ", ".join(f"{name} ({types[name]})" for name in sorted(types)) or "no topic"
        raise IdentificationError(
            f"The bag {bag.filename} lacks {topic} ({kind}); it holds {there}. Choose other topics with "
            "--commands and --odometry."
        )
