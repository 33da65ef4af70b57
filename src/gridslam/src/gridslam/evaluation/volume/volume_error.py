"""The errors of a map of voxels: distance from true surfaces, what is missing, what is wrongly free."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from gridslam.errors import EvaluationError
from gridslam.evaluation.volume.surface import Surface
from gridslam.evaluation.volume.visibility import LidarView, Places, in_sight, reached_box, visible_samples
from gridslam.evaluation.volume.voxels import Voxels

SAMPLE_M, NEAR_SAMPLE_M = 0.1, 0.05
"""One point of the true surfaces for each square of this side: for what is visible, and for distances."""
MARGIN_M = 1.0
"""Surfaces farther than this from the map's bounds are nearest to none of its voxels."""
PLACES_M = 0.5
"""Places of the lidar that are nearer to each other are not tried twice, unless the lidar has turned."""
TURN_MIN_DEG, TURN_MAX_DEG = 1.0, 15.0
"""The turn that makes a place another one: as wide as the beams, within these bounds."""


@dataclass(frozen=True)
class VolumeError:
    """Distances are those of occupied voxels' centres from the nearest true surface."""

    occupied_voxels: int
    mean_m: float
    p95_m: float
    max_m: float
    within_a_voxel: float
    """Share of the occupied voxels that lie at most one voxel from a surface, 0..1."""
    visible_m2: float = math.nan
    """Area of the true surface that the lidar could see; NaN: not asked."""
    mapped: float = math.nan
    """Share of the visible true surface with an occupied voxel within one voxel, 0..1; NaN: not asked."""
    mapped_by_part: dict[str, float] = field(default_factory=dict)
    """The same for each thing of the world that could be seen."""
    free_right: float = math.nan
    """Share of the free voxels that the lidar could really look into, 0..1."""

    def as_dict(self) -> dict:
        """Return the figures under the names that result files use; without a path, fewer."""
        figures = {
            "occupied_voxels": self.occupied_voxels,
            "volume_error_mean_m": self.mean_m,
            "volume_error_p95_m": self.p95_m,
            "volume_error_max_m": self.max_m,
            "occupied_within_a_voxel_share": self.within_a_voxel,
        }
        if math.isnan(self.visible_m2):
            return figures
        return {
            **figures,
            "visible_surface_m2": self.visible_m2,
            "visible_surface_mapped_share": self.mapped,
            "free_right_share": self.free_right,
            "mapped_share_by_part": self.mapped_by_part,
        }


def volume_error(
    voxels: Voxels,
    surface: Surface,
    rng: np.random.Generator,
    places: Places | None = None,
    view: LidarView | None = None,
) -> tuple[VolumeError, np.ndarray]:
    """Judge a map of voxels.

    Args:
        voxels: the map, in the surface's frame.
        surface: the true surfaces.
        rng: draws samples.
        places: where the lidar was; None: what it could have seen is not judged.
        view: the lidar's beams.

    Returns:
        The errors, and each occupied voxel's distance (n,) in m from the nearest surface.

    Raises:
        EvaluationError: no voxel of the map is occupied.
    """
    if not len(voxels.occupied_m):
        raise EvaluationError("The map has no occupied voxel, so there is nothing to judge.")
    near = surface.samples(NEAR_SAMPLE_M, rng, *_around(voxels.occupied_m, MARGIN_M))
    if not len(near.points_m):
        raise EvaluationError("The world has no surface where the map is. Are both in the same frame?")
    distances = surface.distances_m(voxels.occupied_m, near)
    figures: dict[str, Any] = {
        "occupied_voxels": len(distances),
        "mean_m": float(distances.mean()),
        "p95_m": float(np.percentile(distances, 95)),
        "max_m": float(distances.max()),
        "within_a_voxel": float((distances <= voxels.resolution_m).mean()),
    }
    if places is None:
        return VolumeError(**figures), distances
    return VolumeError(**figures, **_coverage(voxels, surface, rng, places, view or LidarView())), distances


def _coverage(
    voxels: Voxels, surface: Surface, rng: np.random.Generator, places: Places, view: LidarView
) -> dict[str, Any]:
    """Return what of the visible surface is mapped, and what of the free voxels is right."""
    low_deg, high_deg = view.elevation_deg
    turn_deg = float(np.clip(high_deg - low_deg, TURN_MIN_DEG, TURN_MAX_DEG))
    apart = places.thinned(PLACES_M)
    samples = surface.samples(SAMPLE_M, rng, *reached_box(surface, apart, view, rng))
    seen = visible_samples(surface, samples, places.thinned(PLACES_M, turn_deg), view, rng)
    mapped = _has_voxel(samples.points_m[seen], voxels)
    part = surface.part[samples.triangles[seen]]
    free = voxels.free_m
    return {
        "visible_m2": float(seen.sum() * SAMPLE_M**2),
        "mapped": float(mapped.mean()) if len(mapped) else math.nan,
        "mapped_by_part": {surface.names[k]: float(mapped[part == k].mean()) for k in np.unique(part)},
        "free_right": float(in_sight(surface, free, apart, rng).mean()) if len(free) else math.nan,
    }


def _around(points_m: np.ndarray, margin_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest corner of a box around points, with a margin."""
    return points_m.min(axis=0) - margin_m, points_m.max(axis=0) + margin_m


def _has_voxel(points_m: np.ndarray, voxels: Voxels) -> np.ndarray:
    """Return which points lie in an occupied voxel or in a neighbour of one, corners included."""
    reach = 1.5 * voxels.resolution_m
    centres, points = voxels.occupied_m @ voxels.axes, points_m @ voxels.axes
    apart, _ = cKDTree(centres).query(points, p=np.inf, distance_upper_bound=reach + 1e-9)
    return apart <= reach
