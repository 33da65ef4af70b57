"""Publishes TF map -> odom. Messages trigger it, so it works while the clock stands still."""

from __future__ import annotations

import threading

import rospy
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from node_tools.conversions import set_yaw, time_of

LevelPose = tuple[float, float, float, float]
"""x, y in m, yaw in rad and z in m."""

APART_NS = 1000
"""TF refuses two transforms of one stamp. So a correction is stamped later by at least this."""


class MapToOdom:
    """Publishes the newest map -> odom, stamped ``delay_s`` ahead of its time, as gmapping does.

    So others can look up the map's frame at the newest odometry's stamp without waiting.

    Args:
        publisher: of TFMessage.
        frames: names of map and odom.
        period_s: least time between two transforms, except corrections; 0: publish none.
        delay_s: a transform's stamp is this much later than the message that triggered it.
    """

    def __init__(self, publisher: rospy.Publisher, frames: tuple[str, str], period_s: float, delay_s: float):
        self._publisher, self._frames = publisher, frames
        self._period_ns, self._delay_ns = int(period_s * 1e9), int(delay_s * 1e9)
        self._lock = threading.Lock()
        self._pose: LevelPose | None = None
        self._last_ns: int | None = None
        self.restart(None)

    def restart(self, pose: LevelPose | None) -> None:
        """Start anew with this odom in map, or without one until ``correct`` is called."""
        with self._lock:
            self._pose, self._last_ns = pose, None

    def correct(self, pose: LevelPose, stamp_ns: int) -> None:
        """Publish a new odom in map, computed from a message of this stamp."""
        with self._lock:
            before, self._pose = self._pose, pose
            self._publish(
                pose, stamp_ns, corrected=before if before != pose else None, at_once=before != pose
            )

    def keep_up(self, stamp_ns: int) -> None:
        """Publish the last one again if it is due at this stamp."""
        with self._lock:
            if self._pose is not None:
                self._publish(self._pose, stamp_ns)

    def _publish(
        self, pose: LevelPose, stamp_ns: int, at_once: bool = False, corrected: LevelPose | None = None
    ) -> None:
        if not self._period_ns:
            return
        ahead_ns = stamp_ns + self._delay_ns
        edges: list[TransformStamped] = []
        if self._last_ns is not None:
            if not at_once and ahead_ns < self._last_ns + self._period_ns:
                return
            ahead_ns = max(ahead_ns, self._last_ns + APART_NS)
            if corrected is not None and ahead_ns > self._last_ns + APART_NS:
                # Without this, TF would interpolate between the old and the new pose.
                edges.append(self._edge(corrected, ahead_ns - APART_NS))
        self._last_ns = ahead_ns
        self._publisher.publish(TFMessage([*edges, self._edge(pose, ahead_ns)]))

    def _edge(self, pose: LevelPose, stamp_ns: int) -> TransformStamped:
        x, y, yaw, z = pose
        message = TransformStamped()
        message.header.frame_id, message.child_frame_id = self._frames
        message.header.stamp = time_of(stamp_ns)
        translation = message.transform.translation
        translation.x, translation.y, translation.z = x, y, z
        set_yaw(message.transform.rotation, yaw)
        return message
