"""Straight level flights in all directions, past what stands: which of them lead out soonest."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.choice import (
    EMERGENCY_DIRECTIONS,
    EMERGENCY_NARROWNESS,
    EMERGENCY_REACH_M,
    EMERGENCY_TURN_M,
)
from cepa.dynamic.kernels.surroundings import DistanceField


class WayOut(NamedTuple):
    """A straight flight that leads out. A narrow one counts as longer."""

    direction: np.ndarray
    """Unit vector (2,)."""
    length_m: float


class StraightWays(NamedTuple):
    """What straight flights in d directions pass, at each of s steps."""

    directions: np.ndarray
    """(d, 2): unit vectors."""
    steps_m: np.ndarray
    """(s,): of the way."""
    clearance_m: np.ndarray
    """(s, d): to what stands."""
    narrowest_m: np.ndarray
    """(s, d): least clearance until then."""
    here_m: float
    """Clearance where the UAV is."""

    def soonest(self, is_out: np.ndarray, wide_m: float, last: np.ndarray) -> WayOut | None:
        """Return the shortest of those that are out somewhere; None: there is none.

        is_out (s, d): where the way may end. wide_m: a way so wide is not narrow. last: unit vector (2,) of
        the last one, or zeros: to turn back counts as a detour.
        """
        first = is_out.argmax(axis=0)
        way_m = np.where(is_out.any(axis=0), self.steps_m[first], math.inf)
        way_m += EMERGENCY_NARROWNESS * (wide_m - self.narrowest_m[first, np.arange(EMERGENCY_DIRECTIONS)])
        way_m += EMERGENCY_TURN_M * (1.0 - self.directions @ last)
        if math.isinf(way_m.min()):
            return None
        best = int(np.argmin(way_m))
        return WayOut(self.directions[best], float(way_m[best]))


def straight_ways(field: DistanceField) -> StraightWays:
    """Return the straight level flights from the middle of a distance field."""
    distance, cell_m, _, _ = field
    layer = distance[len(distance) // 2]
    middle = len(layer) // 2
    angles = np.arange(EMERGENCY_DIRECTIONS) * (2.0 * math.pi / EMERGENCY_DIRECTIONS)
    directions = np.stack((np.cos(angles), np.sin(angles)), axis=1)
    steps_m = np.arange(cell_m, EMERGENCY_REACH_M, cell_m)
    nodes = np.rint(steps_m[:, None, None] * directions / cell_m).astype(int) + middle
    columns, rows = np.clip(nodes, 0, 2 * middle).transpose(2, 0, 1)
    clearance_m = layer[rows, columns]
    narrowest_m = np.minimum.accumulate(clearance_m, axis=0)
    return StraightWays(directions, steps_m, clearance_m, narrowest_m, float(layer[middle, middle]))
