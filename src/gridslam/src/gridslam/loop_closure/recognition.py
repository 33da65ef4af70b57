"""Recognises a place: compares the newest local map with earlier ones, near first, then far.

A far place must be the only one of all that the path's uncertainty allows; then it is tested like a near one.
"""

from __future__ import annotations

import math
from functools import cached_property
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.filter.earlier_map import Usable
from gridslam.kernels.correlation import CLASHES, FITS
from gridslam.kernels.least_squares import inverse
from gridslam.loop_closure.chain import Chain, match_information
from gridslam.loop_closure.edge import Match
from gridslam.loop_closure.local_map import LocalMap
from gridslam.loop_closure.matcher import Correlation, Window
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.pose_graph import ShortestWays
from gridslam.loop_closure.refinement import Refined, normal_matrix, refine
from gridslam.search import LikelihoodField, PlaceSearch, SearchSettings
from gridslam.search import Window as SearchWindow
from gridslam.search.field import UNSEEN

REFINEMENT_GATE_M = 0.2
WINDOW_MIN_RAD = 0.05
FAR_SPACING_M, FAR_CELL_M, FAR_BLUR_M = 1.0, 0.1, 0.1
"""Of a far search: distance of its scans, size of its cells, and distance from a surface at which a point
fits by exp(-1/2).
"""


