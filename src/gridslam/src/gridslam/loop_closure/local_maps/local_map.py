"""A local map of a stretch of the path: points with normals, and a table for correlation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gridslam import se2
from gridslam.kernels.correlation import fill_table, mark_free
from gridslam.kernels.surfaces import line_normals
from gridslam.maps.mapped_arrays import mapped_zeros
from gridslam.scan import PlanarScan

MARGIN_CELLS = 8
NEIGHBOUR_GAP_M = 0.3  # if ends are farther apart (or a tenth of the range), they are on two surfaces
NEIGHBOUR_GAP_SHARE = 0.1
NO_QUARTER, QUARTERS = 9.0, 12
"""The first stands for a missing normal, beside the quadrants -2 to 2. There are fewer than the second."""
SCANS_AT_ONCE = 64
"""More would need memory in proportion."""
PROFILE_SIGMAS = 3.6  # 255 exp(-3.6^2 / 2) rounds to 0


@dataclass(frozen=True)
class SurfacePoints:
    """Points where beams ended: points_xy_m (n, 2), and the unit normals of their surfaces, (n, 2).

    Normals point towards the lidar. A point without neighbours has the normal NaN.
    """

    points_xy_m: np.ndarray
    normals_xy: np.ndarray

    def moved(self, pose: np.ndarray) -> SurfacePoints:
        """Return the points as seen from the frame in which `pose` is given."""
        return SurfacePoints(
            se2.transform(pose, self.points_xy_m), se2.transform((0.0, 0.0, pose[2]), self.normals_xy)
        )


def surface_points(scan: PlanarScan, range_m: float) -> SurfacePoints:
    """Return a scan's ends nearer than `range_m`, in the base frame; normals come from neighbouring beams."""
    order = np.argsort(scan.angles_rad)
    ranges, angles = scan.ranges_m[order], scan.angles_rad[order]
    seen = np.isfinite(ranges) & (ranges < range_m)
    ranges, angles = ranges[seen], angles[seen]
    points = ranges[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    gaps, normals = np.maximum(NEIGHBOUR_GAP_M, NEIGHBOUR_GAP_SHARE * ranges), np.empty_like(points)
    line_normals(points, gaps, normals)
    return SurfacePoints(points, normals).moved(np.array(scan.lidar_in_base))


@dataclass(frozen=True)
class LocalMap:
    """A stretch of the path as a map of its own, in the frame of one node, its anchor.

    surface: points, thinned. table: (h, w, 2) uint8, FITS and CLASHES of a point in each cell. The corner of
    cell [0, 0] is at `origin_xy_m`; the cells' size is `resolution_m`.
    """

    anchor: int
    surface: SurfacePoints
    table: np.ndarray
    origin_xy_m: np.ndarray
    resolution_m: float

    @property
    def points_in_cells(self) -> np.ndarray:
        """(n, 2) the points in cells from the table's corner."""
        return (self.surface.points_xy_m - self.origin_xy_m) / self.resolution_m


class LocalMapSizes(NamedTuple):
    """How fine a local map is, and how far its beams reach."""

    resolution_m: float
    """Cells of the table."""
    blur_m: float
    """A point so far from a surface fits by exp(-1/2)."""
    point_spacing_m: float
    """About so far apart are the points that are kept."""
    range_m: float
    """Beams are used up to here."""


def build_local_map(
    anchor: int,
    surfaces: list[SurfacePoints],
    scans: list[PlanarScan],
    poses_in_anchor: np.ndarray,
    sizes: LocalMapSizes,
) -> LocalMap:
    """Build a local map from scans, their surface points and their poses (k, 3) in the anchor's frame."""
    resolution_m, blur_m, point_spacing_m, range_m = sizes
    frames = np.repeat(poses_in_anchor, [len(surface.points_xy_m) for surface in surfaces], axis=0)
    points = se2.transform_each(frames, np.concatenate([surface.points_xy_m for surface in surfaces]))
    frames[:, :2] = 0.0
    normals = se2.transform_each(frames, np.concatenate([surface.normals_xy for surface in surfaces]))
    lidars = se2.compose(poses_in_anchor, np.array([scan.lidar_in_base for scan in scans]))
    low = np.minimum(points.min(axis=0, initial=0.0), lidars[:, :2].min(axis=0)) - MARGIN_CELLS * resolution_m
    high = (
        np.maximum(points.max(axis=0, initial=0.0), lidars[:, :2].max(axis=0)) + MARGIN_CELLS * resolution_m
    )
    origin = np.floor(low / resolution_m) * resolution_m
    width, height = np.ceil((high - origin) / resolution_m).astype(int)
    free = mapped_zeros((height, width), np.bool_)
    for first in range(0, len(scans), SCANS_AT_ONCE):
        lot = slice(first, first + SCANS_AT_ONCE)
        ends, hits = _beam_ends(scans[lot], lidars[lot], range_m)
        ends, last = (ends - origin) / resolution_m, np.cumsum([len(scan.ranges_m) for scan in scans[lot]])
        for lidar, begin, end in zip(lidars[lot], [0, *last], last):
            mark_free((lidar[:2] - origin) / resolution_m, ends[begin:end], hits[begin:end], free)
    table = _table(points, free, origin, resolution_m, blur_m)
    thinned = _thin(points, normals, point_spacing_m)
    return LocalMap(anchor, thinned, table, origin, resolution_m)


def _beam_ends(scans: list[PlanarScan], lidars: np.ndarray, range_m: float) -> tuple[np.ndarray, np.ndarray]:
    """Return where the beams of all scans end (n, 2), and whether they hit something (n,)."""
    counts = [len(scan.ranges_m) for scan in scans]
    ranges, angles = (
        np.concatenate([getattr(scan, name) for scan in scans]) for name in ("ranges_m", "angles_rad")
    )
    hits = ranges < range_m
    # A beam without a return counts as free for half its length only.
    seen = np.repeat([0.5 * min(range_m, scan.range_max_m) for scan in scans], counts)
    frames = np.repeat(lidars, counts, axis=0)
    angles = angles + frames[:, 2]
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return frames[:, :2] + np.where(hits, ranges, seen)[:, None] * directions, hits


def _table(
    points: np.ndarray, free: np.ndarray, origin: np.ndarray, resolution_m: float, blur_m: float
) -> np.ndarray:
    table, fits = mapped_zeros((*free.shape, 2), np.uint8), mapped_zeros(free.shape, np.uint8)
    cells = np.floor((points - origin) / resolution_m).astype(np.int64)
    fill_table(cells, _profile(resolution_m, blur_m), free, fits, table)
    return table


def _profile(resolution_m: float, blur_m: float) -> np.ndarray:
    """The fits, 0..255, of the cells around a point: a Gaussian, cut off where it rounds to zero."""
    reach = math.ceil(PROFILE_SIGMAS * blur_m / resolution_m)
    offset = np.arange(-reach, reach + 1) * resolution_m
    squared = offset[:, None] ** 2 + offset[None, :] ** 2
    return np.rint(255.0 * np.exp(-0.5 * squared / blur_m**2)).astype(np.uint8)


def _thin(points: np.ndarray, normals: np.ndarray, spacing_m: float) -> SurfacePoints:
    """In each square of spacing_m keep the middle one of the points with normals in the same quadrant."""
    quarter = np.where(
        np.isfinite(normals[:, 0]),
        np.floor((np.arctan2(normals[:, 1], normals[:, 0]) + math.pi / 4) / (math.pi / 2)),
        NO_QUARTER,
    )
    columns, rows = np.floor(points / spacing_m).astype(np.int64).T
    rows -= rows.min(initial=0)
    # One number for each point sorts much faster than rows of three.
    key = (columns * (rows.max(initial=0) + 1) + rows) * QUARTERS + quarter.astype(np.int64)
    _, group, count = np.unique(key, return_inverse=True, return_counts=True)
    mean = np.stack([np.bincount(group, values) for values in points.T], axis=1) / count[:, None]
    normal = np.stack([np.bincount(group, values) for values in normals.T], axis=1)
    with np.errstate(invalid="ignore"):
        return SurfacePoints(mean, normal / np.linalg.norm(normal, axis=1, keepdims=True))
