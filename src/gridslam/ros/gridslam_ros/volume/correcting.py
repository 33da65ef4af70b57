"""Lets a map follow the path that SLAM publishes, in a thread beside the clouds."""

from __future__ import annotations

import threading
import time
from typing import Any, Callable

import numpy as np
import rospy
from nav_msgs.msg import Path

from gridslam import PoseError
from gridslam.volume import Rebuilding
from gridslam.volume.path_poses import odom_in_map
from gridslam_ros.volume.map_in_service import MapInService
from node_tools.conversions import yaw_of

LAST_EVENTS = 3
"""So many events may be left when the corrected map is taken over, while the lock is held."""


class Correcting:
    """Rebuilds the map when a path moves its nodes. A path that comes meanwhile is the next one.

    Args:
        served: the map.
        lock: held while it is read or changed.
        changed: is called when a corrected map is in service.
        say: is called with a sentence about a path that cannot be used.
        failed: is called with an unexpected error.
    """

    def __init__(
        self,
        served: MapInService,
        lock: Any,
        changed: Callable[[], None],
        say: Callable[[str], None],
        failed: Callable[[Exception], None],
    ):
        self._served, self._lock = served, lock
        self._changed, self._say, self._failed = changed, say, failed
        self._path: Path | None = None
        self._has_come = threading.Event()
        threading.Thread(target=self._work, daemon=True).start()

    def take(self, path: Path) -> None:
        """Take the newest path."""
        self._path = path
        self._has_come.set()

    def _is_idle(self) -> bool:
        return not (self._has_come.is_set() or rospy.is_shutdown())

    def _work(self) -> None:
        while not rospy.is_shutdown():
            if not self._has_come.wait(0.5):
                continue
            self._has_come.clear()
            path = self._path
            try:
                if path is not None:
                    self._follow(path)
            except PoseError as error:
                self._say(str(error))
            except Exception as error:
                self._failed(error)
                return

    def _follow(self, path: Path) -> None:
        stamps_s = np.array([pose.header.stamp.to_sec() for pose in path.poses])
        poses = np.array(
            [(p.pose.position.x, p.pose.position.y, yaw_of(p.pose.orientation)) for p in path.poses]
        ).reshape(-1, 3)
        heights_m = np.array([p.pose.position.z for p in path.poses])
        is_planar = not heights_m.any()  # of a SLAM that knows no heights
        with self._lock:
            served, nodes = self._served, self._served.corrected.nodes
            if not nodes:
                return
            are_known, path_s, since_s = served.time.of_path(stamps_s)
            times_s = np.array([node.stamp_s for node in nodes])
            heights = None if is_planar else heights_m[are_known]
            in_map = odom_in_map(path_s, poses[are_known], served.history, times_s, heights)
            # A node after the path's end, or of a flight that the path does not know, stays where it is
            sensors = [
                odom @ node.sensor_in_odom if since_s <= node.stamp_s <= path_s[-1] else node.sensor_in_map
                for odom, node in zip(in_map, nodes)
            ]
            rebuilding = Rebuilding(served.corrected, sensors)
        if not rebuilding.moved:
            rebuilding.settle(self._is_idle)
            return
        began_s = time.monotonic()
        while np.diff(rebuilding.progress) > LAST_EVENTS and not rospy.is_shutdown():
            rebuilding.step()
        with self._lock:
            rebuilding.take_over()
        rospy.loginfo(
            f"The map follows its path: {rebuilding.moved} of {len(nodes)} nodes moved, in "
            f"{time.monotonic() - began_s:.1f} s."
        )
        self._changed()
        rebuilding.settle(self._is_idle)
        rospy.rostime.wallsleep(time.monotonic() - began_s)  # or small corrections would keep a core busy
