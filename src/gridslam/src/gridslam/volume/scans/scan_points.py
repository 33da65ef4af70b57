"""A scan of a planar lidar as a cloud, with the lidar's motion during the scan undone."""

from __future__ import annotations

import math

import numpy as np

from gridslam.errors import ScanError
from gridslam.scan import BEAMS_MAX
from gridslam.volume.clouds import Pose

BEYOND = 2.0
"""A beam without return ends at this many times the greatest range of the map's rays, which then cuts it.

Much farther, because scans that are gathered into one cloud have rays from places a little apart.
"""

ROUNDING = 1.0 + 1e-6
"""A message rounds its greatest range to float32, which may fall below the same number of a parameter."""


def points_of_scan(
    ranges_m: np.ndarray,
    angles_rad: tuple[float, float],
    limits_m: tuple[float, float],
    free_up_to_m: float,
    last_in_first: Pose | None = None,
) -> np.ndarray:
    """Return the ends of a scan's beams, float32 (n, 3), in the lidar's frame at the first beam.

    A beam without return (+inf) ends far beyond ``free_up_to_m``, so that the map's greatest range cuts it,
    if the lidar sees so far. Otherwise it tells nothing that the map could hold, and is left out.

    Args:
        ranges_m: (n,) by REP-117.
        angles_rad: angle of the first beam, and from beam to beam.
        limits_m: least and greatest range of the lidar.
        free_up_to_m: greatest range of the map's rays; below 0: they have none.
        last_in_first: the lidar at the last beam in its frame at the first; it turns and moves evenly between
            both. None: all beams are of one instant.

    Raises:
        ScanError: the scan makes no sense, or tells nothing.
    """
    ranges_m = np.asarray(ranges_m, float)
    least_m, greatest_m = limits_m
    if not 0 < len(ranges_m) <= BEAMS_MAX:
        raise ScanError(f"A scan has {len(ranges_m)} beams; from 1 to {BEAMS_MAX} can be mapped.")
    if not (all(map(math.isfinite, angles_rad)) and 0.0 <= least_m < greatest_m):
        raise ScanError("The angles of a scan are not finite, or its ranges not 0 <= min < max.")
    counts = (ranges_m >= least_m) & (ranges_m <= greatest_m) & np.isfinite(ranges_m)
    if 0.0 < free_up_to_m <= greatest_m * ROUNDING:
        no_return = (ranges_m > greatest_m) | np.isposinf(ranges_m)  # the greatest range may be +inf
        counts |= no_return
        ranges_m = np.where(no_return, BEYOND * free_up_to_m, ranges_m)
    if not counts.any():
        raise ScanError("A scan has no beam that tells anything.")
    beams = np.flatnonzero(counts)
    along_rad = angles_rad[0] + angles_rad[1] * beams
    level = np.zeros(len(beams))
    ends = ranges_m[beams, None] * np.stack((np.cos(along_rad), np.sin(along_rad), level), axis=1)
    if last_in_first is not None:
        ends = carried(ends, beams / max(len(ranges_m) - 1, 1), last_in_first)
    return ends.astype(np.float32)


def carried(points: np.ndarray, shares: np.ndarray, last: Pose) -> np.ndarray:
    """Return points (n, 3), each of the frame after a share (n,) of an even motion, in the first frame.

    Rodrigues' formula: each point turns about the motion's axis by its share of the angle.
    """
    turn_rad = last.turn_from(Pose.identity())
    shifts = shares[:, None] * last.translation
    if turn_rad < 1e-9:
        return points + shifts
    skew = last.rotation - last.rotation.T
    axis = np.array((skew[2, 1], skew[0, 2], skew[1, 0])) / (2.0 * math.sin(turn_rad))
    angles = shares[:, None] * turn_rad
    along = (points @ axis)[:, None] * axis
    turned = (
        points * np.cos(angles) + np.cross(axis, points) * np.sin(angles) + along * (1.0 - np.cos(angles))
    )
    return turned + shifts
