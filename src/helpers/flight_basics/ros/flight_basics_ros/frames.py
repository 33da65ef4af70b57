"""Transforms velocities and poses to a node's frame by TF."""

from __future__ import annotations

import math

import rospy

from flight_basics.geometry import Quaternion, Vector3, normalised, yaw_of
from node_tools.newest_transforms import NewestTransforms

Vector2 = tuple[float, float]


class Frames:
    """The newest transforms between frames. It subscribes to TF at the first look-up."""

    def __init__(self) -> None:
        self._transforms: NewestTransforms | None = None

    def listen(self) -> NewestTransforms:
        """Subscribe to TF at once, so that the first look-up can succeed."""
        if self._transforms is None:
            self._transforms = NewestTransforms(listen_to_moving=True)
        return self._transforms

    def look_up(self, target: str, source: str) -> tuple[Vector3, Quaternion]:
        """Return translation (x, y, z) and unit quaternion (x, y, z, w) that take ``source`` to ``target``.

        Raises:
            FrameError: TF does not know it (yet).
            PoseError: it is not a rotation.
        """
        found = self.listen().look_up(target, source)
        return found.translation_m, normalised(found.rotation_xyzw)

    def look_up_at(self, target: str, source: str, stamp: rospy.Time) -> tuple[Vector3, Quaternion]:
        """Return the same by what was known at a stamp, see `NewestTransforms.look_up_at`."""
        found = self.listen().look_up_at(target, source, stamp)
        return found.translation_m, normalised(found.rotation_xyzw)

    def turn(self, vector_xy: Vector2, target: str, source: str) -> Vector2:
        """Return a levelled vector (x, y) of ``source`` in ``target``, rotated by yaw only.

        Raises:
            FrameError, PoseError: as ``look_up``.
        """
        if source in ("", target):
            return vector_xy
        yaw_rad = yaw_of(self.look_up(target, source)[1])
        x, y = vector_xy
        return (
            math.cos(yaw_rad) * x - math.sin(yaw_rad) * y,
            math.sin(yaw_rad) * x + math.cos(yaw_rad) * y,
        )
