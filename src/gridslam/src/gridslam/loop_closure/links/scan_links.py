"""All links of a path: of each scan with those just before it, and with other passes of the place."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from typing import Any, Mapping, Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverse
from gridslam.kernels.links import Surfaces, nearest_earlier
from gridslam.loop_closure.edges import Edge, Edges
from gridslam.loop_closure.links.scan_pairs import link_pairs
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.odometry_scale import Scale, odometry_scale
from gridslam.loop_closure.recent import Recent
from gridslam.maps.scan_surfaces import ScanSurfaces, surfaces_of
from gridslam.maps.tile_pool import require_indices
from gridslam.scan import PlanarScan
from gridslam.tracking.wrong_steps import MATCH_SIGMA, are_wrong

SPACING_M = 0.5
"""m: of the scans just before a scan, those closer to each other than this add nothing."""
PASSES_MAX = 3
"""A scan is linked with at most this many scans of other passes, the nearest."""
TRY_AGAIN_M = 0.1
"""m: two scans that could not be linked are tried again when their poses have moved by more than this."""
SURFACES_MAX = 256
"""The surfaces of so many scans are kept: of those just before the newest one, and of the pass beside it."""
NOTHING = np.zeros((3, 3))
OPEN_M = 1.0
"""m: a link with a greater standard deviation leaves a direction open, as along a bare corridor."""

ASTRAY_M = 0.9
"""m: in a direction that it measures, a link with a scan just before must not differ by more from both the
filter's path and odometry's. Rooms that look alike fit each other, too."""


@dataclass(frozen=True, eq=False)
class ScanLinksState:
    """All links of a path, to save them and go on."""

    back: Edges
    """With scans just before."""
    passes: Edges
    """With scans of other passes."""
    failed: tuple[tuple[int, int], ...]
    """Pairs of nodes of different passes that could not be linked."""
    failed_poses: np.ndarray
    """(n, 3) of the newer node in the older one, when that was tried."""


class ScanLinks:
    """Measures links, each pair of scans once."""

    def __init__(self, parameters: LoopClosureParameters) -> None:
        self._parameters = parameters
        self._scans: Sequence[PlanarScan] = ()
        self._surfaces: Recent[Surfaces] = Recent(self._measured, SURFACES_MAX)
        self._heights_m: list[float] = []
        self._back: dict[tuple[int, int], Edge] = {}
        self._passes: dict[tuple[int, int], Edge] = {}
        self._failed: dict[tuple[int, int], np.ndarray] = {}
        self._is_spanned = bytearray()
        self._information: list[np.ndarray] = []
        """(k - 1,) and (k, 3, 3): see `is_spanned` and `information`."""
        self._stacked = Edges.of([])
        """The first links of ``_back``, as arrays; `_stack` adds the others."""

    @property
    def edges(self) -> list[Edge]:
        """All links."""
        return [*self._back.values(), *self._passes.values()]

    def _stack(self) -> None:
        new = list(itertools.islice(self._back.values(), len(self._stacked.older), None))
        self._stacked = Edges.joined([self._stacked, Edges.of(new)])

    def stacked(self) -> Edges:
        """Return all links as arrays."""
        return Edges.joined([self.stacked_back(), Edges.of(list(self._passes.values()))])

    def stacked_back(self) -> Edges:
        """Return the links with scans just before as arrays."""
        self._stack()
        return self._stacked

    def odometry_scale(self, odometry: np.ndarray) -> Scale:
        """Return by what the ways of odometry (k, 3) are to be multiplied."""
        self._stack()
        p = self._parameters
        return odometry_scale(self._stacked, odometry, p.odometry_m_per_sqrt_m, p.links_back)

    def is_spanned(self) -> np.ndarray:
        """Return for each step (k - 1,) whether a link spans it that measures every direction."""
        return np.frombuffer(bytes(self._is_spanned), dtype=bool)

    def information(self) -> np.ndarray:
        """Return (k - 1, 3, 3): what links with scans before it say of each step's newer node."""
        return np.array(self._information[1:]).reshape(-1, 3, 3)

    def wrong_steps(self, path: MeasuredPath) -> np.ndarray:
        """Return the nodes to which the filter's step is wrong, by its own link and by odometry."""
        self._stack()
        own = self._stacked.newer - self._stacked.older == 1
        newer, links = self._stacked.newer[own], self._stacked.newer_in_older[own]
        by_odometry = se2.between(path.odometry[newer - 1], path.odometry[newer])
        covariances = self._stacked.covariance[own] + np.diag(MATCH_SIGMA**2)
        return newer[are_wrong(path.steps[newer - 1], by_odometry, links, covariances)]

    def _add(self, edge: Edge) -> None:
        older, newer = edge.older, edge.newer
        self._back[older, newer] = edge
        self._information[newer] = self._information[newer] + inverse(edge.covariance)
        if edge.covariance[0, 0] + edge.covariance[1, 1] < OPEN_M**2:
            self._is_spanned[older:newer] = b"\1" * (newer - older)

    def extend(self, scans: Sequence[PlanarScan], path: MeasuredPath) -> None:
        """Take in the scans at new nodes of a path. Link each with scans just before it.

        Where scans are far apart, the filter may have taken a wrong turn. So the search for a link begins at
        odometry's prediction, too.
        """
        p, self._scans = self._parameters, scans
        self._heights_m += [scan.height_m for scan in scans[len(self._heights_m) :]]
        for newer in range(len(self._information), len(scans)):
            self._information.append(NOTHING)
            if newer > 0:
                self._is_spanned.append(0)
            before = self._before(newer, path.way_m)
            pairs = np.array([(older, newer) for older in before], int).reshape(-1, 2)
            predicted = np.stack(
                [se2.between(poses[pairs[:, 0]], poses[newer]) for poses in (path.poses, path.odometry)],
                axis=1,
            )
            edges = self._linked(pairs, predicted, most=p.links_back)
            for edge, starts in zip(edges, predicted):
                if edge is not None and not _is_astray(edge, starts):
                    self._add(edge)

    def _measured(self, node: int) -> Surfaces:
        return surfaces_of(self._scans[node], self._parameters.link_range_m)

    def _linked(self, pairs: np.ndarray, predicted: np.ndarray, **options: Any) -> list[Edge | None]:
        """Link pairs (m, 2) of nodes as `link_pairs` does."""
        nodes = np.unique(pairs)
        scans = ScanSurfaces(map(self._surfaces.of, nodes.tolist()), nodes)
        return link_pairs(pairs, scans, predicted, self._parameters, **options)

    def _before(self, newer: int, way_m: np.ndarray) -> list[int]:
        """Return the nodes just before a node that may be linked with it, the last one first."""
        first = int(np.searchsorted(way_m, way_m[newer] - self._parameters.link_reach_m))
        nodes: list[int] = []
        for older in range(newer - 1, first - 1, -1):
            if not nodes or way_m[nodes[-1]] - way_m[older] >= SPACING_M:
                nodes.append(older)
        return nodes

    def link_passes(self, poses: np.ndarray, way_m: np.ndarray) -> int:
        """Link scans with those of other passes nearby, by present poses (k, 3).

        Returns the number of new links. Links that the poses contradict are forgotten.
        """
        p = self._parameters
        for pair in _moved(self._passes, poses, p.link_gate_m):
            del self._passes[pair]
        for pair in _moved(self._failed, poses, TRY_AGAIN_M):
            del self._failed[pair]
        pairs = [
            pair
            for pair in self._passing(poses, way_m, 0)
            if pair not in self._passes and pair not in self._failed
        ]
        if not pairs:
            return 0
        before, predicted = len(self._passes), _between(poses, pairs)
        edges = self._linked(np.array(pairs), predicted[:, None], is_pass=True)
        for pair, pose, edge in zip(pairs, predicted, edges):
            if edge is None:
                self._failed[pair] = pose
            else:
                self._passes[pair] = edge
        return len(self._passes) - before

    def _passing(self, poses: np.ndarray, way_m: np.ndarray, first: int) -> list[tuple[int, int]]:
        """Return (older, newer) for the nearest nodes of other passes of each node from ``first`` on."""
        p = self._parameters
        nearest = nearest_earlier(poses, way_m, first, p.link_radius_m, p.link_separation_m, PASSES_MAX)
        return [
            (older, first + i)
            for i, nodes in enumerate(nearest.tolist())
            for older in nodes
            if older >= 0 and self._are_one_slice(older, first + i)
        ]

    def _are_one_slice(self, older: int, newer: int) -> bool:
        apart_m = abs(self._heights_m[older] - self._heights_m[newer])
        return not apart_m > self._parameters.height_band_m  # NaN is in every band

    def agrees(self, poses: np.ndarray, way_m: np.ndarray, within_m: float) -> bool:
        """Return whether the newest scan fits one of another pass at the present poses (k, 3)."""
        pairs = self._passing(poses, way_m, len(poses) - 1)
        if not pairs:
            return False
        predicted = _between(poses, pairs)
        edges = self._linked(np.array(pairs), predicted[:, None], is_pass=True, most=1)
        for edge, pose in zip(edges, predicted):
            if edge is not None:
                return math.dist(edge.newer_in_older[:2], pose[:2]) < within_m
        return False

    def state(self) -> ScanLinksState:
        """Return all links."""
        return ScanLinksState(
            Edges.of(list(self._back.values())),
            Edges.of(list(self._passes.values())),
            tuple(self._failed),
            np.array(list(self._failed.values())).reshape(-1, 3),
        )

    def restore(self, state: ScanLinksState, nodes: int) -> None:
        """Go on from a state, on a path of so many nodes.

        Raises:
            ValueError: it points at nodes that are not there.
        """
        for pairs in (*state.back[:2], *state.passes[:2], np.array(state.failed, int)):
            require_indices(pairs, nodes - 1, "the links' nodes")
        self._surfaces, self._stacked = Recent(self._measured, SURFACES_MAX), Edges.of([])
        self._heights_m = []
        self._is_spanned, self._information = bytearray(max(0, nodes - 1)), [NOTHING] * nodes
        self._back = {}
        for edge in state.back.each():
            self._add(edge)
        self._passes = {(edge.older, edge.newer): edge for edge in state.passes.each()}
        self._failed = dict(zip(state.failed, state.failed_poses))


def _is_astray(edge: Edge, starts: np.ndarray) -> bool:
    """Return whether a link differs from all starts (k, 3) by more than it and they allow."""
    off = se2.between(starts, edge.newer_in_older)[:, :2]
    allowed = edge.covariance[:2, :2] + (ASTRAY_M / 3.0) ** 2 * np.eye(2)
    return bool((np.einsum("ki,ij,kj->k", off, np.linalg.inv(allowed), off) > 9.0).all())


def _between(poses: np.ndarray, pairs: Sequence[tuple[int, int]]) -> np.ndarray:
    """Return the poses (m, 3) of each pair's newer node in the older."""
    older, newer = np.array(pairs).T
    return se2.between(poses[older], poses[newer])


def _moved(
    known: Mapping[tuple[int, int], Edge | np.ndarray], poses: np.ndarray, by_m: float
) -> list[tuple[int, int]]:
    """Return the pairs whose relative pose was another one, by more than this distance."""
    if not known:
        return []
    then = np.array([value.newer_in_older if isinstance(value, Edge) else value for value in known.values()])
    error = se2.between(_between(poses, list(known)), then)
    far = np.hypot(error[:, 0], error[:, 1]) > by_m
    return [pair for pair, is_far in zip(list(known), far) if is_far]
