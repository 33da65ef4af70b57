"""From the scan of a planar lidar, in any mounting on a leaning UAV, to a levelled `PlanarScan`.

Each beam is rotated by the lidar's mounting and by the attitude of the base frame, and projected from above.
So walls keep their places. Beams that hit the floor are dropped, because they would show as walls.
"""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import NoUsableBeamError, ScanError
from gridslam.inputs.attitude import matrix_of_lean, matrix_of_quaternion
from gridslam.scan import PlanarScan

LidarPose = np.ndarray | tuple[Sequence[float], Sequence[float]]
"""A (4, 4) matrix, or translation (x, y, z) and unit quaternion (x, y, z, w)."""

FLOOR_CLEARANCE_M = 0.15
"""A beam that ends less than this (or half the lidar's height) above the floor has hit it."""
BEYOND_M = 0.05
"""The farthest return of a lidar without a greatest range is so much nearer than the range it gets."""
TURN_MAX_RAD = 3.0 * math.pi
"""A scan spans a full turn, or a little more."""
STEEPEST_RAD = math.radians(45.0)
"""A beam steeper than this sees ceiling or floor, not walls."""


def project(
    ranges_m: np.ndarray,
    angle_min_rad: float,
    angle_increment_rad: float,
    range_min_m: float,
    range_max_m: float,
    lidar_in_base: LidarPose,
    attitude_rad: tuple[float, float] = (0.0, 0.0),
    height_m: float | None = None,
    stamp_s: float = 0.0,
    moved: Sequence[float] | None = None,
) -> PlanarScan:
    """Return a scan projected from above, in the levelled base frame.

    Ranges follow REP-117: +inf no return (kept), -inf too close and NaN invalid (dropped). Older drivers
    report no return by a finite range above ``range_max_m``. Ranges below ``range_min_m`` are dropped. A
    driver without a greatest range (pointcloud_to_laserscan) gives +inf; then beams without a return are
    known to be free only as far as the scan's farthest return.

    Args:
        ranges_m: (n,) as measured along the beams.
        angle_min_rad: angle of the first beam about the lidar's z axis.
        angle_increment_rad: from beam to beam, of either sign.
        range_min_m: least range that the lidar measures.
        range_max_m: greatest range that the lidar measures, or +inf.
        lidar_in_base: pose of the lidar in the base frame; it may be off-centre, inclined or upside down.
        attitude_rad: (roll, pitch) of the base frame.
        height_m: of the base frame's origin over a flat floor; beams that end at the floor are dropped. None:
            not known, no beam is dropped for that.
        stamp_s: when the scan was taken, by its first beam.
        moved: x, y in m and yaw in rad: where the base was at the last beam, in its frame at the first, on an
            even motion. All beams come out as if they were measured at the first. None: they were.

    Raises:
        ScanError: the scan's geometry, the mounting or the attitude makes no sense.
        NoUsableBeamError: no beam is usable.
    """
    ranges_m = np.asarray(ranges_m, dtype=np.float64)
    _check(ranges_m, angle_min_rad, angle_increment_rad, range_min_m, range_max_m)
    if math.isinf(range_max_m):
        range_max_m = _farthest_m(ranges_m, range_min_m)
    rotation, translation_xyz = _mounting(lidar_in_base)
    levelling = _lean(attitude_rad)
    rotation, translation_xyz = levelling @ rotation, levelling @ translation_xyz
    yaw_rad = math.atan2(rotation[1, 0], rotation[0, 0])

    bearings_rad, slopes = _directions(ranges_m.size, angle_min_rad, angle_increment_rad, rotation, yaw_rad)
    ranges_m = np.where(ranges_m > range_max_m, np.inf, ranges_m)
    usable = (ranges_m >= range_min_m) & (np.abs(slopes) <= math.sin(STEEPEST_RAD))
    if height_m is not None:
        usable &= ~_hits_floor(ranges_m, slopes, height_m + translation_xyz[2])
    if not usable.any():
        raise NoUsableBeamError(
            "No beam of the scan is usable: all are invalid, too close, steep or at the floor."
        )
    lidar = (float(translation_xyz[0]), float(translation_xyz[1]), yaw_rad)
    bearings_rad, level_m = bearings_rad[usable], ranges_m[usable] * np.sqrt(1.0 - slopes[usable] ** 2)
    if moved is not None:
        shares = np.linspace(0.0, 1.0, ranges_m.size)[usable]
        bearings_rad, level_m = _straightened(bearings_rad, level_m, shares, lidar, moved)
    return PlanarScan(
        stamp_s=stamp_s,
        angles_rad=bearings_rad,
        ranges_m=level_m,
        lidar_in_base=lidar,
        range_max_m=range_max_m,
    )


