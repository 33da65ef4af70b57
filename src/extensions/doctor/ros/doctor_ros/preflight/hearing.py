"""Scans, commands and headings, in the body's axes, for the checks by hand."""

from __future__ import annotations

import contextlib
import math
import time
from collections import Counter
from typing import Any, Callable

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import LaserScan

from doctor.preflight import by_hand
from doctor.preflight.by_hand import Answer, View
from doctor.preflight.standing import BASE_FRAME, ODOMETRY, SAFE, SCAN
from flights.errors import GraphError
from input_checks_ros.lidar_readings import LidarReadings
from node_tools.conversions import xyz, xyzw
from node_tools.newest_transforms import FrameError, NewestTransforms
from node_tools.ros_servers import UNREACHABLE

LET_OTHERS_PASS = "Let all other checks pass first: rosrun doctor preflight."


def answers(listen_s: float) -> list[Answer]:
    """Listen for this wall time; return the nearest thing of each scan, with CEPA's command of its stamp.

    Raises:
        GraphError: there was no scan, or no command.
    """
    nearest: dict[rospy.Time, tuple[float, float]] = {}
    commands: dict[rospy.Time, tuple[float, float]] = {}
    beams = _Beams()

    def on_scan(scan: LaserScan) -> None:
        seen = beams.of(scan)
        if seen is None:
            return
        bearings_rad, ranges_m = seen
        if len(ranges_m):
            index = int(np.argmin(ranges_m))
            nearest[scan.header.stamp] = float(bearings_rad[index]), float(ranges_m[index])

    def on_command(command: TwistStamped) -> None:
        commands[command.header.stamp] = command.twist.linear.x, command.twist.linear.y

    _listen(listen_s, {SCAN: (LaserScan, on_scan), SAFE: (TwistStamped, on_command)})
    beams.check()
    both = sorted(nearest.keys() & commands.keys())
    if nearest and not both:
        raise GraphError(f"No command on {SAFE} has the stamp of a scan on {SCAN}. {LET_OTHERS_PASS}")
    return [Answer(*nearest[stamp], commands[stamp]) for stamp in both]


def views(listen_s: float) -> tuple[View, View]:
    """Listen for this wall time; return the first scan and the last one, each with odometry's heading.

    Raises:
        GraphError: there were no two of them, or no odometry.
    """
    found: list[View] = []
    headings: list[float] = []
    beams = _Beams()

    def on_scan(scan: LaserScan) -> None:
        seen = beams.of(scan) if headings else None
        if seen is not None:
            found.append(View(*seen, headings[-1]))
            del found[1:-1]

    def on_odometry(odometry: Odometry) -> None:
        turn = odometry.pose.pose.orientation
        headings[:] = [2.0 * math.atan2(turn.z, turn.w)]

    _listen(listen_s, {SCAN: (LaserScan, on_scan), ODOMETRY: (Odometry, on_odometry)})
    beams.check()
    if len(found) < 2:
        raise GraphError(f"No two scans came on {SCAN} after poses on {ODOMETRY}. {LET_OTHERS_PASS}")
    return found[0], found[1]


def odometry(listen_s: float) -> list[by_hand.Odometry]:
    """Listen to odometry for this wall time. A child_frame_id that TF does not know counts as the body's.

    Raises:
        GraphError: there was none.
    """
    found: list[by_hand.Odometry] = []
    transforms: list[NewestTransforms] = []

    def on_odometry(message: Odometry) -> None:
        transforms[:] = transforms or [NewestTransforms()]
        child, parent = message.child_frame_id.lstrip("/"), message.header.frame_id.lstrip("/")
        told = np.array(xyz(message.twist.twist.linear))
        if not np.isfinite(told).all():
            return
        if child not in ("", BASE_FRAME, parent):
            with contextlib.suppress(FrameError):
                told = Rotation.from_quat(transforms[0].look_up(BASE_FRAME, child).rotation_xyzw).apply(told)
        pose, (x, y, z) = message.pose.pose, told.tolist()
        state = xyz(pose.position), xyzw(pose.orientation), child == parent != ""
        found.append(by_hand.Odometry(message.header.stamp.to_nsec(), (x, y, z), *state))

    _listen(listen_s, {ODOMETRY: (Odometry, on_odometry)})
    return found


class _Beams:
    """Turns scans into the body's axes, through TF."""

    def __init__(self) -> None:
        self._transforms: NewestTransforms | None = None
        self._complaint, self._readings = "", LidarReadings(lambda _: None)

    def of(self, scan: LaserScan) -> tuple[np.ndarray, np.ndarray] | None:
        """Return bearings (rad) and ranges (m) of the beams that see something.

        None while TF does not know the lidar, as at the first scans.
        """
        if self._transforms is None:
            self._transforms = NewestTransforms()
        try:
            mount = self._transforms.look_up(BASE_FRAME, scan.header.frame_id)
        except FrameError as error:
            self._complaint = str(error)
            return None
        self._complaint, scan = "", self._readings.scan(scan)
        ranges_m = np.asarray(scan.ranges, float)
        angles_rad = scan.angle_min + scan.angle_increment * np.arange(len(ranges_m))
        seen = (ranges_m >= scan.range_min) & (ranges_m <= scan.range_max)
        along = np.column_stack((np.cos(angles_rad), np.sin(angles_rad), np.zeros_like(angles_rad)))[seen]
        turned = Rotation.from_quat(mount.rotation_xyzw).apply(along) if len(along) else along
        return np.arctan2(turned[:, 1], turned[:, 0]), ranges_m[seen]

    def check(self) -> None:
        """Raise GraphError if TF did not know the lidar to the end."""
        if self._complaint:
            raise GraphError(f"{self._complaint} {LET_OTHERS_PASS}")


def _listen(listen_s: float, topics: dict[str, tuple[type, Callable]]) -> None:
    """Call back for the messages of this wall time.

    Raises:
        GraphError: there is no master, or nothing came on a topic.
    """
    try:
        rosgraph.Master("/preflight").getPid()
    except UNREACHABLE:
        raise GraphError(
            f"No ROS master answers at {rosgraph.get_master_uri()}: start real.launch."
        ) from None
    rospy.init_node("preflight", anonymous=True, disable_signals=True, disable_rosout=True)
    heard: Counter[str] = Counter()

    def on_message(message: Any, topic: str) -> None:
        heard[topic] += 1
        topics[topic][1](message)

    subscribers = [rospy.Subscriber(topic, kind, on_message, topic) for topic, (kind, _) in topics.items()]
    time.sleep(listen_s)
    for subscriber in subscribers:
        subscriber.unregister()
    silent = [topic for topic in topics if not heard[topic]]
    if silent:
        raise GraphError(f"Nothing came on {' and '.join(silent)} in {listen_s:g} s. {LET_OTHERS_PASS}")
