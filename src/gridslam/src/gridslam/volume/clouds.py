"""Clouds that are kept with nodes of the path: thinned, and packed small."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from gridslam.errors import ScanError

PER_VOXEL = 32
"""A kept point is rounded to this part of a voxel."""
COORDINATE_MAX = 32767
"""Of a kept point, in these parts, from the sensor."""
LEVEL = 1
"""zlib's fastest."""


@dataclass(frozen=True, eq=False)
class Pose:
    """Of one frame in another: rotation (3, 3) and translation (3,), m."""

    rotation: np.ndarray
    translation: np.ndarray

    def __matmul__(self, other: Pose) -> Pose:
        """Return the pose of the other's frame in this one's parent."""
        return Pose(self.rotation @ other.rotation, self.rotation @ other.translation + self.translation)

    def inverse(self) -> Pose:
        """Return the pose of the parent in this frame."""
        return Pose(self.rotation.T, -self.rotation.T @ self.translation)

    def of_points(self, points: np.ndarray) -> np.ndarray:
        """Return points (n, 3) of this frame in the parent's, rounded to float32."""
        return (points.astype(float) @ self.rotation.T + self.translation).astype(np.float32)

    def turn_from(self, other: Pose) -> float:
        """Return the angle between the two rotations, rad."""
        cosine = (np.trace(self.rotation.T @ other.rotation) - 1.0) / 2.0
        return float(np.arccos(np.clip(cosine, -1.0, 1.0)))

    @classmethod
    def identity(cls) -> Pose:
        """Return the pose of a frame in itself."""
        return cls(np.eye(3), np.zeros(3))

    @classmethod
    def level(cls, x: float, y: float, yaw: float, z: float = 0.0) -> Pose:
        """Return a pose that turns about z only."""
        cosine, sine = np.cos(yaw), np.sin(yaw)
        return cls(
            np.array(((cosine, -sine, 0.0), (sine, cosine, 0.0), (0.0, 0.0, 1.0))), np.array((x, y, z))
        )

    @classmethod
    def of_quaternion(cls, translation: np.ndarray, xyzw: np.ndarray) -> Pose:
        """Return a pose of a translation (3,) and a quaternion, which need not be of unit length.

        Raises:
            ScanError: it has no direction, or a number is not finite.
        """
        quaternion, length = np.asarray(xyzw, float), float(np.linalg.norm(xyzw))
        if not (np.isfinite(translation).all() and np.isfinite(length) and length > 1e-6):
            raise ScanError("The sensor's pose is not finite, or its quaternion has no length; check /tf.")
        x, y, z, w = quaternion / length
        rotation = np.array(
            (
                (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)),
                (2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)),
                (2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)),
            )
        )
        return cls(rotation, np.asarray(translation, float))


@dataclass(frozen=True, eq=False)
class KeptCloud:
    """Points in the sensor's frame, rounded to a part of a voxel."""

    packed: bytes
    count: int
    step_m: float
    """Unit of the packed coordinates."""

    @classmethod
    def of(cls, points: np.ndarray, resolution_m: float) -> KeptCloud:
        """Keep points (n, 3) of the sensor's frame that `rounded` gave."""
        step_m = step_of(resolution_m)
        whole = np.rint(points / step_m).astype(np.int16)
        return cls(zlib.compress(_shuffled(whole), LEVEL), len(points), step_m)

    def points(self) -> np.ndarray:
        """Return them (n, 3), float32."""
        data = np.frombuffer(zlib.decompress(self.packed), np.uint8).reshape(3, 2, self.count)
        folded = data[:, 0] | data[:, 1].astype(np.uint16) << 8
        bends = (folded >> 1).view(np.int16) ^ -(folded & 1).view(np.int16)
        steps = np.cumsum(bends, axis=1, dtype=np.int16)
        return np.cumsum(steps, axis=1, dtype=np.int16).T * np.float32(self.step_m)


def step_of(resolution_m: float) -> float:
    """Return the unit of kept coordinates, m."""
    return resolution_m / PER_VOXEL


def rounded(points: np.ndarray, resolution_m: float) -> np.ndarray:
    """Return points (n, 3) as they are kept, float32, without those that are not finite or too far away."""
    with np.errstate(invalid="ignore"):
        whole = np.rint(np.asarray(points, np.float32) / np.float32(step_of(resolution_m)))
        keep = (np.abs(whole) <= COORDINATE_MAX).all(axis=1)
    return whole[keep] * np.float32(step_of(resolution_m))


def _shuffled(whole: np.ndarray) -> bytes:
    """Return int16 (n, 3) as second differences, signs last, low and high bytes apart: zlib packs these well.

    Neighbours along a ring lie on a line, nearly. Small numbers of both signs have a high byte of 0.
    """
    steps = np.diff(whole.T, axis=1, prepend=np.int16(0))
    bends = np.diff(steps, axis=1, prepend=np.int16(0))
    folded = np.ascontiguousarray((bends << 1) ^ (bends >> 15))
    return np.ascontiguousarray(folded.view(np.uint8).reshape(3, -1, 2).transpose(0, 2, 1)).tobytes()
