"""Where base and lidar are in the odometry's frame, by TF; nothing here waits or needs a node."""

from __future__ import annotations

import rospy
import tf2_py

from gridslam import SlamError

CACHE_S = 120.0
BACK_NS = 1_000_000_000
"""An edge so much older than the last is from another time: a simulator's reset, a bag played again."""


class FrameError(SlamError):
    """TF does not know a transform."""


class OdometryFrames:
    """The transforms heard so far, between the odometry's, the base's and the lidar's frame."""

    def __init__(self, odom_frame: str, base_frame: str):
        self.odom_frame, self.base_frame = odom_frame.lstrip("/"), base_frame.lstrip("/")
        self._buffer = tf2_py.BufferCore(rospy.Duration(CACHE_S))
        self.newest_ns = 0

    def add(self, transforms, static: bool = False) -> int | None:
        """Take in what /tf or /tf_static says; returns the stamp (ns) of an odometry's edge in it."""
        # The map's edge, ours or another's, is not odometry
        transforms = [each for each in transforms if each.child_frame_id.lstrip("/") != self.odom_frame]
        if static:
            for transform in transforms:
                self._buffer.set_transform_static(transform, "gridslam")
            return None
        stamps_ns = [
            each.header.stamp.to_nsec()
            for each in transforms
            if each.header.frame_id.lstrip("/") == self.odom_frame
        ]
        if stamps_ns and stamps_ns[-1] < self.newest_ns - BACK_NS:
            self.forget()
        for transform in transforms:
            self._buffer.set_transform(transform, "gridslam")
        if not stamps_ns:
            return None
        self.newest_ns = max(self.newest_ns, stamps_ns[-1])
        return stamps_ns[-1]

    def forget(self) -> None:
        """Forget moving transforms, as after a clock that jumped back; static ones stay known."""
        self._buffer.clear()
        self.newest_ns = 0

    def know(self, scan) -> bool:
        """Whether TF has come as far as the scan's stamp, so that a look-up now is as good as later."""
        try:
            newest = self._buffer.get_latest_common_time(self.odom_frame, scan.header.frame_id.lstrip("/"))
            base = self._buffer.get_latest_common_time(self.odom_frame, self.base_frame)
        except tf2_py.TransformException:
            return False
        # Zero: nothing but static transforms, which are as old and new as one likes
        return all(time.is_zero() or time >= scan.header.stamp for time in (newest, base))

    def look_up(self, scan) -> tuple:
        """Return (base in odom, lidar in base) at the scan's stamp, each as (xyz, quaternion xyzw).

        Raises:
            FrameError: TF does not know them at that time.
        """
        stamp, lidar_frame = scan.header.stamp, scan.header.frame_id.lstrip("/")
        base_in_odom = self._pose(self.odom_frame, self.base_frame, stamp)
        return base_in_odom, self._pose(self.base_frame, lidar_frame, stamp)

    def _pose(self, target: str, source: str, stamp) -> tuple:
        try:
            found = self._buffer.lookup_transform_core(target, source, stamp).transform
        except tf2_py.TransformException:
            raise FrameError(
                f'TF knows no transform from "{source}" to "{target}" at {stamp.to_sec():.3f} s.'
            ) from None
        t, q = found.translation, found.rotation
        return (t.x, t.y, t.z), (q.x, q.y, q.z, q.w)
