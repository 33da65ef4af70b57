"""What comes on other topics than a scan, and belongs to it: its covariance and its cloud."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from sensor_msgs.msg import LaserScan

from gridslam.level_cloud import LevelCloud
from gridslam_ros.beside.clouds import CloudSource
from gridslam_ros.beside.covariances import OdometryCovariances
from gridslam_ros.frames.odometry_frames import OdometryFrames


class BesideScans(NamedTuple):
    """frames: the transforms. covariances, clouds: None: they do not count."""

    frames: OdometryFrames
    covariances: OdometryCovariances | None
    clouds: CloudSource | None

    @property
    def hears_all(self) -> bool:
        """Whether a cloud has come, if clouds count."""
        return self.clouds is None or self.clouds.has_come

    def know(self, scan: LaserScan) -> bool:
        """Whether everything about a scan has come."""
        stamp, tf_ns = scan.header.stamp, self.frames.newest_ns
        return (
            self.frames.know(scan)
            and (self.covariances is None or self.covariances.know(stamp, tf_ns))
            and (self.clouds is None or self.clouds.know(stamp, tf_ns))
        )

    def covariance_of(self, scan: LaserScan) -> np.ndarray | None:
        """Return the covariance (3, 3) of the odometry at a scan; None: it is not known."""
        return None if self.covariances is None else self.covariances.at(scan.header.stamp)

    def cloud_of(self, scan: LaserScan) -> LevelCloud | None:
        """Return the cloud of a scan; None: there is none.

        Raises:
            SlamError: it cannot be used.
        """
        return None if self.clouds is None else self.clouds.of(scan)
