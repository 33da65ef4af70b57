"""The flat surfaces that scans show, for aligning two scans with each other."""

from __future__ import annotations

from typing import Iterable

import numpy as np

from gridslam import se2
from gridslam.kernels.links import OPEN_SHARE, Scans, Surfaces
from gridslam.kernels.surfaces import surface_normals, thin_out
from gridslam.scan import PlanarScan

CELL_M = 0.05
"""m: unit of the kernels that find surfaces."""
THIN_SPACING, THIN_DEPTH = 0.5, 2.0
"""CELL_M: beams that end within this on one surface are averaged."""
POINTS_MAX = 200
NONE = np.empty((0, 2)), np.empty((0, 2)), np.empty(0)
"""No points, normals and bearings."""


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


def is_open(surfaces: Surfaces) -> bool:
    """Return whether a scan tells no place along some direction, as in a bare corridor.

    Normals of single beams err too much to tell that: where beams are dense, noise turns them, and a bare
    wall seems to measure itself along.
    """
    normals = surfaces.normals
    return len(normals) == 0 or np.linalg.eigvalsh(normals.T @ normals)[0] < OPEN_SHARE * len(normals)


class ScanSurfaces:
    """The surfaces of several scans.

    Args:
        scans: the surfaces of each.
        nodes: (k,) of the path at which each was taken, ascending; None: 0, 1, 2 ...
    """

    def __init__(self, scans: Iterable[Surfaces], nodes: np.ndarray | None = None) -> None:
        columns = [*zip(*scans)] or [()] * 4
        points, normals, bearings = (np.concatenate([none, *each]) for none, each in zip(NONE, columns))
        starts = np.cumsum([0, *map(len, columns[0])])
        self.arrays = Scans(points, normals, bearings, np.reshape(columns[3], (-1, 2)), starts)
        """The kernels' input."""
        self._nodes = nodes

    def places(self, nodes: np.ndarray) -> np.ndarray:
        """Return at which places the scans of some nodes are, for an array of any shape."""
        return nodes if self._nodes is None else np.searchsorted(self._nodes, nodes)
