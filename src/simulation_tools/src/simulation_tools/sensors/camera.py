"""A camera: colours, drawn by PyBullet's software renderer, or distances along the optical axis, by rays.

The camera looks along the x axis of its SDF frame with z up; the optical frame of the images has x to the
right, y down and z ahead (REP-103), see `sdf.frames.OPTICAL`.
"""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.geometry import Pose, rotate
from simulation_tools.sdf.elements import CameraSensor
from simulation_tools.world.world import PhysicsWorld, WorldError


class Camera:
    """One pinhole camera without distortion.

    focal_px: focal length; square pixels. centre_px: (x, y) of the optical axis; a whole number is the middle
    of a pixel. depth: whether it measures distances instead of colours.
    """

    def __init__(self, sensor: CameraSensor, rng: np.random.Generator) -> None:
        """Set the optics. rng: source of the noise."""
        self.width, self.height, self.depth = sensor.width, sensor.height, sensor.depth
        self.focal_px = 0.5 * sensor.width / math.tan(0.5 * sensor.horizontal_fov_rad)
        self.centre_px = (0.5 * (sensor.width - 1), 0.5 * (sensor.height - 1))
        self._near_m, self._far_m = sensor.near_m, sensor.far_m
        self._noise = sensor.noise
        self._rng = rng
        self._projection = _projection(
            self.focal_px, sensor.width, sensor.height, sensor.near_m, sensor.far_m
        )
        self._beams = self._beams_of_pixels() if sensor.depth else np.empty((0, 3))

    def read(self, world: PhysicsWorld, pose: Pose) -> np.ndarray:
        """Return a picture: uint8 (height, width, 3), or of a depth camera float32 (height, width), metres.

        Depth is along the optical axis, inf beyond the far plane. pose: of the camera in the world. A world
        for depth cameras has `visuals`, one for others is built with `drawn`.
        """
        if self.depth:
            return self._depths(world, pose)
        ahead, up = (rotate(pose.orientation_xyzw, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
        colours, _ = world.draw(pose.position_m, ahead, up, self._projection, (self.width, self.height))
        return self._noisy(colours)

    def _beams_of_pixels(self) -> np.ndarray:
        """Return (height * width, 3): from the camera to a metre ahead of it, for each pixel; axes x y z."""
        (cx, cy), (x, y) = self.centre_px, np.meshgrid(np.arange(self.width), np.arange(self.height))
        left, up = (cx - x.ravel()) / self.focal_px, (cy - y.ravel()) / self.focal_px
        return np.column_stack((np.ones(left.size), left, up))

    def _depths(self, world: PhysicsWorld, pose: Pose) -> np.ndarray:
        """Return depths (height, width); nothing before the near plane is seen."""
        if world.visuals is None:
            raise WorldError("A depth camera needs a world that was built with `seen`.")
        beams = self._beams @ pose.rotation.T
        lengths = np.linalg.norm(beams, axis=1)  # how long a beam is for a metre of depth
        origins = np.array(pose.position_m) + self._near_m * beams
        farthest_m = (self._far_m - self._near_m) * float(lengths.max())
        ranges_m = world.visuals.cast(origins, beams / lengths[:, None], farthest_m)
        metres = (self._near_m + ranges_m / lengths).reshape(self.height, self.width)
        nothing = metres >= self._far_m
        if self._noise.stddev > 0.0:
            metres += self._noise.mean + self._noise.stddev * self._rng.standard_normal(metres.shape)
        metres[nothing] = np.inf
        return np.maximum(metres, 0.0).astype(np.float32)

    def _noisy(self, colours: np.ndarray) -> np.ndarray:
        """Add the noise, which SDF gives as a share of full brightness."""
        if self._noise.stddev == 0.0 and self._noise.mean == 0.0:
            return np.ascontiguousarray(colours)
        noise = self._noise.mean + self._noise.stddev * self._rng.standard_normal(colours.shape)
        return np.clip(colours + 255.0 * noise, 0.0, 255.0).astype(np.uint8)


def _projection(focal_px: float, width: int, height: int, near_m: float, far_m: float) -> list[float]:
    """Return OpenGL's projection matrix, column by column.

    The renderer looks through the corners of the pixels; the terms 1/width and 1/height move the optical axis
    by half a pixel, so that it goes through the middle of the picture.
    """
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[0, 2] = 2.0 * focal_px / width, 1.0 / width
    matrix[1, 1], matrix[1, 2] = 2.0 * focal_px / height, 1.0 / height
    matrix[2, 2] = -(far_m + near_m) / (far_m - near_m)
    matrix[2, 3] = -2.0 * far_m * near_m / (far_m - near_m)
    matrix[3, 2] = -1.0
    return matrix.T.ravel().tolist()
