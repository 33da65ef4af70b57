"""The kinds of voxels that a map shows: unknown, free, occupied."""

from __future__ import annotations

import numpy as np

from gridslam.volume.kernels.tiles import VOXELS
from kernel_cache.compiler import njit

UNKNOWN, FREE, OCCUPIED = 0, 1, 2


@njit(cache=True, nogil=True)
def kinds_of(tiles: np.ndarray, log_odds: np.ndarray, kinds: np.ndarray) -> None:
    """Fill the kinds (n, VOXELS), uint8, of tiles (n,) from a pool's log-odds (tiles * VOXELS,)."""
    for i in range(tiles.size):
        first = np.int64(tiles[i]) * VOXELS
        for voxel in range(VOXELS):
            value = log_odds[first + voxel]
            kinds[i, voxel] = UNKNOWN if value != value else (OCCUPIED if value >= 0.0 else FREE)


@njit(cache=True, nogil=True)
def overlay(
    rows: np.ndarray, tiles: np.ndarray, log_odds: np.ndarray, sure: np.float32, kinds: np.ndarray
) -> None:
    """Let a layer's voxels replace kinds where they are occupied, or so probably free as ``sure``.

    Args:
        rows: (k,) of the kinds.
        tiles: (k,) of the layer's pool, one for each row.
        log_odds: (tiles * VOXELS,) of that pool.
        sure: log-odds.
        kinds: (n, VOXELS) uint8.
    """
    for i in range(rows.size):
        first = np.int64(tiles[i]) * VOXELS
        for voxel in range(VOXELS):
            value = log_odds[first + voxel]
            if value >= 0.0:
                kinds[rows[i], voxel] = OCCUPIED
            elif value <= sure or (value < 0.0 and kinds[rows[i], voxel] == UNKNOWN):
                kinds[rows[i], voxel] = FREE
