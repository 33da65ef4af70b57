"""Links: relative poses of two scans that see the same surfaces, measured by aligning them."""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.kernels.links import Surfaces, measure
from gridslam.kernels.surfaces import surface_normals, thin_out
from gridslam.loop_closure.edge import Edge
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.scan import PlanarScan

CELL_M = 0.05
"""m: unit of the kernels that find surfaces."""
THIN_SPACING, THIN_DEPTH = 0.5, 2.0
"""CELL_M: beams that end within this on one surface are averaged."""
POINTS_MAX = 200
LINK_SIGMA_M, LINK_SIGMA_RAD = 0.005, 0.001
"""Least standard deviations of a link."""
LEAST_COVARIANCE = np.diag([LINK_SIGMA_M**2, LINK_SIGMA_M**2, LINK_SIGMA_RAD**2])


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
    surface_normals(points, np.empty(count, np.bool_), normals, flat)
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


def link(
    older: int,
    newer: int,
    scans: list[Surfaces],
    predicted: np.ndarray,
    parameters: LoopClosureParameters,
    is_pass: bool = False,
) -> Edge | None:
    """Align two nodes' scans; None if too few of the newer one's points fit the older one's.

    Args:
        older: node.
        newer: node.
        scans: of all nodes.
        predicted: (3,) the newer node's pose in the older's, or several (k, 3). The one that makes the most
            points fit counts.
        parameters: the link's.
        is_pass: the nodes are of different passes of a place. The prediction may be wrong by more then, and
            more must fit.
    """
    p, found = parameters, np.empty((3, 3))
    poses = np.array(predicted, float).reshape(-1, 3)
    is_found = measure(
        scans[older],
        scans[newer],
        poses,
        (p.link_pass_gate_m if is_pass else 0.0, p.link_gate_m),
        p.link_pass_share_min if is_pass else p.link_share_min,
        p.link_rms_max_m,
        p.match_points,
        p.match_sigma_m,
        found,
    )
    if not is_found:
        return None
    pose = poses[0]
    pose[2] = se2.wrap(pose[2])
    return Edge(older, newer, pose, found + LEAST_COVARIANCE)