class Recognition:
    """Looks for the newest node's place among nodes that the path passed long before.

    Args:
        chain: the path.
        counted: closures that count.
        parameters: of the search.
        pieces: nodes that may be recognised; None: all. Those before the present map began are searched for
            like places that may be far off.
        newer: the node to be recognised; None: the newest one. What was seen after it counts, too.
    """

    def __init__(
        self,
        chain: Chain,
        counted: Sequence[Match],
        parameters: LoopClosureParameters,
        pieces: Usable | None = None,
        newer: int | None = None,
    ) -> None:
        self._chain, self._parameters = chain, parameters
        self._newer = len(chain) - 1 if newer is None else newer
        self._counted = counted
        self._distance_m = np.hypot(*(chain.poses[:, :2] - chain.poses[self._newer, :2]).T)
        self._is_old = chain.way_m < chain.way_m[self._newer] - parameters.separation_m
        self._is_near_allowed = np.ones(len(chain), dtype=bool)
        if pieces is not None:
            self._is_old &= pieces.is_usable
            self._is_near_allowed[: pieces.begun] = False

    @cached_property
    def _query(self) -> LocalMap:
        return self._chain.local_map(self._newer, self._parameters.stretch_m, self._parameters.stretch_m)

    def near(self) -> list[Match]:
        """Return the matches with places near the present estimate.

        Only a search of all places may tell how far odometry has erred. So all steps count as matched here.
        """
        found, places = [], self._places()
        covariances = self._ways(self._chain.matched_covariances) if places else np.zeros((0, 3, 3))
        for older in places:
            predicted = se2.between(self._chain.poses[older], self._chain.poses[self._newer])
            spread_m, turn_rad = self._spread(covariances[[older]])
            p = self._parameters
            window = Window(
                predicted,
                min(max(float(spread_m[0]), p.window_min_m), p.window_max_m),
                min(max(float(turn_rad[0]), WINDOW_MIN_RAD), p.window_max_rad),
                self._allowed(covariances[older]),
            )
            match = self._match(older, window, covariances[older])
            if match is not None:
                found.append(match)
        return found

    def _allowed(self, covariance: np.ndarray) -> np.ndarray:
        """Return the information (3, 3) of `Window` for a prediction of this covariance.

        A place that the path's uncertainty excludes is no match, and no rival of one. The window's least size
        holds here, too.
        """
        p = self._parameters
        least_m, least_rad = p.window_min_m / p.window_sigmas, WINDOW_MIN_RAD / p.window_sigmas
        return inverse(covariance + np.diag([least_m**2, least_m**2, least_rad**2])) / p.chi_square_max

    def far(self) -> list[Match]:
        """Return the match with the only place, of all that the path's uncertainty allows, or none."""
        p, chain = self._parameters, self._chain
        nodes = np.flatnonzero(self._is_old)
        covariances = self._ways(chain.covariances)
        spread_m, turn_rad = self._spread(covariances[nodes])
        allowed = (spread_m > p.window_max_m) & (self._distance_m[nodes] < spread_m + p.place_radius_m)
        nodes, spread_m, turn_rad = nodes[allowed], spread_m[allowed], turn_rad[allowed]
        if not len(nodes) or not self._is_firm():
            return []
        anchor = int(nodes[self._distance_m[nodes].argmin()])
        window = SearchWindow(
            se2.between(chain.poses[anchor], chain.poses[self._newer]),
            min(float(spread_m.max()), float(self._distance_m[nodes].max()) + p.place_radius_m),
            float(min(turn_rad.max(), math.pi)),
        )
        settings = SearchSettings(rival_share=p.rival_share_max, places_max=2, apart_m=p.rival_distance_m)
        search = PlaceSearch(_field(chain.map_of(nodes, anchor, FAR_SPACING_M, FAR_CELL_M, FAR_BLUR_M)))
        places = search.find(self._query.surface.points_xy_m, settings, window)
        if len(places) != 1:
            return []
        here = se2.compose(chain.poses[anchor], places[0].pose)
        older = int(nodes[np.hypot(*(chain.poses[nodes, :2] - here[:2]).T).argmin()])
        found = Window(se2.between(chain.poses[older], here), p.window_min_m, WINDOW_MIN_RAD)
        match = self._match(older, found, covariances[older])
        return [] if match is None else [match]

    def _is_firm(self) -> bool:
        """Return whether the recent map would tell its pose if all its points met what they met before.

        A single pillar does not tell it. To look for one in a wide hall takes long, and finds all others.
        """
        surface = self._query.surface
        points = int(np.isfinite(surface.normals_xy[:, 0]).sum())
        own = Refined(np.zeros(3), normal_matrix(surface), points, 0.0)
        return self._covariance(own) is not None

    def _ways(self, steps: np.ndarray) -> np.ndarray:
        """Return the covariances (k, 3, 3) of the newest pose relative to every node, by the steps' ones."""
        drift_share = self._parameters.drift_share
        return ShortestWays(self._chain, self._counted, self._newer, drift_share, steps).covariances

    def _spread(self, covariances: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return how far off poses of these covariances (n, 3, 3) may be, in m and in rad."""
        sigmas = self._parameters.window_sigmas
        xx, yx, yy = covariances[:, 0, 0], covariances[:, 1, 0], covariances[:, 1, 1]
        widest = 0.5 * (xx + yy) + np.hypot(0.5 * (xx - yy), yx)  # the greater eigenvalue
        return sigmas * np.sqrt(widest), sigmas * np.sqrt(covariances[:, 2, 2])

    def _places(self) -> list[int]:
        """Return the nearest node of each earlier pass, nearest first."""
        distance, p = self._distance_m, self._parameters
        nodes = np.flatnonzero(self._is_old & self._is_near_allowed & (distance < p.place_radius_m))
        passes = np.split(nodes, np.flatnonzero(np.diff(nodes) > 1) + 1)
        nearest = [
            int(nodes_of_pass[distance[nodes_of_pass].argmin()])
            for nodes_of_pass in passes
            if len(nodes_of_pass)
        ]
        return sorted(nearest, key=lambda node: distance[node])[: p.places_max]

    def _match(self, older: int, window: Window, uncertainty: np.ndarray) -> Match | None:
        """Match the recent local map with an earlier one; None unless good, firm, credible and unique.

        The search for a rival takes longest. So it comes last.
        """
        p, chain, query = self._parameters, self._chain, self._query
        reference = chain.local_map(older, p.stretch_m, p.stretch_m)
        search = Correlation(reference, query, window)
        optimum = search.best(p.score_min, p.overlap_min)
        if optimum is None:
            return None
        refined = refine(reference.surface, query.surface, optimum.query_in_reference, REFINEMENT_GATE_M)
        covariance = self._covariance(refined)
        if covariance is None:
            return None
        predicted = se2.between(chain.poses[older], chain.poses[self._newer])
        error = se2.between(predicted, refined.query_in_reference)
        if error @ np.linalg.solve(covariance + uncertainty, error) > p.chi_square_max:
            return None
        rival_min = p.rival_share_max * optimum.score
        if search.has_rival(optimum, p.rival_distance_m, rival_min, p.rival_overlap_min):
            return None
        return Match(older, self._newer, refined.query_in_reference, covariance, optimum.score)

    def _covariance(self, refined: Refined) -> np.ndarray | None:
        p = self._parameters
        information = match_information(refined.normal_matrix, refined.pairs, p)
        if np.linalg.eigvalsh(information)[0] < 1e-3:
            return None
        covariance = inverse(information)
        if math.sqrt(float(np.linalg.eigvalsh(covariance[:2, :2])[-1])) > p.weakest_sigma_max_m:
            return None
        return covariance + np.diag([p.closure_sigma_m**2, p.closure_sigma_m**2, p.closure_sigma_rad**2])


def _field(known: LocalMap) -> LikelihoodField:
    fits, clashes = known.table[:, :, FITS], known.table[:, :, CLASHES]
    unseen = np.where(fits | clashes, np.uint8(0), np.uint8(UNSEEN))
    return LikelihoodField(np.maximum(fits, unseen), known.origin_xy_m, known.resolution_m, FAR_BLUR_M)
