"""Builds the local maps of stretches of the path."""

from __future__ import annotations

from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.loop_closure.local_maps.local_map import (
    LocalMap,
    LocalMapSizes,
    SurfacePoints,
    build_local_map,
    surface_points,
)
from gridslam.loop_closure.local_maps.refinement import match_information, normal_matrix, without_weakest
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.recent import Recent
from gridslam.maps.scan_surfaces import is_open, surfaces_of
from gridslam.scan import PlanarScan

SCAN_SPACING_M, SCAN_SPACING_RAD = 0.25, 0.2  # closer scans add nothing to a local map
SURFACES_MAX = 256
"""The surfaces of so many scans are kept: of several local maps. They take four times a scan's memory."""


class LocalMaps:
    """Has the scans of a path, and measures their surfaces."""

    def __init__(self, parameters: LoopClosureParameters) -> None:
        self._parameters = parameters
        self._scans: Sequence[PlanarScan] = ()
        self._surfaces: Recent[SurfacePoints] = Recent(self._measured, SURFACES_MAX)
        self._informations: list[np.ndarray] = []

    def extend(self, scans: Sequence[PlanarScan]) -> None:
        """Take in the scans at all nodes of a path, of which the first ones may be known."""
        self._scans = scans
        for node in range(len(self._informations), len(scans)):
            surface = self._surfaces.of(node)
            points = len(surface.points_xy_m)
            matrix = normal_matrix(surface)
            if is_open(surfaces_of(scans[node], self._parameters.range_m)):
                matrix = without_weakest(matrix)
            self._informations.append(match_information(matrix, points, self._parameters))

    def _measured(self, node: int) -> SurfacePoints:
        return surface_points(self._scans[node], self._parameters.range_m)

    @property
    def informations(self) -> np.ndarray:
        """(k, 3, 3) of each scan's match with a map of its own surfaces."""
        return np.array(self._informations).reshape(-1, 3, 3)

    def around(self, path: MeasuredPath, node: int) -> LocalMap:
        """Build the local map of the path within `stretch_m` of a node, in the node's frame."""
        p = self._parameters
        nodes = np.flatnonzero(np.abs(path.way_m - path.way_m[node]) <= p.stretch_m)
        return self.of_nodes(path, nodes, node, SCAN_SPACING_M, p.resolution_m, p.blur_m)

    def of_nodes(
        self,
        path: MeasuredPath,
        nodes: np.ndarray,
        anchor: int,
        spacing_m: float,
        resolution_m: float,
        blur_m: float,
    ) -> LocalMap:
        """Build the map that nodes saw, in the anchor's frame, from scans about `spacing_m` apart."""
        kept = _thinned(path, nodes, anchor, spacing_m)
        sizes = LocalMapSizes(resolution_m, blur_m, 2.0 * resolution_m, self._parameters.range_m)
        return build_local_map(
            anchor,
            [self._surfaces.of(node) for node in kept],
            [self._scans[node] for node in kept],
            se2.between(path.poses[anchor], path.poses[kept]),
            sizes,
        )


def _thinned(path: MeasuredPath, nodes: np.ndarray, anchor: int, spacing_m: float) -> list[int]:
    kept: list[int] = []
    for node in nodes:
        turned = abs(se2.wrap(path.poses[node, 2] - path.poses[kept[-1], 2])) if kept else np.inf
        if (
            turned > SCAN_SPACING_RAD
            or node == anchor
            or path.way_m[node] - path.way_m[kept[-1]] >= spacing_m
        ):
            kept.append(int(node))
    return kept
