"""How sensors sit on the body, and vectors that go from one frame to another."""

from __future__ import annotations

import math
from typing import Callable, NamedTuple, Sequence

import numpy as np

from cepa.motion import Quaternion, Ranging, Vector3, rotation_matrix

UPRIGHT: Quaternion = (0.0, 0.0, 0.0, 1.0)


class PlaneTurn:
    """Takes plane vectors of one frame to another: a turn, and a mirror for a lidar upside down."""

    def __init__(self, yaw_rad: float, flipped: bool = False):
        self._yaw_rad, self.flipped = yaw_rad, flipped
        self._cos, self._sin = math.cos(yaw_rad), math.sin(yaw_rad)
        self._side = -1.0 if flipped else 1.0

    def upright(self) -> PlaneTurn:
        """Return the turn of a frame with the same x axis that is not upside down."""
        return PlaneTurn(self._yaw_rad)

    def apply(self, x: float, y: float) -> tuple[float, float]:
        """Take a vector of the source frame to the target frame."""
        y *= self._side
        return self._cos * x - self._sin * y, self._sin * x + self._cos * y

    def undo(self, x: float, y: float) -> tuple[float, float]:
        """Take a vector of the target frame to the source frame."""
        return self._cos * x + self._sin * y, self._side * (self._cos * y - self._sin * x)


class Mount(NamedTuple):
    """How a sensor sits on the body: its turn of the plane, and its whole pose in the body's frame."""

    turn: PlaneTurn
    position_m: Vector3
    orientation_xyzw: Quaternion

    @classmethod
    def of_pose(cls, position_m: Vector3, orientation_xyzw: Quaternion) -> Mount:
        """Return the mounting of a sensor with this pose in the body's frame; a unit quaternion."""
        x, y, z, w = orientation_xyzw
        yaw_rad = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
        return cls(PlaneTurn(yaw_rad, flipped=x * x + y * y > 0.5), position_m, orientation_xyzw)

    def upright(self) -> Mount:
        """Return the mounting of this sensor after half a turn around its x axis."""
        x, y, z, w = self.orientation_xyzw
        return Mount(self.turn.upright(), self.position_m, (w, z, -y, -x))

    def has_pose_of(self, other: Mount) -> bool:
        """Return whether both sensors have one frame."""
        return self[1:] == other[1:]


MountOf = Callable[[str], Mount]
"""Returns the mounting of the sensor with this frame; raises MountError while it is not known."""


def into_body(points_m: np.ndarray, mount: Mount) -> np.ndarray:
    """Return points (n, 3) of a sensor's frame in the body's."""
    return points_m @ rotation_matrix(mount.orientation_xyzw).T + mount.position_m


def out_of_body(points_m: np.ndarray, mount: Mount) -> np.ndarray:
    """Return points (n, 3) of the body's frame in a sensor's."""
    return (points_m - mount.position_m) @ rotation_matrix(mount.orientation_xyzw)


def in_lidar_frame(rangings: Sequence[Ranging], mount: Mount) -> list[Ranging]:
    """Return ranges of the body's frame in that of a lidar with this mounting."""
    if not rangings:
        return []
    turn = rotation_matrix(mount.orientation_xyzw)
    return [
        Ranging(
            _vector(out_of_body(np.array(ranging.origin_m), mount)),
            _vector(np.array(ranging.direction) @ turn),
            ranging.range_m,
            ranging.range_min_m,
            ranging.range_max_m,
        )
        for ranging in rangings
    ]


def _vector(values: np.ndarray) -> Vector3:
    x, y, z = values.tolist()
    return x, y, z
