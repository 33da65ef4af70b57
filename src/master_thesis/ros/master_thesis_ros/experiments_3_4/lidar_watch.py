"""Notes how the lidar hangs on the UAV in flight: its gimbal may keep it level, or let it nod."""

from __future__ import annotations

from collections import deque

import numpy as np
import rospy
import tf2_py
from nav_msgs.msg import Odometry
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from flights_ros.drivers.messages import stamp_s
from node_tools.conversions import xyz, xyzw

LATE_S = 1.0
"""Simulated time after which TF knows a stamp, or never will."""
AUTHORITY = "experiment"


class LidarWatch:
    """Keeps the lidar's poses on the UAV.

    Subscribes: /tf, /tf_static; ground_truth (nav_msgs/Odometry), for the name of the UAV's frame; lidar_scan
        (sensor_msgs/LaserScan), whose frame is the lidar's.
    """

    def __init__(self) -> None:
        self._buffer = tf2_py.BufferCore(rospy.Duration(10.0))
        self._base = ""
        self._asked: deque[tuple[str, rospy.Time]] = deque()
        self._rows: list[tuple] = []
        self._subscribers = [
            rospy.Subscriber("/tf_static", TFMessage, lambda given: self._on_tf(given, True), queue_size=100),
            rospy.Subscriber("/tf", TFMessage, lambda given: self._on_tf(given, False), queue_size=100),
            rospy.Subscriber("lidar_scan", numpy_msg(LaserScan), self._on_scan, queue_size=100),
            rospy.Subscriber("ground_truth", Odometry, self._on_ground_truth, queue_size=1),
        ]

    def close(self) -> np.ndarray:
        """Return (n, 8): stamp, x, y, z, quaternion xyzw of the lidar in the UAV's frame, m. Unsubscribe."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        while self._asked:
            self._look_up(*self._asked.popleft())
        return np.array(self._rows).reshape(-1, 8)

    def _on_scan(self, message: LaserScan) -> None:
        """Take note of the lidar's pose at a scan, when TF has had time to tell it."""
        self._asked.append((message.header.frame_id, message.header.stamp))
        while self._asked and self._asked[0][1].to_sec() < stamp_s(message) - LATE_S:
            self._look_up(*self._asked.popleft())

    def _look_up(self, frame: str, stamp: rospy.Time) -> None:
        try:
            found = self._buffer.lookup_transform_core(self._base, frame.lstrip("/"), stamp).transform
        except tf2_py.TransformException:
            return
        self._rows.append((stamp.to_sec(), *xyz(found.translation), *xyzw(found.rotation)))

    def _on_ground_truth(self, message: Odometry) -> None:
        self._base = message.child_frame_id.lstrip("/")

    def _on_tf(self, message: TFMessage, is_static: bool) -> None:
        for edge in message.transforms:
            set_one = self._buffer.set_transform_static if is_static else self._buffer.set_transform
            try:
                set_one(edge, AUTHORITY)
            except (ValueError, TypeError):
                continue
