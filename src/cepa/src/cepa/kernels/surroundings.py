"""What paths are judged by: what is around the UAV, and the distances to keep.

Axes are those of the odometry's frame, with the UAV at the origin.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np


class Surroundings(NamedTuple):
    """What is around the UAV, on square grids that are centred on it, and in directions."""

    distance: np.ndarray
    """(layers, n, n) m: to the nearest obstacle, at most ``far``; rows y, columns x; layers: odd."""
    cell_m: float
    layer_m: float
    """m: from layer to layer; the middle one is at the UAV's height."""
    far: float
    sight: np.ndarray
    """(bins,) m: how far the body's centre may go in each direction within what has been seen."""
    unseen: np.ndarray
    """(layers, k, k) uint8: 1 where the body would be in what was not seen, 2 where ``sight`` counts; without
    layers it counts everywhere."""
    unseen_cell_m: float
    movers: np.ndarray
    """(m, 6): x, y in m, velocity in m/s, radius in m, growth of the radius in m/s."""
    way: np.ndarray
    """(1, k, k) m: length of the shortest way out from each cell; (0, 0, 0): none was searched."""
    way_cell_m: float
    way_x: float
    """m: of the UAV from the middle of ``way``."""
    way_y: float
    slowing: float
    """1/s: the reference's speed for each metre of way that is left; inf: the way has no end."""


class Horizon(NamedTuple):
    """How far ahead paths are judged, in steps."""

    commit: int
    brake: int
    cost: int
    hold: int


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
