"""Reads from the bag of a flight where the UAV and its camera were."""

from __future__ import annotations

from typing import Callable, Sequence

import numpy as np
import rosbag
import rospy
import tf2_py
from geometry_msgs.msg import Pose, Transform, TransformStamped
from geometry_msgs.msg import Quaternion as QuaternionMessage
from geometry_msgs.msg import Vector3 as Vector3Message

from flight_basics.errors import PoseError
from flight_basics.geometry import Quaternion, Vector3, normalised
from inspection.photograph_poses.command import BagQuery
from inspection.photograph_poses.of_flight import Flight, Track
from inspection.photographs.record import PhotographError
from node_tools.bags import DAMAGE
from node_tools.conversions import xyz, xyzw

AUTHORITY = "inspection"
STATIC, MOVING = "/tf_static", "/tf"
KINDS = {"path": "nav_msgs/Path", "odometry": "nav_msgs/Odometry"}


def read_flight(query: BagQuery) -> Flight:
    """Return the flight in a bag.

    Raises:
        PhotographError: the bag cannot be read, or has no path, or does not tell how the camera was mounted.
    """
    try:
        with rosbag.Bag(str(query.bag)) as bag:
            return _flight(bag, query)
    except rosbag.ROSBagUnindexedException:
        raise PhotographError(
            f"{query.bag}: has no index, for its recording was cut off: rosbag reindex {query.bag}"
        ) from None
    except PoseError as error:
        raise PhotographError(f"{query.bag}: {error}") from None
    except DAMAGE as error:
        raise PhotographError(f"{query.bag}: cannot be read ({error}).") from None


def _flight(bag: rosbag.Bag, query: BagQuery) -> Flight:
    topics = bag.get_type_and_topic_info().topics
    kinds = {name.lstrip("/"): each.msg_type for name, each in topics.items()}
    if kinds.get(query.path.lstrip("/")) != KINDS["path"]:
        others = sorted(name for name, each in topics.items() if each.msg_type == KINDS["path"])
        hint = (
            f"Give one of {', '.join(others)} with --path." if others else "It has no nav_msgs/Path at all."
        )
        raise PhotographError(f"{query.bag}: there is no path of SLAM on {query.path}. {hint}")
    paths = [message for _, message, _ in bag.read_messages(topics=_spellings(query.path))]
    path = paths[-1]  # it knows all loops
    if not path.poses:
        raise PhotographError(f"{query.bag}: the path on {query.path} is empty.")
    stamps_s = [each.header.stamp.to_sec() for each in path.poses]
    odometry, base = None, ""
    if kinds.get(query.odometry.lstrip("/")) == KINDS["odometry"]:
        held = [message for _, message, _ in bag.read_messages(topics=_spellings(query.odometry))]
        base = held[-1].child_frame_id
        times = [each.header.stamp.to_sec() for each in held]
        odometry = _track(times, [each.pose.pose for each in held])
    if query.mount is not None:
        known = query.mount
        return Flight(_track(stamps_s, [each.pose for each in path.poses]), odometry, lambda _: known)
    mount = _mount(bag, base or "base_frame", query)
    return Flight(_track(stamps_s, [each.pose for each in path.poses]), odometry, mount)


def _spellings(topic: str) -> list[str]:
    return [topic.lstrip("/"), "/" + topic.lstrip("/")]


def _track(stamps_s: Sequence[float], poses: Sequence[Pose]) -> Track:
    """Return the poses in the order of their stamps, each stamp once."""
    order, first = np.unique(np.array(stamps_s, float), return_index=True)
    places_m = np.array([xyz(poses[k].position) for k in first], float)
    turns = np.array([normalised(xyzw(poses[k].orientation)) for k in first], float)
    return Track(order, places_m, turns)


def _mount(
    bag: rosbag.Bag, base: str, query: BagQuery
) -> Callable[[float], tuple[Vector3, Quaternion] | None]:
    """Return where the camera's frame was in the UAV's, by the bag's TF; a gimbal may turn it."""
    length_s = bag.get_end_time() - bag.get_start_time() + 1.0
    buffer = tf2_py.BufferCore(rospy.Duration(length_s))
    frames = set()
    for topic, message, _ in bag.read_messages(topics=[*_spellings(STATIC), *_spellings(MOVING)]):
        is_static = topic.lstrip("/") == STATIC.lstrip("/")
        for edge in message.transforms:
            _take(buffer, edge, is_static)
            frames |= {edge.child_frame_id.lstrip("/"), edge.header.frame_id.lstrip("/")}
    missing = [each for each in (base, query.camera_frame) if each.lstrip("/") not in frames]
    if missing:
        raise PhotographError(
            f"{query.bag}: its TF has no frame {missing[0]}. Give --camera-frame, or the camera's --mount."
        )

    def mount(stamp_s: float) -> tuple[Vector3, Quaternion] | None:
        try:
            found = buffer.lookup_transform_core(
                base.lstrip("/"), query.camera_frame.lstrip("/"), rospy.Time.from_sec(stamp_s)
            ).transform
        except tf2_py.TransformException:
            return None
        return xyz(found.translation), normalised(xyzw(found.rotation))

    return mount


def _take(buffer: tf2_py.BufferCore, edge: TransformStamped, is_static: bool) -> None:
    """Put an edge into the buffer. A bag's messages are of classes of its own, of which tf2 warns."""
    own, told = TransformStamped(edge.header, edge.child_frame_id, Transform()), edge.transform
    own.transform.translation = Vector3Message(*(getattr(told.translation, axis) for axis in "xyz"))
    own.transform.rotation = QuaternionMessage(*(getattr(told.rotation, axis) for axis in "xyzw"))
    try:
        (buffer.set_transform_static if is_static else buffer.set_transform)(own, AUTHORITY)
    except (ValueError, TypeError):
        return
