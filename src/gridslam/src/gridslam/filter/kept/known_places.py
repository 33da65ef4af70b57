"""Places that enough passes have mapped. A scan that agrees there tells nothing new, so it is not kept."""

from __future__ import annotations

import numpy as np

from gridslam import se2
from gridslam.maps.beams import Beams
from gridslam.tracking.evidence import Agreement

PASSES_ENOUGH = 5
"""So many passes make a place known. Loop closure links a scan with three other passes at most."""
APART_M = 5.0
"""m of way: nodes at one place are of one pass if the way from each to the next is shorter."""
NEAR_M, NEAR_RAD, NEAR_HEIGHT_M = 0.5, 0.5, 0.25
"""Nodes are at one place if they differ by less than this: half of gmapping's way between two nodes, all of
its turn, and half of loop closure's band of heights."""
AGREEING_SHARE = 0.9
"""Of all beams, those in unseen space too: fewer tell something new."""
TELLING_SHARE = 0.03
"""Of a scan's beams: its information in the worst direction. Along a bare wall it is 0."""


def known_node(
    path: np.ndarray, heights_m: np.ndarray, usable: np.ndarray, pose: np.ndarray, height_m: float
) -> int | None:
    """Return the nearest node of a place that enough passes have mapped; None: it is not known so well.

    Args:
        path: (k, 3) the nodes' poses in the map: x, y in m and yaw in rad.
        heights_m: (k,) of the nodes; NaN: not known.
        usable: (k,) bool: whether a node's scan is in the present map.
        pose: (3,) of the base in the map.
        height_m: of the base; NaN: not known.
    """
    away_m = np.hypot(*(path[:, :2] - pose[:2]).T)
    is_near = usable & (away_m < NEAR_M) & (np.abs(se2.wrap(path[:, 2] - pose[2])) < NEAR_RAD)
    is_near &= ~(np.abs(heights_m - height_m) >= NEAR_HEIGHT_M)  # NaN is at every height
    near = np.flatnonzero(is_near)
    if len(near) < PASSES_ENOUGH:
        return None
    way_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path[:, :2], axis=0).T))])
    passes = 1 + np.count_nonzero(np.diff(way_m[near]) > APART_M)
    return int(near[away_m[near].argmin()]) if passes >= PASSES_ENOUGH else None


def adds_nothing(agreement: Agreement, beams: Beams) -> bool:
    """Return whether a scan agrees with the map nearly everywhere, and tells its pose in every direction."""
    if not agreement.is_meaningful() or agreement.share(1.0) < AGREEING_SHARE:
        return False
    normals = beams.matching[:, 4:6]
    if not len(normals):
        return False
    worst = float(np.linalg.eigvalsh(normals.T @ normals)[0])
    return worst >= TELLING_SHARE * len(normals)
