"""What a photograph should show of the surface, by its pose: edges, distance, angle."""

from __future__ import annotations

from typing import Callable

import numpy as np
from scipy import ndimage

from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.parameters import FindingParameters

STEP_PX = 8
"""Between two rays."""
STEP_M, ALIKE = 0.01, np.cos(np.radians(20.0))
"""Neighbouring rays meet two surfaces if one point is so far off the other's plane, or they face apart."""
ALONG = np.sin(np.radians(15.0))
"""A line that comes nearer to an edge by less than this share of its length runs along it."""

Look = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray, np.ndarray]]
"""From pixels (n, 2) to points (n, 3), NaN where there is none, normals and unit rays."""


class Sight:
    """The surface behind a photograph, at every eighth pixel.

    Attributes:
        judged: (rows, columns) where cracks are looked for: near enough, not too flat, and off edges.
        finest_mm: the least that a pixel covers in its worst direction; inf: there is no surface.
        detail_mm: the median of that where cracks are looked for; inf: nowhere.
    """

    def __init__(
        self, look: Look, eye_m: np.ndarray, camera: SurveyCamera, parameters: FindingParameters
    ) -> None:
        self._p = p = parameters
        x = np.arange(0, camera.width + STEP_PX, STEP_PX)
        y = np.arange(0, camera.height + STEP_PX, STEP_PX)
        pixels = np.stack(np.meshgrid(x, y), axis=-1)
        points, normals, rays = (each.reshape(*pixels.shape[:2], 3) for each in look(pixels.reshape(-1, 2)))
        far_m = np.linalg.norm(points - eye_m, axis=2)
        steep = -(normals * rays).sum(axis=2)
        with np.errstate(invalid="ignore", divide="ignore"):
            detail_mm = 1e3 * far_m / camera.focal_px / np.maximum(steep, 1e-6)
            fine = (detail_mm <= p.crack_detail) & (steep > np.cos(np.radians(p.crack_incidence)))
        self.finest_mm = float(np.min(detail_mm, initial=np.inf, where=np.isfinite(detail_mm)))
        self._apart_px = STEP_PX * ndimage.distance_transform_edt(~_edges(points, normals))
        self._margin_px = np.where(
            np.isfinite(far_m), camera.focal_px * (np.radians(p.pose_turned) + p.pose_off / far_m), 0.0
        )
        self.judged = (fine[:-1, :-1] & (self._apart_px > p.keep_off)).astype(bool)
        judged_mm = detail_mm[:-1, :-1][self.judged]
        self.detail_mm = float(np.median(judged_mm)) if len(judged_mm) else np.inf

    def judges(self, pixels: np.ndarray) -> np.ndarray:
        """Return whether cracks are looked for at pixels (n, 2)."""
        column, row = np.clip(pixels // STEP_PX, 0, np.array(self.judged.shape[::-1]) - 1).astype(int).T
        return self.judged[row, column]

    def forget_edges(self) -> None:
        """Free the memory of what `is_edge` needs, some 5 MB for 20 MP; then nothing is an edge."""
        self._apart_px, self._margin_px = np.full((1, 1), np.inf), np.zeros((1, 1))

    def is_edge(self, pixels: np.ndarray) -> bool:
        """Return whether a line of pixels (n, 2) may be an edge of the surface, for the pose may be off."""
        column, row = np.clip(pixels // STEP_PX, 0, np.array(self._apart_px.shape[::-1]) - 1).astype(int).T
        apart_px, margin_px = self._apart_px[row, column], self._margin_px[row, column]
        near = apart_px <= self._p.keep_off + margin_px
        if near.mean() < 0.5:
            return False
        length_px = float(np.hypot(*np.ptp(pixels[near], axis=0)))
        return bool(np.ptp(apart_px[near]) < ALONG * length_px + STEP_PX)


def _edges(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return which cells between four rays (rows, columns, 3) do not lie on one plane."""
    first, facing = points[:-1, :-1], normals[:-1, :-1]
    edges = np.zeros(first.shape[:2], bool)
    for other in (
        (slice(1, None), slice(None, -1)),
        (slice(None, -1), slice(1, None)),
        (slice(1, None),) * 2,
    ):
        off_m = ((points[other] - first) * facing).sum(axis=2)
        edges |= ~(np.abs(off_m) < STEP_M)  # NaN: no surface
        edges |= (normals[other] * facing).sum(axis=2) < ALIKE
    return edges
