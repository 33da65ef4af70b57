"""The clouds that a lidar gives beside its scans, for loop closure in space."""

from __future__ import annotations

from typing import Callable

from genpy import Time
from sensor_msgs.msg import LaserScan, PointCloud2

from gridslam.inputs.attitude import matrix_of_quaternion, roll_pitch_yaw_of
from gridslam.level_cloud import LevelCloud
from gridslam_ros.beside.by_stamp import ByStamp
from gridslam_ros.frames.odometry_frames import OdometryFrames
from gridslam_ros.volume import messages
from input_checks_ros.lidar_readings import LidarReadings

KEPT = 40


class CloudSource:
    """The last clouds, by stamp. A scan has the cloud of its own stamp.

    Args:
        frames: the transforms.
        say: is called with a sentence when scans have no clouds.
    """

    def __init__(self, frames: OdometryFrames, say: Callable[[str], None]) -> None:
        self._frames, self._say, self._readings = frames, say, LidarReadings(say)
        self._last: ByStamp[PointCloud2] = ByStamp(KEPT)

    def add(self, message: PointCloud2) -> None:
        """Take a cloud."""
        self._last.put(message.header.stamp, message)

    @property
    def has_come(self) -> bool:
        """Whether there was a cloud yet."""
        return self._last.has_come

    def know(self, stamp: Time, tf_ns: int | None) -> bool:
        """Whether the clouds have reached a scan's stamp; see `ByStamp.know`."""
        return self._last.know(stamp, tf_ns)

    def of(self, scan: LaserScan) -> LevelCloud | None:
        """Return the cloud of a scan's stamp; None: there is none.

        Raises:
            FrameError: TF does not know where the lidar was.
            ScanError: the cloud makes no sense.
        """
        cloud = self._last.get(scan.header.stamp)
        if cloud is None:
            self._say("Scans have no cloud of the same stamp; loops are closed by level scans alone there.")
            return None
        (_, orientation), lidar_in_base = self._frames.look_up(cloud)
        roll_rad, pitch_rad, _ = roll_pitch_yaw_of(matrix_of_quaternion(orientation))
        points = messages.readable(self._readings.points, cloud)
        return LevelCloud.of(points, lidar_in_base, (roll_rad, pitch_rad))
