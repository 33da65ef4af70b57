"""One planar scan of any lidar, the filter's input."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Iterable

import numpy as np
from numpy.typing import ArrayLike

from gridslam.errors import ScanError

BEAMS_MAX = 100_000


@dataclass(frozen=True, eq=False)
class PlanarScan:
    """One levelled scan, already corrected for the lidar's mounting and the vehicle's attitude.

    Beams may be in any order and at any spacing. Raises ScanError when the scan cannot be interpreted.
    """

    stamp_s: float
    """s"""
    angles_rad: np.ndarray
    """(n,) bearing of each beam's end in the lidar's levelled frame."""
    ranges_m: np.ndarray
    """(n,) horizontal distance of each beam's end; +inf: no return. Dropped beams must not be in it."""
    lidar_in_base: tuple[float, float, float]
    """x, y in m and yaw in rad of the lidar's levelled frame in the base frame."""
    range_max_m: float
    """m: the lidar's range."""
    height_m: float = math.nan
    """Of the base in the odometry's frame; NaN: not known. Another height is another slice of the world."""

    def __post_init__(self) -> None:
        angles, ranges = _vector(self.angles_rad, "angles_rad"), _vector(self.ranges_m, "ranges_m")
        if angles.size != ranges.size:
            raise ScanError(f"The scan has {ranges.size} ranges but {angles.size} angles.")
        if ranges.size > BEAMS_MAX:
            raise ScanError(f"The scan has {ranges.size} beams, more than {BEAMS_MAX}; thin it out first.")
        if not np.isfinite(angles).all():
            raise ScanError("The scan's angles must be finite; drop the beams that have none.")
        if not (ranges >= 0.0).all():
            raise ScanError("The scan's ranges must be at least 0; drop NaN and negative ones.")
        if not math.isfinite(self.stamp_s):
            raise ScanError(f"The scan's stamp must be finite, not {self.stamp_s}.")
        if not 0.0 < self.range_max_m < math.inf:
            raise ScanError(f"The scan's range_max_m must be positive and finite, not {self.range_max_m}.")
        object.__setattr__(self, "lidar_in_base", _pose(self.lidar_in_base))
        object.__setattr__(self, "angles_rad", angles)
        object.__setattr__(self, "ranges_m", ranges)

    def sharing(self, other: PlanarScan) -> PlanarScan:
        """Return the same scan; if the other's angles are the same, they are in memory once."""
        if not np.array_equal(self.angles_rad, other.angles_rad):
            return self
        return replace(self, angles_rad=other.angles_rad)


def typical_range_m(scan: PlanarScan) -> float:
    """Return the median range of the beams that hit something, m; inf if none did."""
    hits = scan.ranges_m[scan.ranges_m < scan.range_max_m]
    return float(np.median(hits)) if len(hits) else math.inf


def _pose(values: Iterable[float]) -> tuple[float, float, float]:
    pose = tuple(float(value) for value in values)
    if len(pose) != 3 or not all(math.isfinite(value) for value in pose):
        raise ScanError(f"The scan's lidar_in_base must be finite x, y, yaw, not {pose}.")
    return pose[0], pose[1], pose[2]


def _vector(values: ArrayLike, name: str) -> np.ndarray:
    try:
        vector = np.ascontiguousarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ScanError(f"The scan's {name} must be numbers.") from None
    if vector.ndim != 1:
        raise ScanError(f"The scan's {name} must be one row, not an array of shape {vector.shape}.")
    return vector
