"""Where the camera was when it took a photograph, and how the picture is blurred."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Protocol, Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import optical_axes


class Viewpoint(Protocol):
    """Place, m, and direction of a camera without roll; see `optical_axes`."""

    @property
    def place_m(self) -> tuple[float, float, float]:
        """x, y, z in the map."""
        ...

    @property
    def yaw_rad(self) -> float:
        """Anticlockwise from the map's x axis."""
        ...

    @property
    def tilt_rad(self) -> float:
        """0 is level, pi / 2 straight up."""
        ...


@dataclass(frozen=True)
class PhotographPose:
    """A photograph: place_m (3,) of the camera; axes (3, 3), the optical frame's in its columns; its blur.

    blur_px: where the motion is not known. shift_m, turn_rad: of the camera during the exposure. name: of
    the photograph's file; empty: there is none, as of a plan. path: of its picture, whose white and black
    parts show nothing; None: there is no picture. off_m, off_rad: standard deviations of place and
    direction; 0: not told.
    """

    place_m: np.ndarray
    axes: np.ndarray
    blur_px: float = 0.0
    shift_m: float = 0.0
    turn_rad: float = 0.0
    name: str = ""
    path: Path | None = None
    off_m: float = 0.0
    off_rad: float = 0.0

    @classmethod
    def of_view(cls, view: Viewpoint) -> PhotographPose:
        """Return the photograph of a view that is taken from its own place."""
        return cls(np.array(view.place_m), optical_axes(view.yaw_rad, view.tilt_rad))

    @classmethod
    def of_pose(
        cls, place_m: Sequence[float], orientation_xyzw: Sequence[float], blur_px: float = 0.0
    ) -> PhotographPose:
        """Return the photograph of a camera at this pose of its optical frame."""
        return cls(np.array(place_m), Rotation.from_quat(orientation_xyzw).as_matrix(), blur_px)

    def moved(self, shift_m: float | None, turn_rad: float | None) -> PhotographPose:
        """Return it with a motion that counts in place of the blur in px, unless it is not known."""
        if shift_m is None or turn_rad is None:
            return self
        return replace(self, blur_px=0.0, shift_m=shift_m, turn_rad=turn_rad)

    def widths_m(self, footprints_m: np.ndarray, depths_m: np.ndarray, lengths: np.ndarray) -> np.ndarray:
        """Return (k,) how widely pixels are spread over the surface, blur included, m.

        footprints_m: (k,) of the pixels without blur. depths_m: (k,) along the optical axis. lengths: (k,) of
        the lines of sight up to depth 1. The motion is reckoned across the line of sight.
        """
        blur_m = self.shift_m * lengths + self.turn_rad * depths_m * lengths**2
        widths_m: np.ndarray = np.hypot(footprints_m * np.hypot(1.0, self.blur_px), blur_m)
        return widths_m