def _straightened(
    bearings_rad: np.ndarray,
    ranges_m: np.ndarray,
    shares: np.ndarray,
    lidar: tuple[float, float, float],
    moved: Sequence[float],
) -> tuple[np.ndarray, np.ndarray]:
    """Return bearings and ranges (n,) as the lidar would have measured them before it moved.

    shares: (n,) of the motion, at each beam.
    """
    if np.shape(moved) != (3,) or not np.isfinite(moved).all():
        raise ScanError(f"The motion during the scan must be finite x, y, yaw, not {moved}.")
    then = se2.between(lidar, se2.compose(shares[:, None] * np.asarray(moved, float), lidar))
    turned = se2.wrap(bearings_rad + then[:, 2])
    hits = np.isfinite(ranges_m)
    x, y = then[:, :2].T + np.where(hits, ranges_m, 0.0) * np.stack((np.cos(turned), np.sin(turned)))
    return np.where(hits, np.arctan2(y, x), turned), np.where(hits, np.hypot(x, y), np.inf)


def _farthest_m(ranges_m: np.ndarray, range_min_m: float) -> float:
    """Return just more than the farthest return of a scan. Raises NoUsableBeamError when there is none."""
    returns_m = ranges_m[np.isfinite(ranges_m) & (ranges_m > range_min_m)]
    if not returns_m.size:
        raise NoUsableBeamError("No beam of the scan has a return, and its range_max is not finite.")
    return float(returns_m.max()) + BEYOND_M


def _directions(
    count: int, angle_min_rad: float, angle_increment_rad: float, rotation: np.ndarray, yaw_rad: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return (n,) bearings in the levelled lidar's frame and (n,) sines of the elevation."""
    angles_rad = angle_min_rad + angle_increment_rad * np.arange(count)
    in_lidar = np.stack((np.cos(angles_rad), np.sin(angles_rad)))
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    unturned = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ rotation
    x, y, slopes = unturned[:, :2] @ in_lidar
    return np.arctan2(y, x), np.clip(slopes, -1.0, 1.0)


def _hits_floor(ranges_m: np.ndarray, slopes: np.ndarray, lidar_height_m: float) -> np.ndarray:
    """Return (n,) whether a return came from the floor. A lidar that is not above the floor sees none."""
    if lidar_height_m <= 0.0:
        return np.zeros(ranges_m.shape, dtype=bool)
    climbs_m = np.zeros(ranges_m.shape)
    np.multiply(ranges_m, slopes, out=climbs_m, where=(slopes < 0.0) & np.isfinite(ranges_m))
    return lidar_height_m + climbs_m < min(FLOOR_CLEARANCE_M, lidar_height_m / 2.0)


def _mounting(lidar_in_base: LidarPose) -> tuple[np.ndarray, np.ndarray]:
    """Return the (3, 3) rotation and (3,) translation of a pose in either form."""
    if isinstance(lidar_in_base, tuple) and len(lidar_in_base) == 2:
        translation_xyz = np.asarray(lidar_in_base[0], dtype=np.float64)
        rotation = matrix_of_quaternion(lidar_in_base[1])
    else:
        matrix = np.asarray(lidar_in_base, dtype=np.float64)
        if matrix.shape != (4, 4):
            raise ScanError(
                f"The lidar's pose has shape {matrix.shape}; give a 4 x 4 matrix or (xyz, quaternion xyzw)."
            )
        rotation, translation_xyz = matrix[:3, :3], matrix[:3, 3]
        if not np.allclose(rotation @ rotation.T, np.eye(3), atol=1e-6) or np.linalg.det(rotation) < 0.0:
            raise ScanError("The lidar's pose holds no rotation: its upper left 3 x 3 is not orthonormal.")
    if translation_xyz.shape != (3,) or not np.isfinite(translation_xyz).all():
        raise ScanError("The lidar's position in the base frame is not three finite numbers.")
    return rotation, translation_xyz


def _lean(attitude_rad: tuple[float, float]) -> np.ndarray:
    roll_rad, pitch_rad = attitude_rad
    if not (math.isfinite(roll_rad) and math.isfinite(pitch_rad)):
        raise ScanError(f"The attitude (roll {roll_rad:g}, pitch {pitch_rad:g}) is not finite.")
    return matrix_of_lean(roll_rad, pitch_rad)


def _check(
    ranges_m: np.ndarray,
    angle_min_rad: float,
    angle_increment_rad: float,
    range_min_m: float,
    range_max_m: float,
) -> None:
    if ranges_m.ndim != 1 or ranges_m.size == 0:
        raise ScanError(f"The scan's ranges have shape {ranges_m.shape}; they must be a row of numbers.")
    if not (math.isfinite(angle_min_rad) and math.isfinite(angle_increment_rad)):
        raise ScanError("angle_min and angle_increment of the scan must be finite.")
    if angle_increment_rad == 0.0 and ranges_m.size > 1:
        raise ScanError("angle_increment of the scan is 0, so that all its beams have one direction.")
    span_rad = abs(angle_increment_rad) * (ranges_m.size - 1)
    if span_rad > TURN_MAX_RAD:
        raise ScanError(
            f"The scan's beams span {span_rad:.0f} rad, more than a full turn; angle_min and angle_increment "
            "must be in radians."
        )
    if not 0.0 <= range_min_m < range_max_m:  # NaN fails, too
        raise ScanError(
            f"range_min {range_min_m:g} and range_max {range_max_m:g} of the scan are not 0 <= min < max."
        )
