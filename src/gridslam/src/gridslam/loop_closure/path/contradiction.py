"""How far the path is from the closure that was found last."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np

from gridslam import se2
from gridslam.loop_closure.edges import Match


def contradicted_m(poses: np.ndarray, closures: Sequence[Match]) -> float:
    """Return by how much the newest closures contradict the path, m; 0: there are none.

    A correction need not follow each closure: edges that the others contradict lose their weight. Then the
    map has two places for one, and the pose fits one of them at most. As soon as a later closure fits the
    path, the pose is known again.

    Args:
        poses: (k, 3) of the path.
        closures: those that count. The ones at the newest node are asked.
    """
    last = max((closure.newer for closure in closures), default=0)
    newest = (closure for closure in closures if closure.newer == last)
    return max((_off_m(poses, closure) for closure in newest), default=0.0)


def _off_m(poses: np.ndarray, closure: Match) -> float:
    here = se2.between(poses[closure.older], poses[closure.newer])
    return math.dist(here[:2], closure.newer_in_older[:2])
