"""Whether a map of voxels agrees with itself: how much of its floors lies doubled. It needs no truth."""

from __future__ import annotations

import math

import numpy as np

from gridslam.volume.kernels.doubling import MARGIN, count_doubled
from gridslam.volume.kernels.shown import kinds_of
from gridslam.volume.kernels.tiles import SIDE
from gridslam.volume.tile_table import Box, dense_of
from gridslam.volume.voxel_map import VoxelMap

DOUBLED_MAX = 0.05
"""A map with a greater share does not agree with itself. By true poses, eight places had at most 0.005;
three of them also with heights that swayed by 0.1 m (voxels of 0.1 m); with 0.2 m these had 0.28 or more."""
TILES_AT_ONCE = 6
"""Along each side of a block."""


def doubled_share(voxels: VoxelMap) -> float:
    """Return the share of floors and ceilings that lie doubled, 0..1; NaN without any.

    One is doubled if it was mapped twice from the same side, 2 to 5 voxels apart: the heights of the UAV did
    not agree. Narrow parts, such as stiffeners of 2 voxels, are no floor here. Real plates that stand so near
    above each other count, too. Walls do not count: what stands before them in a ship is much like a double.
    """
    tiles = voxels.known_tiles()
    if not len(tiles):
        return math.nan
    kinds = np.zeros((int(voxels.table.max()) + 1, SIDE**3), np.uint8)
    kinds_of(np.arange(len(kinds)), voxels.pool.tiles.log_odds, kinds)
    blocks = np.unique(tiles // TILES_AT_ONCE, axis=0)
    side = TILES_AT_ONCE * SIDE
    found = np.zeros(2, np.int64)
    for block in blocks:
        box = Box(block * side - MARGIN, (block + 1) * side + MARGIN)
        found += count_doubled(dense_of(voxels, kinds, box))
    surface, doubled = found.tolist()
    return doubled / surface if surface else math.nan


def disagreement(share: float) -> str:
    """Return what is wrong with a map of this doubled share, in a sentence; empty: nothing."""
    if not share > DOUBLED_MAX:
        return ""
    return (
        f"The map does not agree with itself: {100.0 * share:.0f} % of its floors and ceilings lie doubled, "
        f"2 to 5 voxels apart (at most {100.0 * DOUBLED_MAX:.0f} %). The height that was told was wrong: it "
        "drifted, or the pose jumped. Look at map.ot, and fly again with a range finder and a lidar that see "
        "the floor."
    )
