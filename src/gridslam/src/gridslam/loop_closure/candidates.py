"""Stage 2, the candidates: earlier nodes that may be a node's place, near first, then far.

A near candidate lies where the present path comes by. A far one must be the only place that fits, of all that
the path's uncertainty allows. Both must then pass the same tests (`matches`).
"""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.correlation import CLASHES, FITS
from gridslam.kernels.least_squares import inverse
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.local_maps.correlation import Window
from gridslam.loop_closure.local_maps.local_map import LocalMap
from gridslam.loop_closure.local_maps.refinement import tells_its_pose
from gridslam.loop_closure.local_maps.stretches import LocalMaps
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.way_uncertainty import way_covariances
from gridslam.search import LikelihoodField, PlaceSearch, SearchSettings
from gridslam.search import Window as PlaceWindow
from gridslam.search.field import UNSEEN

WINDOW_MIN_RAD = 0.05
FAR_SPACING_M, FAR_CELL_M, FAR_BLUR_M = 1.0, 0.1, 0.1
"""Of a far search: distance of its scans, size of its cells, and distance from a surface at which a point
fits by exp(-1/2).
"""


class Candidate(NamedTuple):
    """Two nodes that may have seen the same place."""

    older: int
    newer: int
    window: Window
    """Where the newer node may be, seen from the older one."""
    uncertainty: np.ndarray
    """(3, 3) covariance of the newer node's pose by the path, relative to the older one."""


class Revisit(NamedTuple):
    """A node whose place is looked for among earlier nodes."""

    path: MeasuredPath
    newer: int
    """What was seen after this node counts, too."""
    closures: Sequence[Match]
    """Those that count. They make the path more certain."""
    is_usable: np.ndarray
    """(k,) bool: nodes that may be recognised."""
    first_in_map: int
    """Nodes before this one are on an earlier map. They are looked for like places that may be far off."""


def near_candidates(revisit: Revisit, parameters: LoopClosureParameters) -> list[Candidate]:
    """Return the nearest node of each earlier pass of the place, nearest first, by the present path.

    Only a search of all places may tell how far odometry has erred. So all steps count as matched here.
    """
    p, path, newer = parameters, revisit.path, revisit.newer
    distance_m = _distances(revisit)
    is_near = distance_m < p.place_radius_m
    is_near[: revisit.first_in_map] = False
    nodes = np.flatnonzero(_is_old(revisit, p) & is_near)
    if not len(nodes):
        return []
    passes = np.split(nodes, np.flatnonzero(np.diff(nodes) > 1) + 1)
    nearest = [int(each[distance_m[each].argmin()]) for each in passes]
    covariances = way_covariances(path, path.covariances, revisit.closures, newer, p.drift_share)
    found = []
    for older in sorted(nearest, key=lambda node: distance_m[node])[: p.places_max]:
        spread_m, turn_rad = _spread(covariances[[older]], p)
        window = Window(
            se2.between(path.poses[older], path.poses[newer]),
            min(max(float(spread_m[0]), p.window_min_m), p.window_max_m),
            min(max(float(turn_rad[0]), WINDOW_MIN_RAD), p.window_max_rad),
            _window_information(covariances[older], p),
        )
        found.append(Candidate(older, newer, window, covariances[older]))
    return found


def far_candidates(
    revisit: Revisit,
    step_covariances: np.ndarray,
    recent: LocalMap,
    maps: LocalMaps,
    parameters: LoopClosureParameters,
) -> list[Candidate]:
    """Return the only place, of all that the path's uncertainty allows, or none.

    Args:
        revisit: the node, and the path.
        step_covariances: (k - 1, 3, 3) of the path's steps, large where odometry may have slipped.
        recent: local map around the node.
        maps: of the path.
        parameters: of the search.
    """
    p, path, newer = parameters, revisit.path, revisit.newer
    nodes, distance_m = np.flatnonzero(_is_old(revisit, p)), _distances(revisit)
    covariances = way_covariances(path, step_covariances, revisit.closures, newer, p.drift_share)
    spread_m, turn_rad = _spread(covariances[nodes], p)
    is_allowed = (spread_m > p.window_max_m) & (distance_m[nodes] < spread_m + p.place_radius_m)
    nodes, spread_m, turn_rad = nodes[is_allowed], spread_m[is_allowed], turn_rad[is_allowed]
    if not len(nodes) or not tells_its_pose(recent.surface, p):
        return []
    anchor = int(nodes[distance_m[nodes].argmin()])
    window = PlaceWindow(
        se2.between(path.poses[anchor], path.poses[newer]),
        min(float(spread_m.max()), float(distance_m[nodes].max()) + p.place_radius_m),
        float(min(turn_rad.max(), math.pi)),
    )
    settings = SearchSettings(rival_share=p.rival_share_max, places_max=2, apart_m=p.rival_distance_m)
    known = maps.of_nodes(path, nodes, anchor, FAR_SPACING_M, FAR_CELL_M, FAR_BLUR_M)
    places = PlaceSearch(_field(known)).find(recent.surface.points_xy_m, settings, window)
    if len(places) != 1:
        return []
    here = se2.compose(path.poses[anchor], places[0].pose)
    older = int(nodes[np.hypot(*(path.poses[nodes, :2] - here[:2]).T).argmin()])
    found = Window(se2.between(path.poses[older], here), p.window_min_m, WINDOW_MIN_RAD)
    return [Candidate(older, newer, found, covariances[older])]


def _distances(revisit: Revisit) -> np.ndarray:
    """Return how far (k,) m the path's nodes are from the newer node, by the present path."""
    poses = revisit.path.poses
    return np.hypot(*(poses[:, :2] - poses[revisit.newer, :2]).T)


def _is_old(revisit: Revisit, parameters: LoopClosureParameters) -> np.ndarray:
    """Return which nodes (k,) the path passed long enough before."""
    way_m = revisit.path.way_m
    return (way_m < way_m[revisit.newer] - parameters.separation_m) & revisit.is_usable


def _window_information(covariance: np.ndarray, parameters: LoopClosureParameters) -> np.ndarray:
    """Return the information (3, 3) of `Window` for a prediction of this covariance.

    A place that the path's uncertainty excludes is no match, and no rival of one. The window's least size
    holds here, too.
    """
    p = parameters
    least_m, least_rad = p.window_min_m / p.window_sigmas, WINDOW_MIN_RAD / p.window_sigmas
    return inverse(covariance + np.diag([least_m**2, least_m**2, least_rad**2])) / p.chi_square_max


def _spread(covariances: np.ndarray, parameters: LoopClosureParameters) -> tuple[np.ndarray, np.ndarray]:
    """Return how far off poses of these covariances (n, 3, 3) may be, in m and in rad."""
    sigmas = parameters.window_sigmas
    xx, yx, yy = covariances[:, 0, 0], covariances[:, 1, 0], covariances[:, 1, 1]
    widest = 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), yx)  # the greater eigenvalue
    return sigmas * np.sqrt(widest), sigmas * np.sqrt(covariances[:, 2, 2])


def _field(known: LocalMap) -> LikelihoodField:
    fits, clashes = known.table[:, :, FITS], known.table[:, :, CLASHES]
    unseen = np.where(fits | clashes, np.uint8(0), np.uint8(UNSEEN))
    return LikelihoodField(np.maximum(fits, unseen), known.origin_xy_m, known.resolution_m, FAR_BLUR_M)
