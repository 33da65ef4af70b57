"""Turns beam counts into the cells of an occupancy grid."""

from __future__ import annotations

import numpy as np

from gridslam.kernels.tiles import SIDE, Tiles
from kernel_cache.compiler import njit

UNKNOWN, FREE, OCCUPIED = -1, 0, 100


@njit(cache=True, nogil=True)
def render_changed(
    table: np.ndarray,
    tiles: Tiles,
    threshold: float,
    shown: np.ndarray,
    shown_stamps: np.ndarray,
    canvas: np.ndarray,
) -> int:
    """Draw the tiles that have changed on a canvas (h * SIDE, w * SIDE) int8; return their number.

    ``shown`` (h, w) and ``shown_stamps`` (h, w) hold the tile drawn at each place, and its stamp.
    """
    drawn = 0
    for y in range(table.shape[0]):
        for x in range(table.shape[1]):
            tile = table[y, x]
            if shown[y, x] == tile and shown_stamps[y, x] == tiles.stamps[tile]:
                continue
            shown[y, x] = tile
            shown_stamps[y, x] = tiles.stamps[tile]
            drawn += 1
            for row in range(SIDE):
                for column in range(SIDE):
                    visits = tiles.visits[tile, row * SIDE + column]
                    value = UNKNOWN
                    if visits > 0:
                        hits = tiles.hits[tiles.ends[tile], row * SIDE + column]
                        value = OCCUPIED if hits > threshold * visits else FREE
                    canvas[y * SIDE + row, x * SIDE + column] = value
    return drawn
