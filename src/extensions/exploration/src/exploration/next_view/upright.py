"""Ways that climb where a level lidar and range finders see: straight up or down, and then level."""

from __future__ import annotations

import math
from typing import Callable, Sequence

import numpy as np

Cost = Callable[[np.ndarray, np.ndarray], float]
"""How long a straight leg between two places (x, y, z) seems, m; infinite: it may not be flown."""
STEEPER = 2.0
"""A leg so many times as steep as the lidar's outermost beams leads into what they have hardly shown."""
RISE_M = 1.0
"""Less height than this the UAV gains on its way, whatever the slope."""
ASIDE_M = 0.3
"""A leg that leads less aside counts as upright."""


def upright(places_m: Sequence[np.ndarray], slopes: tuple[float, float], cost_m: Cost) -> list[np.ndarray]:
    """Return the places (x, y, z) of a way without steep legs, where another way round is clear.

    CEPA flies only into what it has seen of late. On a steep leg it waits again and again until the lidar
    sees ahead. Straight up and down range finders see.

    Args:
        places_m: from where the UAV is, on.
        slopes: of the lidar's lowest and highest beam.
        cost_m: see `Cost`.
    """
    way_m = list(places_m[:1])
    for begin_m, end_m in zip(places_m, places_m[1:]):
        rise_m, aside_m = end_m[2] - begin_m[2], math.dist(begin_m[:2], end_m[:2])
        slope = max(slopes[1] if rise_m > 0.0 else -slopes[0], 0.0)
        if aside_m > ASIDE_M and abs(rise_m) > max(RISE_M, STEEPER * slope * aside_m):
            way_m += _corner(begin_m, end_m, cost_m)
        way_m.append(end_m)
    return way_m


def _corner(begin_m: np.ndarray, end_m: np.ndarray, cost_m: Cost) -> list[np.ndarray]:
    """Return the place above or below the beginning, or else the end; none if no way over them is clear."""
    for below_m, height_m in ((begin_m, end_m[2]), (end_m, begin_m[2])):
        corner_m = np.array((*below_m[:2], height_m))
        if math.isfinite(cost_m(begin_m, corner_m) + cost_m(corner_m, end_m)):
            return [corner_m]
    return []
