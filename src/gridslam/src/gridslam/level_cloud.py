"""What a lidar saw in space with a scan, levelled: by it loop closure knows a place again, and its height."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np

from gridslam.cloud_odometry.plane_map import thinned
from gridslam.errors import ScanError
from gridslam.inputs.attitude import matrix_of_lean, matrix_of_quaternion

UNIT_M = 0.005
"""m: points are kept as multiples of this."""
SPACING_M, POINTS_MAX = 0.25, 2500
"""m: of the points in a cube of this side one is kept; the side doubles until there are few enough."""
REACH_M = 100.0
"""m: points are kept up to here."""


@dataclass(frozen=True, eq=False)
class LevelCloud:
    """Points in the level frame at the base: its origin and its heading, with z up.

    Raises:
        ValueError: the arrays are of another kind.
    """

    units: np.ndarray
    """(n, 3) int16, in `UNIT_M`."""
    lidar_m: np.ndarray
    """(3,) m: of the lidar."""

    def __post_init__(self) -> None:
        if self.units.dtype != np.int16 or self.units.ndim != 2 or self.units.shape[1] != 3:
            raise ValueError("a kept cloud's points are not (n, 3) of int16")
        if self.lidar_m.shape != (3,) or not np.isfinite(self.lidar_m).all():
            raise ValueError("a kept cloud's lidar is at no place")

    @property
    def points_m(self) -> np.ndarray:
        """(n, 3) m."""
        return UNIT_M * self.units

    @classmethod
    def of(
        cls,
        points_m: np.ndarray,
        lidar_in_base: tuple[Sequence[float], Sequence[float]],
        lean_rad: tuple[float, float],
    ) -> LevelCloud:
        """Return a cloud levelled and thinned.

        Args:
            points_m: (n, 3) in the lidar's frame. Those that are not finite do not count.
            lidar_in_base: (xyz, quaternion xyzw) of the lidar's frame in the base frame.
            lean_rad: roll and pitch of the base.

        Raises:
            ScanError: the cloud makes no sense.
        """
        if points_m.ndim != 2 or points_m.shape[1] != 3:
            raise ScanError(f"A cloud must be (n, 3) points, not of shape {points_m.shape}.")
        used = points_m[np.square(points_m).sum(axis=1) <= REACH_M**2]  # NaN is not
        kept, side_m = thinned(np.ascontiguousarray(used, dtype=float), SPACING_M), SPACING_M
        while len(kept) > POINTS_MAX:
            side_m *= 2.0
            kept = thinned(kept, side_m)
        level = matrix_of_lean(*lean_rad)
        lidar_m = level @ np.asarray(lidar_in_base[0], float)
        in_base = kept @ (level @ matrix_of_quaternion(lidar_in_base[1])).T + lidar_m
        return cls(np.round(in_base / UNIT_M).astype(np.int16), lidar_m)
