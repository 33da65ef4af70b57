"""Looks up sensors in odom and odom in the map by TF, without waiting."""

from __future__ import annotations

from collections import Counter
from typing import Sequence

import numpy as np
import rospy
import tf2_py
from geometry_msgs.msg import TransformStamped

from gridslam import PoseError, ScanError
from gridslam.volume import Pose
from gridslam.volume.clock_back import OLD_ONES, TRIMMED_S
from input_checks.carried_frames import CarriedFrames
from node_tools.conversions import xyz, xyzw

CACHE_S = 30.0
AUTHORITY = "gridslam"


class CloudFrames:
    """The received transforms.

    Args:
        map_frame: the map's.
        odom_frame: odometry's. If TF does not know it, clouds are placed in the map's frame directly.
        base_frame: the vehicle's.
        sensor_frame: of the lidar whose clouds come in a frame that the vehicle does not carry; empty: none.
    """

    def __init__(self, map_frame: str, odom_frame: str, base_frame: str, sensor_frame: str = ""):
        self._map, self._odom, self._base = map_frame, odom_frame, base_frame
        self._sensor_frame = sensor_frame.strip().lstrip("/")
        self._carried = CarriedFrames()
        self._buffer = tf2_py.BufferCore(rospy.Duration(CACHE_S))
        self._newest_s: dict[tuple[str, str], float] = {}
        self._old_ones: Counter[tuple[str, str]] = Counter()

    def add(self, transforms: Sequence[TransformStamped], is_static: bool) -> None:
        """Take in a message of /tf or /tf_static; what is no transform is left out.

        When the clock has gone back, the moving transforms of before are forgotten: TF would mix both.
        """
        for edge in transforms:
            if not is_static:
                self._watch_clock(edge)
            try:
                set_one = self._buffer.set_transform_static if is_static else self._buffer.set_transform
                set_one(edge, AUTHORITY)
            except (ValueError, TypeError):
                continue
            self._carried.add(edge.header.frame_id, edge.child_frame_id, is_static)

    def _watch_clock(self, edge: TransformStamped) -> None:
        name, stamp_s = (edge.header.frame_id, edge.child_frame_id), edge.header.stamp.to_sec()
        if stamp_s >= self._newest_s.get(name, stamp_s) - TRIMMED_S:
            self._newest_s[name] = max(stamp_s, self._newest_s.get(name, stamp_s))
            self._old_ones[name] = 0
            return
        self._old_ones[name] += 1
        if self._old_ones[name] >= OLD_ONES:
            self.forget()

    def forget(self) -> None:
        """Forget all moving transforms, as after a clock that jumped back."""
        self._buffer.clear()  # static ones stay known
        self._carried.forget()
        self._newest_s.clear()
        self._old_ones.clear()

    def sensor(self, frame: str, stamp: rospy.Time) -> tuple[Pose, Pose, Pose] | None:
        """Return (sensor in odom, base in odom, odom in map) at a stamp; None: TF does not know them (yet).

        Without an odom frame, odom is the map, and without a base frame the base is the sensor.

        Raises:
            ScanError: as `origin_of`.
        """
        frame = self.origin_of(frame)
        for odom in (self._odom, self._map):
            sensor = self._pose(odom, frame, stamp)
            if sensor is not None:
                base = self._pose(odom, self._base, stamp) or sensor
                return self._in_map(odom, sensor, base, stamp)
        return None

    def origin_of(self, frame: str) -> str:
        """Return the frame of the sensor, from which the rays of a cloud in a frame begin.

        Raises:
            ScanError: the vehicle does not carry the cloud's frame, and it is not known which sensor gave it.
        """
        frame = frame.lstrip("/")
        lacks = self._carried.lacks(self._base, frame, (self._odom, self._map))
        if lacks and not self._sensor_frame:
            raise ScanError(f"{lacks} Or name the lidar's frame: sensor_frame.")
        return self._sensor_frame if lacks else frame

    def between(self, parent: str, frame: str, stamp: rospy.Time) -> Pose | None:
        """Return a frame's pose in another one at a stamp; None: TF does not know it (yet)."""
        return self._pose(parent.lstrip("/"), frame.lstrip("/"), stamp)

    def _in_map(
        self, odom: str, sensor: Pose, base: Pose, stamp: rospy.Time
    ) -> tuple[Pose, Pose, Pose] | None:
        if odom == self._map:
            return sensor, base, Pose.identity()
        # map -> odom may come later than the cloud; then its newest value counts
        in_map = self._pose(self._map, odom, stamp) or self._pose(self._map, odom, rospy.Time(0))
        return None if in_map is None else (sensor, base, in_map)

    def _pose(self, target: str, source: str, stamp: rospy.Time) -> Pose | None:
        try:
            found = self._buffer.lookup_transform_core(target, source, stamp).transform
        except tf2_py.TransformException:
            return None
        try:
            return Pose.of_quaternion(np.array(xyz(found.translation)), np.array(xyzw(found.rotation)))
        except ScanError as error:
            raise PoseError(str(error)) from None
