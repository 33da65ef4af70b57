"""Scans, commands and headings, in the body's axes, for the checks by hand."""

from __future__ import annotations

import math
import time
from typing import Callable

import numpy as np
import rosgraph
import rospy
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from scipy.spatial.transform import Rotation
from sensor_msgs.msg import LaserScan

from master_thesis.errors import GraphError
from master_thesis.preflight.by_hand import Answer, View
from master_thesis.preflight.standing import BASE_FRAME, ODOMETRY, SAFE, SCAN
from node_tools.newest_transforms import FrameError, NewestTransforms
from node_tools.ros_servers import UNREACHABLE


def answers(listen_s: float) -> list[Answer]:
    """Listen for this wall time; return the nearest thing of each scan, with CEPA's command of its stamp."""
    nearest: dict[rospy.Time, tuple[float, float]] = {}
    commands: dict[rospy.Time, tuple[float, float]] = {}
    beams = _Beams()

    def on_scan(scan: LaserScan) -> None:
        bearings_rad, ranges_m = beams.of(scan)
        if len(ranges_m):
            index = int(np.argmin(ranges_m))
            nearest[scan.header.stamp] = float(bearings_rad[index]), float(ranges_m[index])

    def on_command(command: TwistStamped) -> None:
        commands[command.header.stamp] = command.twist.linear.x, command.twist.linear.y

    _listen(listen_s, {SCAN: (LaserScan, on_scan), SAFE: (TwistStamped, on_command)})
    beams.check()
    return [Answer(*nearest[stamp], commands[stamp]) for stamp in sorted(nearest.keys() & commands.keys())]


def views(listen_s: float) -> tuple[View, View]:
    """Listen for this wall time; return the first scan and the last one, each with odometry's heading.

    Raises:
        GraphError: there were no two of them.
    """
    found: list[View] = []
    headings: list[float] = []
    beams = _Beams()

    def on_scan(scan: LaserScan) -> None:
        if headings:
            found.append(View(*beams.of(scan), headings[-1]))
            del found[1:-1]

    def on_odometry(odometry: Odometry) -> None:
        turn = odometry.pose.pose.orientation
        headings[:] = [2.0 * math.atan2(turn.z, turn.w)]

    _listen(listen_s, {SCAN: (LaserScan, on_scan), ODOMETRY: (Odometry, on_odometry)})
    beams.check()
    if len(found) < 2:
        raise GraphError(
            f"No two scans came on {SCAN} with poses on {ODOMETRY}; let all other checks pass first."
        )
    return found[0], found[1]


class _Beams:
    """Turns scans into the body's axes, through TF."""

    def __init__(self) -> None:
        self._transforms: NewestTransforms | None = None
        self._complaint = ""

    def of(self, scan: LaserScan) -> tuple[np.ndarray, np.ndarray]:
        """Return bearings (rad) and ranges (m) of the beams that see something; none without TF."""
        if self._transforms is None:
            self._transforms = NewestTransforms()
        try:
            mount = self._transforms.look_up(BASE_FRAME, scan.header.frame_id)
        except FrameError as error:
            self._complaint = str(error)
            return np.zeros(0), np.zeros(0)
        self._complaint = ""
        ranges_m = np.asarray(scan.ranges, float)
        angles_rad = scan.angle_min + scan.angle_increment * np.arange(len(ranges_m))
        seen = (ranges_m >= scan.range_min) & (ranges_m <= scan.range_max)
        along = np.column_stack((np.cos(angles_rad), np.sin(angles_rad), np.zeros_like(angles_rad)))[seen]
        turned = Rotation.from_quat(mount.rotation_xyzw).apply(along) if len(along) else along
        return np.arctan2(turned[:, 1], turned[:, 0]), ranges_m[seen]

    def check(self) -> None:
        """Raise GraphError if TF did not know the lidar to the end."""
        if self._complaint:
            raise GraphError(f"{self._complaint} Let all other checks pass first.")


def _listen(listen_s: float, topics: dict[str, tuple[type, Callable]]) -> None:
    """Call back for the messages of this wall time; raises GraphError without a master."""
    try:
        rosgraph.Master("/preflight").getPid()
    except UNREACHABLE:
        raise GraphError(
            f"No ROS master answers at {rosgraph.get_master_uri()}: start real.launch."
        ) from None
    rospy.init_node("preflight", anonymous=True, disable_signals=True, disable_rosout=True)
    subscribers = [rospy.Subscriber(topic, kind, call) for topic, (kind, call) in topics.items()]
    time.sleep(listen_s)
    for subscriber in subscribers:
        subscriber.unregister()
