"""The errors of a map of voxels: distance from true surfaces, what is missing, what is wrongly free."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from gridslam.errors import EvaluationError
from gridslam.evaluation.volume.surface import Surface
from gridslam.evaluation.volume.visibility import LidarView, Places, in_sight, visible_samples

SAMPLE_M, NEAR_SAMPLE_M = 0.1, 0.05
"""One point of the true surfaces for each square of this side: for what is visible, and for distances."""
MARGIN_M = 1.0
"""Surfaces farther than this from the map's bounds are nearest to none of its voxels."""
PLACES_M = 0.5
"""Places of the lidar that are nearer to each other are not tried twice."""
FREE_VOXELS = 100_000
"""Of more free voxels as many are drawn."""


@dataclass(frozen=True)
class Voxels:
    """A map: centres (n, 3) of occupied and (m, 3) of free voxels in the world's frame, and their size."""

    occupied_m: np.ndarray
    free_m: np.ndarray
    resolution_m: float


@dataclass(frozen=True)
class VolumeError:
    """Distances are those of occupied voxels' centres from the nearest true surface."""

    occupied_voxels: int
    mean_m: float
    p95_m: float
    max_m: float
    within_a_voxel: float
    """Share of the occupied voxels that lie at most one voxel from a surface, 0..1."""
    mapped: float = math.nan
    """Share of the visible true surface with an occupied voxel within one voxel, 0..1; NaN: not asked."""
    mapped_by_part: dict[str, float] = field(default_factory=dict)
    """The same for each thing of the world that could be seen."""
    free_right: float = math.nan
    """Share of the free voxels that the lidar could really look into, 0..1."""

    def as_dict(self) -> dict:
        """Return the figures under the names that result files use."""
        return {
            "occupied_voxels": self.occupied_voxels,
            "volume_error_mean_m": self.mean_m,
            "volume_error_p95_m": self.p95_m,
            "volume_error_max_m": self.max_m,
            "occupied_within_a_voxel_share": self.within_a_voxel,
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
    places, view = places.thinned(PLACES_M), view or LidarView()
    samples = surface.samples(SAMPLE_M, rng, *_around(places.positions_m, view.range_max_m))
    seen = visible_samples(surface, samples, places, view, rng)
    mapped = _has_voxel(samples.points_m[seen], voxels)
    part = surface.part[samples.triangles[seen]]
    by_part = {surface.names[k]: float(mapped[part == k].mean()) for k in np.unique(part)}
    free = voxels.free_m
    if len(free) > FREE_VOXELS:
        free = free[rng.choice(len(free), FREE_VOXELS, replace=False)]
    return VolumeError(
        **figures,
        mapped=float(mapped.mean()) if len(mapped) else math.nan,
        mapped_by_part=by_part,
        free_right=float(in_sight(surface, free, places, rng).mean()) if len(free) else math.nan,
    ), distances


def _around(points_m: np.ndarray, margin_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the lowest and the highest corner of a box around points, with a margin."""
    return points_m.min(axis=0) - margin_m, points_m.max(axis=0) + margin_m


def _has_voxel(points_m: np.ndarray, voxels: Voxels) -> np.ndarray:
    """Return which points lie in an occupied voxel or in a neighbour of one, corners included."""
    reach = 1.5 * voxels.resolution_m
    apart, _ = cKDTree(voxels.occupied_m).query(points_m, p=np.inf, distance_upper_bound=reach + 1e-9)
    return apart <= reach
