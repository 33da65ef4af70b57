"""The part of a scan that lies near the level plane, whatever the attitude of the lidar.

A lidar that nods looks at walls, floor and ceiling in turn. Avoidance and SLAM in the plane need what stands
at the UAV's own height. So each beam's end is projected from above. What lies too high or too low counts as
unseen there, not as free.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ScanError
from flight_basics.geometry import Quaternion, Vector3, rotate, yaw_of
from inspection_tools.scan import FULL_TURN_RAD, ScanGeometry, check_range_limits

SAME_RAD, SAME_M = 0.003, 0.003
"""A lidar nearer than this to its level frame is level: its scans pass unchanged."""


@dataclass(frozen=True)
class LevelBeamsParameters:
    """What counts as near the level plane.

    Raises:
        ParameterError: a value out of range.
    """

    height: float = limited(0.2, 0.0, 10.0)
    """A beam's end counts if it is not farther than this above or below the lidar, m."""
    slope: float = limited(0.035, 0.0, 0.5)
    """A beam that is not steeper than this counts at any range, rad."""

    def __post_init__(self) -> None:
        check_parameters(self)


@dataclass(frozen=True)
class LevelFrame:
    """A frame that is fixed on the vehicle, at the lidar and without its lean. Scans of it are level.

    Attributes:
        translation_m: (x, y, z) in the base frame.
        yaw_rad: About the base frame's z.
    """

    translation_m: Vector3
    yaw_rad: float

    @classmethod
    def below(cls, translation_m: Vector3, rotation_xyzw: Quaternion) -> LevelFrame:
        """Return the frame for a lidar whose pose in the base frame is known.

        Raises:
            ScanError: the lidar hangs upside down, or on its side.
        """
        if rotate(rotation_xyzw, (0.0, 0.0, 1.0))[2] < 0.5:
            raise ScanError("A lidar that nods must stand upright; the beams of this one are not levelled.")
        return cls(translation_m, yaw_of(rotation_xyzw))

    def pose_of(self, translation_m: Vector3, rotation_xyzw: Quaternion) -> tuple[np.ndarray, np.ndarray]:
        """Return rotation (3, 3) and translation (3,) in this frame, of a pose in the base frame."""
        cosine, sine = math.cos(self.yaw_rad), math.sin(self.yaw_rad)
        turn = np.array(((cosine, sine, 0.0), (-sine, cosine, 0.0), (0.0, 0.0, 1.0)))
        axes = [rotate(rotation_xyzw, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))]
        return turn @ np.array(axes).T, turn @ (np.array(translation_m) - np.array(self.translation_m))


def level_part(
    ranges_m: np.ndarray,
    geometry: ScanGeometry,
    limits_m: tuple[float, float],
    rotation: np.ndarray,
    translation_m: np.ndarray,
    parameters: LevelBeamsParameters,
) -> np.ndarray:
    """Return the scan as the level frame has it, float32 (n,), on the same grid of beams.

    A direction in which nothing tells of the level plane is NaN. If several beams fall into one, the nearest
    end counts. -inf (too close) is kept in any attitude.

    Args:
        ranges_m: (n,) by REP-117.
        geometry: of the beams.
        limits_m: least and greatest range of the lidar.
        rotation: (3, 3) of the lidar in the level frame.
        translation_m: (3,) likewise.
        parameters: see there.

    Raises:
        ScanError: the scan makes no sense.
    """
    check_range_limits(*limits_m)
    ranges_m = np.asarray(ranges_m, np.float32)
    if len(ranges_m) != geometry.beams:
        raise ScanError(f"The scan has {len(ranges_m)} ranges for {geometry.beams} beams.")
    if _is_level(rotation, translation_m):
        return ranges_m
    angles_rad = geometry.angle_min_rad + geometry.angle_increment_rad * np.arange(geometry.beams)
    directions = np.stack((np.cos(angles_rad), np.sin(angles_rad)), axis=1) @ rotation[:, :2].T
    least_m, greatest_m = limits_m
    has_end = (ranges_m >= least_m) & (ranges_m <= greatest_m)  # NaN fails
    ends = np.where(has_end, ranges_m, 0.0)[:, None] * directions + translation_m
    reach_m = np.hypot(ends[:, 0], ends[:, 1])
    is_near = np.abs(ends[:, 2]) <= np.maximum(parameters.height, reach_m * math.tan(parameters.slope))
    is_flat = np.abs(directions[:, 2]) <= math.sin(parameters.slope)
    too_close, no_return = ranges_m == -np.inf, ranges_m > greatest_m
    values = np.where(has_end, np.maximum(reach_m, least_m), np.where(too_close, -np.inf, np.inf))
    tells = (has_end & is_near) | too_close | (no_return & is_flat)
    aims = np.where(has_end[:, None], ends, directions)
    bins = _bins(np.arctan2(aims[:, 1], aims[:, 0]), geometry)
    return _nearest(bins, values, tells & (bins < geometry.beams), geometry.beams)


def is_whole(rotation: np.ndarray, parameters: LevelBeamsParameters) -> bool:
    """Return whether all beams of a lidar with this rotation (3, 3) in the level frame are near its plane."""
    return bool(math.hypot(rotation[2, 0], rotation[2, 1]) <= math.sin(parameters.slope))


def _is_level(rotation: np.ndarray, translation_m: np.ndarray) -> bool:
    turn = max(abs(rotation[2, 0]), abs(rotation[2, 1]), abs(rotation[1, 0]))
    return bool(turn <= SAME_RAD and np.abs(translation_m).max() <= SAME_M)


def _bins(azimuths_rad: np.ndarray, geometry: ScanGeometry) -> np.ndarray:
    """Return the beams (n,) nearest to azimuths; beyond the scan's ends, a number that no beam has."""
    step = geometry.angle_increment_rad
    turned = (azimuths_rad - geometry.angle_min_rad) * math.copysign(1.0, step)
    half = abs(step) / 2.0
    return np.rint((np.mod(turned + half, FULL_TURN_RAD) - half) / abs(step)).astype(np.int64)


def _nearest(bins: np.ndarray, values_m: np.ndarray, counts: np.ndarray, beams: int) -> np.ndarray:
    nearest = np.full(beams, np.inf, np.float32)
    np.minimum.at(nearest, bins[counts], values_m[counts].astype(np.float32))
    is_told = np.zeros(beams, bool)
    is_told[bins[counts]] = True
    nearest[~is_told] = np.nan
    return nearest
