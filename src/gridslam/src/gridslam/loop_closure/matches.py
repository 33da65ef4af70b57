"""Stage 3, the matches: candidates at which both local maps agree. The criterion of a closure is here.

To change when two places count as one, change the tests in `match`. Their limits are parameters.
"""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.loop_closure.candidates import Candidate
from gridslam.loop_closure.edges import Match
from gridslam.loop_closure.local_maps.correlation import Correlation, Optimum
from gridslam.loop_closure.local_maps.local_map import LocalMap
from gridslam.loop_closure.local_maps.refinement import match_covariance, refine
from gridslam.loop_closure.local_maps.stretches import LocalMaps
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath

REFINEMENT_GATE_M = 0.2


def match(
    candidate: Candidate,
    path: MeasuredPath,
    recent: LocalMap,
    maps: LocalMaps,
    parameters: LoopClosureParameters,
) -> Match | None:
    """Place the recent local map (the query) on the earlier one (the reference), around the older node.

    Return None unless it passes every test. The search for a rival takes longest. So it comes last.

    Args:
        candidate: both nodes, and where to search.
        path: the nodes are of this path.
        recent: local map around the newer node.
        maps: of the path.
        parameters: the limits of the tests.
    """
    p = parameters
    earlier = maps.around(path, candidate.older)
    search = Correlation(earlier, recent, candidate.window)
    optimum = search.best(p.score_min, p.overlap_min)  # test 1: the maps agree
    if optimum is None:
        return None
    refined = refine(earlier.surface, recent.surface, optimum.query_in_reference, REFINEMENT_GATE_M)
    pose, covariance = refined.query_in_reference, match_covariance(refined, p)
    if covariance is None:  # test 2: their surfaces hold the pose in every direction
        return None
    if not agrees_with_path(pose, covariance, candidate, path, p):  # test 3
        return None
    if _has_rival(search, optimum, p):  # test 4: no other pose fits nearly as well
        return None
    return Match(candidate.older, candidate.newer, pose, covariance, optimum.score)


def agrees_with_path(
    pose: np.ndarray,
    covariance: np.ndarray,
    candidate: Candidate,
    path: MeasuredPath,
    parameters: LoopClosureParameters,
) -> bool:
    """Return whether the path, as uncertain as it is, allows a measured pose (3,) of the newer node."""
    by_path = se2.between(path.poses[candidate.older], path.poses[candidate.newer])
    error = se2.between(by_path, pose)
    chi_square = error @ np.linalg.solve(covariance + candidate.uncertainty, error)
    return bool(chi_square <= parameters.chi_square_max)


def _has_rival(search: Correlation, optimum: Optimum, parameters: LoopClosureParameters) -> bool:
    p = parameters
    least = p.rival_share_max * optimum.score
    return search.has_rival(optimum, p.rival_distance_m, least, p.rival_overlap_min)
