"""The camera on its gimbal: a pinhole without distortion, and how finely it draws a surface."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError
from inspection.camera.lens import Lens

BEYOND = 1.02
"""What is so much farther from the optical axis than the picture's corners is not in it."""


@dataclass(frozen=True)
class SurveyCamera:
    """A camera on a gimbal that tilts; the yaw is free, and it does not roll.

    Without a lens of its own it is a pinhole with square pixels.

    The optical frame has x to the right, y down and z ahead (REP-103). The optical axis meets the picture in
    its middle, ((width - 1) / 2, (height - 1) / 2); whole numbers are the middles of pixels.

    Raises:
        ParameterError: a value out of range, or tilts the wrong way round.
    """

    width: int = limited(5184, 16, 100_000)
    """Width of a picture, px."""
    height: int = limited(3888, 16, 100_000)
    """Height of a picture, px."""
    field_of_view: float = limited(60.0, 1.0, 150.0)
    """Field of view across the width, from edge to edge, deg."""
    tilt_min: float = limited(-90.0, -90.0, 90.0)
    """Lowest tilt of the gimbal, deg; 0 looks level, 90 straight up."""
    tilt_max: float = limited(90.0, -90.0, 90.0)
    """Highest tilt of the gimbal, deg; 0 looks level, 90 straight up."""
    exposure: float = limited(2.5e-4, 1e-6, 10.0)
    """Exposure time of one picture, s. A camera that moves meanwhile blurs."""
    lens: Lens | None = None
    """Lens of a real camera; None: a pinhole."""

    def __post_init__(self) -> None:
        check_parameters(self)
        if self.lens is not None:
            self.lens.check(self.width, self.height)
        if self.tilt_min > self.tilt_max:
            raise ParameterError(f"tilt_min {self.tilt_min:g} is above tilt_max {self.tilt_max:g} deg.")

    @property
    def focal_px(self) -> float:
        """Focal length, px: the mean of both directions."""
        if self.lens is not None:
            return math.sqrt(self.lens.focal_px[0] * self.lens.focal_px[1])
        return 0.5 * self.width / math.tan(0.5 * math.radians(self.field_of_view))

    @property
    def centre_px(self) -> tuple[float, float]:
        """Where the optical axis meets the picture: to the right, down."""
        if self.lens is not None:
            return self.lens.centre_px
        return 0.5 * (self.width - 1), 0.5 * (self.height - 1)

    @property
    def matrix(self) -> np.ndarray:
        """(3, 3) from places in the optical frame to px, as CameraInfo's K."""
        right_px, down_px = self.centre_px
        fx, fy = self.lens.focal_px if self.lens is not None else (self.focal_px, self.focal_px)
        return np.array(((fx, 0.0, right_px), (0.0, fy, down_px), (0.0, 0.0, 1.0)))

    @property
    def half_extents(self) -> tuple[float, float]:
        """Tangents of the angles from the optical axis to the picture's edges, to the side and down."""
        if self.lens is not None:
            aside = np.abs(self.rays(self._edge_px)[:, :2]).max(axis=0)
            return float(aside[0]), float(aside[1])
        return 0.5 * self.width / self.focal_px, 0.5 * self.height / self.focal_px

    @property
    def longest_ray(self) -> float:
        """Length of the longest line of sight of the picture, at depth 1."""
        return float(np.linalg.norm(self.rays(self._edge_px), axis=1).max())

    @property
    def _edge_px(self) -> np.ndarray:
        """(8, 2) corners of the picture, and the middles of its sides."""
        x, y = (
            (-0.5, 0.5 * (self.width - 1), self.width - 0.5),
            (-0.5, 0.5 * (self.height - 1), self.height - 0.5),
        )
        return np.array([(a, b) for a in x for b in y if (a, b) != (x[1], y[1])])

    def rays(self, pixels: np.ndarray) -> np.ndarray:
        """Return the lines of sight (n, 3) of pixels (n, 2), at depth 1 in the optical frame."""
        if self.lens is not None:
            aside = self.lens.asides(pixels)
        else:
            aside = (pixels - np.array(self.centre_px)) / self.focal_px
        return np.column_stack((aside, np.ones(len(aside))))

    def drawn(self, points_m: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the pixels (n, 2), x and y, of points (n, 3) in the optical frame, and which are drawn (n,).

        Those beside the picture or behind the camera are not; the pixels of the latter mean nothing.
        """
        is_ahead = points_m[:, 2] > 0.0
        aside = points_m[:, :2] / np.where(is_ahead, points_m[:, 2], 1.0)[:, None]
        if self.lens is not None:
            is_ahead = is_ahead & (np.hypot(*aside.T) < BEYOND * math.sqrt(self.longest_ray**2 - 1.0))
            pixels = self.lens.pixels(np.where(is_ahead[:, None], aside, 0.0))  # beyond, a model may fold
        else:
            pixels = aside * self.focal_px + self.centre_px
        is_drawn = is_ahead & ((pixels >= 0.0) & (pixels <= (self.width - 1, self.height - 1))).all(axis=1)
        return pixels, is_drawn

    def distance_m(self, resolution_mm: float, incidence_deg: float = 0.0) -> float:
        """Return the distance at which a surface in the middle of a picture has a resolution, mm per pixel.

        The resolution is that of the worst direction on the surface, which looks shorter by the cosine of
        the incidence: the angle between the surface's normal and the line of sight.
        """
        return 1e-3 * resolution_mm * self.focal_px * math.cos(math.radians(incidence_deg))


def optical_axes(yaw_rad: float, tilt_rad: float) -> np.ndarray:
    """Return (3, 3): in its columns the optical frame's x, y, z axes in the map, for a camera without roll.

    yaw_rad: of the view, anticlockwise from the map's x axis. tilt_rad: 0 is level, pi / 2 straight up.
    """
    sin_yaw, cos_yaw = math.sin(yaw_rad), math.cos(yaw_rad)
    sin_tilt, cos_tilt = math.sin(tilt_rad), math.cos(tilt_rad)
    right = (sin_yaw, -cos_yaw, 0.0)
    down = (cos_yaw * sin_tilt, sin_yaw * sin_tilt, -cos_tilt)
    ahead = (cos_yaw * cos_tilt, sin_yaw * cos_tilt, sin_tilt)
    return np.array((right, down, ahead)).T


def rolled(axes: np.ndarray, roll: float) -> np.ndarray:
    """Return the axes (3, 3) of an optical frame that is rolled to its right, rad, about where it looks."""
    cos, sin = math.cos(roll), math.sin(roll)
    turned: np.ndarray = axes @ np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
    return turned
