"""The flat surfaces that scans show, for aligning two scans with each other."""

from __future__ import annotations

from typing import Iterable

import numpy as np

from gridslam import se2
from gridslam.kernels.links import Scans, Surfaces
from gridslam.kernels.surfaces import surface_normals, thin_out
from gridslam.scan import PlanarScan

CELL_M = 0.05
"""m: unit of the kernels that find surfaces."""
THIN_SPACING, THIN_DEPTH = 0.5, 2.0
"""CELL_M: beams that end within this on one surface are averaged."""
POINTS_MAX = 200


def surfaces_of(scan: PlanarScan, range_m: float) -> Surfaces:
    """Return the points of a scan, nearer than `range_m`, that lie on flat surfaces, in the base frame."""
    order = np.argsort(scan.angles_rad % (2.0 * np.pi), kind="stable")
    bearings, ranges = scan.angles_rad[order] % (2.0 * np.pi), scan.ranges_m[order]
    hits = np.isfinite(ranges) & (ranges < range_m) & (ranges > 0.0)
    bearings, ranges = bearings[hits], ranges[hits] / CELL_M
    thin_bearings, thin_ranges = np.empty_like(bearings), np.empty_like(ranges)
    count = thin_out(bearings, ranges, THIN_SPACING, THIN_DEPTH, thin_bearings, thin_ranges)
    bearings, ranges = thin_bearings[:count], thin_ranges[:count]
    points = ranges[:, None] * np.column_stack([np.cos(bearings), np.sin(bearings)])
    normals, flat = np.empty_like(points), np.empty(count, np.bool_)
    surface_normals(points, np.empty(count, np.bool_), normals, flat, False)
    normals *= np.where((normals * points).sum(axis=1) > 0.0, -1.0, 1.0)[:, None]
    lidar = np.array(scan.lidar_in_base)
    in_map = se2.wrap(bearings + lidar[2])
    kept = np.flatnonzero(flat)
    kept = kept[np.argsort(in_map[kept], kind="stable")]
    if len(kept) > POINTS_MAX:
        kept = kept[np.linspace(0, len(kept) - 1, POINTS_MAX).astype(int)]
    return Surfaces(
        se2.transform(lidar, points[kept] * CELL_M),
        se2.transform((0.0, 0.0, lidar[2]), normals[kept]),
        in_map[kept],
        lidar[:2].copy(),
    )


class ScanSurfaces:
    """The surfaces of a path's scans."""

    def __init__(self, scans: Iterable[Surfaces] = ()) -> None:
        self.arrays = Scans(
            np.empty((0, 2)), np.empty((0, 2)), np.empty(0), np.empty((0, 2)), np.zeros(1, int)
        )
        """The kernels' input."""
        self._count = 0
        for surfaces in scans:
            self.append(surfaces)

    def __len__(self) -> int:
        return self._count

    def append(self, surfaces: Surfaces) -> None:
        """Add the next scan."""
        scan, begin = self._count, int(self.arrays.starts[self._count])
        end = begin + len(surfaces.points)
        points, normals, bearings, lidars, starts = self.arrays
        self.arrays = Scans(
            _with_room(points, end),
            _with_room(normals, end),
            _with_room(bearings, end),
            _with_room(lidars, scan + 1),
            _with_room(starts, scan + 2),
        )
        for array, values in zip(self.arrays[:3], surfaces[:3]):
            array[begin:end] = values
        self.arrays.lidars[scan], self.arrays.starts[scan + 1] = surfaces.lidar, end
        self._count += 1


def _with_room(array: np.ndarray, least: int) -> np.ndarray:
    """Return an array, or a copy with at least this many rows."""
    if len(array) >= least:
        return array
    grown = np.empty((max(least, 2 * len(array)), *array.shape[1:]), array.dtype)
    grown[: len(array)] = array
    return grown
