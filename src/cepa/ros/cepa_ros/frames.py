"""Mountings of sensors, and turns of velocities into the body frame, by TF."""

from __future__ import annotations

import math

import numpy as np

from cepa import MountError
from cepa.keep_out import MapPose
from cepa.motion import rotation_matrix
from cepa.steering.mount import Mount, PlaneTurn
from input_checks.carried_frames import CarriedFrames
from node_tools.newest_transforms import FrameError, NewestTransforms

LEVEL_COSINE = math.cos(math.radians(20.0))
"""A lidar whose axis leans more than this does not scan the plane in which CEPA steers."""


class Frames:
    """Turns of the horizontal plane between frames, by the newest transforms."""

    def __init__(self, base_frame: str) -> None:
        self._base_frame = base_frame.lstrip("/")
        self._mounts: dict[str, Mount] = {}
        self._carried = CarriedFrames()
        self._transforms = NewestTransforms(heard=self._carried.add)

    def restart(self) -> None:
        """Forget moving transforms, as after a clock that jumped back. Mountings of lidars stay known."""
        self._carried.forget()
        self._transforms.restart()

    def lidar_mount(self, frame: str) -> Mount:
        """Return how the lidar sits on the base frame. TF is asked once for each frame.

        Raises:
            MountError: TF does not know it yet, or the lidar does not lie flat.
        """
        if frame not in self._mounts:
            mount = self._look_up(frame)
            x, y, _, _ = mount.orientation_xyzw
            lean_cosine = 1.0 - 2.0 * (x * x + y * y)
            if abs(lean_cosine) < LEVEL_COSINE:
                lean = math.degrees(math.acos(lean_cosine))
                raise MountError(
                    f'The lidar "{frame}" leans by {lean:.0f} degrees; CEPA needs one that lies flat.'
                )
            self._mounts[frame] = mount
        return self._mounts[frame]

    def mount(self, frame: str) -> Mount:
        """Return how a sensor sits on the base frame, in whatever attitude.

        Raises:
            MountError: TF does not know it (yet), or the vehicle does not carry the frame.
        """
        mount = self._look_up(frame)
        if lacks := self._carried.lacks(self._base_frame, frame.lstrip("/")):
            raise MountError(lacks)
        return mount

    def yaw_turn(self, frame: str) -> PlaneTurn:
        """Return how a levelled velocity of ``frame`` turns into the base frame, by its newest yaw.

        Raises:
            MountError: TF does not know it (yet).
        """
        return self._look_up(frame).turn

    def map_pose(self, map_frame: str, odometry_frame: str) -> MapPose:
        """Return the pose of the odometry's frame in the map, by the newest transforms.

        Raises:
            MountError: TF does not know it (yet).
        """
        try:
            found = self._transforms.look_up(map_frame, odometry_frame)
        except FrameError as error:
            raise MountError(str(error)) from None
        return MapPose(rotation_matrix(found.rotation_xyzw), np.array(found.translation_m))

    def _look_up(self, frame: str) -> Mount:
        try:
            found = self._transforms.look_up(self._base_frame, frame or self._base_frame)
        except FrameError as error:
            raise MountError(str(error)) from None
        return Mount.of_pose(found.translation_m, found.rotation_xyzw)
