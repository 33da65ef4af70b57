"""Where the lidar is and how it moves, for algorithms that remember."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Sequence

import numpy as np

from cepa.errors import MotionError

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
LEVEL: Quaternion = (0.0, 0.0, 0.0, 1.0)
"""Of a frame whose axes are those of the odometry's."""


class Doubt(NamedTuple):
    """What of the odometry may be drift, because no IMU confirms it."""

    turn: bool
    """About the vertical."""
    shift: bool


DOUBTED = Doubt(True, True)


@dataclass(frozen=True)
class Motion:
    """The lidar's pose and velocity in the odometry's frame at a scan's stamp, and the vertical reference.

    Raises MotionError for what is not finite, or an orientation that is none.
    """

    stamp_s: float
    """s: of the scan."""
    position_m: Vector3
    """m: of the lidar in the odometry's frame, z up."""
    orientation_xyzw: Quaternion
    """Of the lidar's frame in the odometry's; a unit quaternion."""
    velocity_m_s: Vector3
    """m/s: of the UAV along the axes of the odometry's frame."""
    climb_ref_m_s: float = 0.0
    """m/s: vertical part of the reference velocity, upwards."""
    age_s: float = 0.0
    """s: how much older than the scan pose and velocity are."""
    doubt: Doubt = DOUBTED
    """What of the odometry may be drift."""

    def __post_init__(self) -> None:
        numbers = (self.stamp_s, *self.position_m, *self.velocity_m_s, self.climb_ref_m_s, self.age_s)
        if not all(map(math.isfinite, numbers)):
            given = tuple(map(float, numbers))
            raise MotionError(f"The UAV's motion must be finite, not {given}; check the odometry.")
        if not abs(math.hypot(*self.orientation_xyzw) - 1.0) < 0.01:
            given = tuple(map(float, self.orientation_xyzw))
            raise MotionError(f"The lidar's orientation is not a unit quaternion: {given}.")
        if not self.age_s >= 0.0:
            raise MotionError(f"The odometry is {-self.age_s:.3g} s newer than the scan; check its stamps.")

    @classmethod
    def of_mounted(
        cls,
        stamp_s: float,
        body_position_m: Sequence[float],
        body_xyzw: Sequence[float],
        body_velocity_m_s: Sequence[float],
        mount_position_m: Sequence[float] = (0.0, 0.0, 0.0),
        mount_xyzw: Sequence[float] = (0.0, 0.0, 0.0, 1.0),
        climb_ref_m_s: float = 0.0,
        age_s: float = 0.0,
        doubt: Doubt = DOUBTED,
    ) -> Motion:
        """Return the motion of a lidar that is mounted on a body.

        Args:
            stamp_s: of the scan.
            body_position_m: of the body in the odometry's frame.
            body_xyzw: orientation of the body there, a unit quaternion.
            body_velocity_m_s: of the body along its own axes, as in an odometry message.
            mount_position_m: of the lidar in the body's frame.
            mount_xyzw: orientation of the lidar in the body's frame, a unit quaternion.
            climb_ref_m_s: see the field.
            age_s: see the field.
            doubt: see the field.

        Raises:
            MotionError: as the class.
        """
        body = rotation_matrix(body_xyzw)
        position = body @ np.asarray(mount_position_m) + np.asarray(body_position_m)
        (a, b, c, d), (x, y, z, w) = body_xyzw, mount_xyzw
        orientation = (
            d * x + a * w + b * z - c * y,
            d * y - a * z + b * w + c * x,
            d * z + a * y - b * x + c * w,
            d * w - a * x - b * y - c * z,
        )
        velocity = body @ np.asarray(body_velocity_m_s)
        vectors = tuple(position.tolist()), orientation, tuple(velocity.tolist())
        return cls(stamp_s, *vectors, climb_ref_m_s, age_s, doubt)

    @property
    def yaw_rad(self) -> float:
        """Direction of the lidar's x axis in the odometry's plane."""
        x, y, z, w = self.orientation_xyzw
        return math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))

    def moved(self, way_m: np.ndarray, turn_rad: float = 0.0) -> Motion:
        """Return this motion after a way (3,) along the odometry's axes and a turn about their z axis.

        These bring it up to date.
        """
        (x, y, z), (along_x, along_y, along_z) = self.position_m, way_m.tolist()
        place_m = x + along_x, y + along_y, z + along_z
        c, s = math.cos(0.5 * turn_rad), math.sin(0.5 * turn_rad)
        qx, qy, qz, qw = self.orientation_xyzw
        turned = (c * qx - s * qy, c * qy + s * qx, c * qz + s * qw, c * qw - s * qz)
        return Motion(self.stamp_s, place_m, turned, self.velocity_m_s, self.climb_ref_m_s, doubt=self.doubt)

    def rotation(self) -> np.ndarray:
        """Return the matrix (3, 3) that turns the lidar's frame into the odometry's."""
        return rotation_matrix(self.orientation_xyzw)


