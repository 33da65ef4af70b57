"""What SLAM takes from a lidar and an odometry: a levelled scan, and where the base was in the plane."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.inputs.attitude import matrix_of_quaternion, roll_pitch_yaw_of
from gridslam.inputs.scan_projection import LidarPose, project
from gridslam.scan import PlanarScan


@dataclass(frozen=True)
class Levelling:
    """How scans are levelled by the odometry's attitude.

    is_on: whether to correct for the base frame's lean and to drop beams at the floor. floor_z_m: height of
    the floor in `odom`; None: unknown, no beam is dropped for it.
    """

    is_on: bool = True
    floor_z_m: float | None = 0.0

    def level(
        self,
        stamp_s: float,
        ranges_m: np.ndarray,
        angles_rad: tuple[float, float],
        limits_m: tuple[float, float],
        lidar_in_base: LidarPose,
        base_in_odom: tuple[Sequence[float], Sequence[float]],
        last_in_odom: tuple[Sequence[float], Sequence[float]] | None = None,
    ) -> tuple[PlanarScan, tuple[float, float, float]]:
        """Return the levelled scan, and the base in `odom` as x, y, yaw.

        Args:
            stamp_s: when the scan was taken.
            ranges_m: (n,) by REP-117.
            angles_rad: angle of the first beam, and from beam to beam.
            limits_m: least and greatest range of the lidar.
            lidar_in_base: see `project`.
            base_in_odom: (xyz, quaternion xyzw) at the same stamp.
            last_in_odom: the same at the last beam; None: all beams are of one instant.

        Raises:
            ScanError: the scan or a pose makes no sense.
        """
        (x, y, z), orientation = base_in_odom
        roll_rad, pitch_rad, yaw_rad = roll_pitch_yaw_of(matrix_of_quaternion(orientation))
        height_m = None if self.floor_z_m is None else z - self.floor_z_m
        scan = project(
            ranges_m,
            *angles_rad,
            *limits_m,
            lidar_in_base,
            (roll_rad, pitch_rad) if self.is_on else (0.0, 0.0),
            height_m if self.is_on else None,
            stamp_s,
            None if last_in_odom is None else _moved((x, y, yaw_rad), last_in_odom),
        )
        return replace(scan, height_m=float(z)), (x, y, yaw_rad)


def _moved(
    base: tuple[float, float, float], last_in_odom: tuple[Sequence[float], Sequence[float]]
) -> list[float]:
    """Return where the base was at the last beam (x, y, yaw), in its frame at the first."""
    (x, y, _), orientation = last_in_odom
    _, _, yaw_rad = roll_pitch_yaw_of(matrix_of_quaternion(orientation))
    return se2.between(base, (x, y, yaw_rad)).tolist()
