"""Drops beams that end on floor or ceiling because the lidar tilts with its UAV.

A beam that ends on floor or ceiling tells nothing about obstacles at the UAV's height, so it is dropped. It
has shown only that its direction is free up to its end. If the UAV can stop within that distance, the
direction counts as free. Otherwise it counts as unseen. No beam that ends between floor and ceiling is
dropped.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from cepa.errors import AttitudeError
from cepa.parameters import CepaParameters
from cepa.scan import LaserScan2D
from cepa.thesis.cushion import stopping_distance

Vector3 = tuple[float, float, float]


@dataclass(frozen=True)
class LidarAttitude:
    """How the lidar leans, and how high it is, at the instant of its scan.

    Raises AttitudeError unless ``up_xyz`` is a unit vector and ``height_m`` finite.
    """

    up_xyz: Vector3
    """The world's z axis (unit vector) in the lidar's frame. The beams lie in that frame's x-y plane."""
    height_m: float
    """z of the lidar in the frame in which ``floor_height`` and ``ceiling_height`` count."""

    def __post_init__(self) -> None:
        if not (abs(math.hypot(*self.up_xyz) - 1.0) < 0.01 and math.isfinite(self.height_m)):
            raise AttitudeError(
                f"The lidar's up must be a unit vector and its height finite, "
                f"not {tuple(map(float, self.up_xyz))} and {self.height_m} m."
            )

    @classmethod
    def of_mounted(
        cls,
        body_z_m: float,
        body_xyzw: Sequence[float],
        mount_xyz_m: Sequence[float] = (0.0, 0.0, 0.0),
        mount_xyzw: Sequence[float] = (0.0, 0.0, 0.0, 1.0),
    ) -> LidarAttitude:
        """Return the attitude of a lidar that is mounted on a body.

        Args:
            body_z_m: height of the body in the world.
            body_xyzw: orientation of the body in the world, a unit quaternion.
            mount_xyz_m: position of the lidar in the body's frame.
            mount_xyzw: orientation of the lidar in the body's frame, a unit quaternion.

        Raises:
            AttitudeError: an orientation is not a unit quaternion.
        """
        for name, q in (("body", body_xyzw), ("mounting", mount_xyzw)):
            if not abs(math.hypot(*q) - 1.0) < 0.01:
                raise AttitudeError(
                    f"The {name}'s orientation must be a unit quaternion, not {tuple(map(float, q))}."
                )
        up_in_body = _third_row(body_xyzw)
        height_m = body_z_m + sum(up * offset for up, offset in zip(up_in_body, mount_xyz_m))
        columns = zip(*_rotation(mount_xyzw))
        x, y, z = (sum(a * b for a, b in zip(column, up_in_body)) for column in columns)
        return cls((x, y, z), height_m)


def levelled(
    scan: LaserScan2D, attitude: LidarAttitude, parameters: CepaParameters, own_speed: float
) -> LaserScan2D:
    """Return the scan without the beams that end on floor or ceiling.

    A dropped beam becomes free (+inf) if it ends beyond `needed_sight`. Otherwise it becomes unseen.

    Args:
        scan: of a lidar that may lean.
        attitude: of that lidar.
        parameters: heights of floor and ceiling, and how the UAV brakes.
        own_speed: of the UAV, m/s.
    """
    climb = climbs(scan, attitude.up_xyz)
    ends_on = _ends_on_floor_or_ceiling(scan.ranges, climb, attitude.height_m, parameters)
    if not ends_on.any():
        return scan
    ahead = scan.ranges * np.sqrt(np.clip(1.0 - climb * climb, 0.0, None))
    unseen = ends_on & (ahead < needed_sight(parameters, own_speed))
    ranges = np.where(ends_on, np.inf, scan.ranges)
    return replace(scan, ranges=ranges, seen=scan.seen & ~unseen)


def climbs(scan: LaserScan2D, up_xyz: Vector3) -> np.ndarray:
    """Return by how much each beam rises per metre of its length, (n,)."""
    angles = scan.angle_min + np.arange(scan.ranges.size) * scan.angle_increment
    return up_xyz[0] * np.cos(angles) + up_xyz[1] * np.sin(angles)


def needed_sight(parameters: CepaParameters, own_speed: float) -> float:
    """Return how far a direction must have been seen to count as free, m."""
    p = parameters
    stopping = stopping_distance(own_speed, p.braking_deceleration, p.braking_latency)
    return max(stopping + p.r_lb, p.emergency_lookahead + p.body_radius)


def _ends_on_floor_or_ceiling(
    ranges: np.ndarray, climb: np.ndarray, height_m: float, parameters: CepaParameters
) -> np.ndarray:
    """Return (n,) bool; a lidar that is within the margin of a surface cannot tell what belongs to it."""
    lowest = parameters.floor_height + parameters.floor_margin
    highest = parameters.ceiling_height - parameters.floor_margin
    with np.errstate(invalid="ignore"):  # without a return there is no end, and with NaN no comparison holds
        ends_m = height_m + np.where(np.isfinite(ranges) & (ranges > 0.0), ranges, np.nan) * climb
        return ((ends_m <= lowest) & (height_m > lowest)) | ((ends_m >= highest) & (height_m < highest))


def _rotation(q: Sequence[float]) -> tuple[Vector3, Vector3, Vector3]:
    """Return the rows of the rotation matrix of a unit quaternion (x, y, z, w)."""
    x, y, z, w = q
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
        (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
        _third_row(q),
    )


def _third_row(q: Sequence[float]) -> Vector3:
    """Return the world's z axis in the frame that a unit quaternion (x, y, z, w) turns into the world."""
    x, y, z, w = q
    return 2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)