@dataclass(frozen=True, eq=False)
class Cloud:
    """What a lidar or camera saw in three dimensions. Raises MotionError for points of a wrong shape."""

    points_m: np.ndarray
    """(n, 3) m, in the lidar's frame; rows that are not finite are no returns."""
    elevation_rad: tuple[float, float]
    """Lowest and highest direction that it looks in, in the lidar's frame."""
    range_min_m: float
    range_max_m: float
    azimuth_rad: tuple[float, float] = (-math.pi, math.pi)
    """First and last direction around its z axis."""
    own_m: np.ndarray | None = None
    """(n, 3) m: where it saw the UAV itself, which is no obstacle; what is behind it is unseen."""

    @property
    def looks_all_around(self) -> bool:
        """Whether its azimuth is a full turn, but for a beam or two."""
        return self.azimuth_rad[1] - self.azimuth_rad[0] > 2.0 * math.pi - 0.05

    def __post_init__(self) -> None:
        points = np.asarray(self.points_m)
        if points.ndim != 2 or points.shape[1] != 3:
            raise MotionError(f"A cloud must hold rows of x, y and z, not an array of shape {points.shape}.")
        if not 0.0 <= self.range_min_m < self.range_max_m:
            raise MotionError(
                f"A cloud's ranges must fulfil 0 <= min < max, not {self.range_min_m} and {self.range_max_m}."
            )
        if not self.elevation_rad[0] < self.elevation_rad[1]:
            raise MotionError(f"A cloud's elevations must rise, not {self.elevation_rad}.")


@dataclass(frozen=True)
class Ranging:
    """What a range finder measured. Raises MotionError for what makes no sense."""

    origin_m: Vector3
    """m: of the sensor in the lidar's frame."""
    direction: Vector3
    """Unit vector in the lidar's frame."""
    range_m: float
    """m; as REP-117: inf: nothing up to range_max_m; -inf: nearer than range_min_m; NaN: invalid."""
    range_min_m: float
    range_max_m: float

    def __post_init__(self) -> None:
        if not 0.0 <= self.range_min_m < self.range_max_m < math.inf:
            raise MotionError(
                f"A range finder's limits must fulfil 0 <= min < max, not {self.range_min_m} and "
                f"{self.range_max_m}; check its driver."
            )
        if not abs(math.hypot(*self.direction) - 1.0) < 0.01 or not all(map(math.isfinite, self.origin_m)):
            raise MotionError(f"A range finder's pose makes no sense: {self.origin_m}, {self.direction}.")

    @property
    def free_m(self) -> float:
        """How far the beam has passed, m."""
        if self.range_m > self.range_max_m:
            return self.range_max_m
        return self.range_m if self.range_m >= self.range_min_m else 0.0  # NaN fails, too


def rotation_matrix(orientation_xyzw: Sequence[float]) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a unit quaternion."""
    x, y, z, w = orientation_xyzw
    return np.array(
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    )
