"""What paths are judged by: what is around the UAV, and the distances to keep.

Axes are those of the odometry's frame, with the UAV at the origin.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np


class DistanceField(NamedTuple):
    """How near obstacles are, on a square grid that is centred on the UAV."""

    distance: np.ndarray
    """(layers, n, n) m: to the nearest obstacle, at most ``far``; rows y, columns x; layers: odd."""
    cell_m: float
    layer_m: float
    """m: from layer to layer; the middle one is at the UAV's height."""
    far: float


class FreeSpace(NamedTuple):
    """What has been seen free."""

    reach: np.ndarray
    """(bins,) m: how far the body's centre may go in each direction within what has been seen."""
    unseen: np.ndarray
    """(layers, k, k) uint8: 1 where the body would be in what was not seen, 2 where ``reach`` counts; without
    layers it counts everywhere."""
    unseen_cell_m: float


class CostToGo(NamedTuple):
    """How long the shortest way is from each cell."""

    length: np.ndarray
    """(1, k, k) m: of the shortest way out; (1, 0, 0): none was searched."""
    cell_m: float
    offset_x: float
    """m: of the UAV from the middle of ``length``."""
    offset_y: float
    slowing: float
    """1/s: the reference's speed for each metre of way that is left; inf: the way has no end."""


NO_COST_TO_GO = CostToGo(np.empty((1, 0, 0)), 0.0, 0.0, 0.0, math.inf)
"""None was searched."""


class Surroundings(NamedTuple):
    """What is around the UAV."""

    field: DistanceField
    free_space: FreeSpace
    movers: np.ndarray
    """(m, 6): x, y in m, velocity in m/s, radius in m, growth of the radius in m/s."""
    cost_to_go: CostToGo


class Horizon(NamedTuple):
    """How far ahead paths are judged, in steps."""

    commit: int
    brake: int
    cost: int
    hold: int


class Braking(NamedTuple):
    """How a UAV fares that brakes at once, after each of n = commit + brake steps."""

    clearance: np.ndarray
    """(n,) m: of what stands."""
    beyond: np.ndarray
    """(n,) m: how far it is beyond the free space."""
    nearest_mover: float
    """m: how near what moves comes in the first ``judged`` steps."""
    judged: int
    """Steps in which what moves counts: all n, or those of the commit time if a UAV that brakes is hit."""


class Cushions(NamedTuple):
    """The distances to keep, m."""

    inner: float
    outer: float
    """The limits of discomfort."""
    least: float
    """Nothing may come nearer."""
    hull: float
    """Of the body, and what the scan's errors take."""
    tube: np.ndarray
    """(commit + brake,): how far the UAV may stray in FULL_ERROR_M_S flight after each step."""
