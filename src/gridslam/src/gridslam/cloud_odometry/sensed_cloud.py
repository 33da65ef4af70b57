"""A cloud on its way to the odometry."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gridslam.cloud_odometry.cloud_odometry import CloudOdometry
from gridslam.odometry.intake import Mounting
from gridslam.odometry.lidar_odometry import OdometryEstimate


class SensedCloud(NamedTuple):
    """A cloud as a lidar gives it; see `gridslam.odometry.intake.Sensed`."""

    stamp_ns: int
    stamp_s: float
    points: np.ndarray
    """(n, 3) m, in the lidar's frame."""
    frame: str

    @property
    def kind(self) -> str:
        """See `Sensed`."""
        return "cloud"

    def tell(self, odometry: CloudOdometry, lidar_in_base: Mounting) -> OdometryEstimate:
        """See `Sensed`."""
        return odometry.on_cloud(self.stamp_s, self.points, lidar_in_base)
