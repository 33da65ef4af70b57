"""Enters the marked voxels of a cloud into a map's tiles, with OctoMap's log-odds."""

from __future__ import annotations

import numpy as np

from gridslam.volume.kernels.tiles import CLOSED, ROWS, SIDE, SIDE_BITS, UNSEEN, VOXELS, Model, Tiles
from kernel_cache.compiler import njit

PER_WORD = 64 // SIDE
"""Rows of tiles in a word of the board."""
ROW_BITS = np.uint64((1 << SIDE) - 1)
NOTHING = np.uint64(0)


@njit(cache=True, nogil=True, error_model="numpy")
def take_tile(tiles: Tiles, stamp: int) -> int:
    """Return an unused tile without known voxels; one must be left."""
    tiles.left[0] -= 1
    tile = tiles.unused[tiles.left[0]]
    first = np.uint64(tile) * np.uint64(VOXELS)
    for i in range(np.uint64(VOXELS)):
        tiles.log_odds[first + i] = np.nan
    tiles.written[tile] = tiles.turned[tile] = stamp
    return tile


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _add_misses(first: np.uint64, bits: np.uint64, model: Model, log_odds: np.ndarray) -> tuple[bool, bool]:
    """Add a miss to a row's marked voxels. Return whether a value changed, and whether a voxel's kind did."""
    marked, one, zero = np.uint32(bits), np.uint32(1), np.float32(0.0)
    open_ones = np.uint32(0)
    for i in range(np.uint64(SIDE)):
        open_ones |= np.uint32(not log_odds[first + i] <= model.low) & (marked >> np.uint32(i))
    if not open_ones & one:  # as in most of the free space: no voxel can change
        return False, False
    changed, turned = np.uint32(0), np.uint32(0)
    for i in range(np.uint64(SIDE)):
        old = log_odds[first + i]
        known = old if old == old else zero
        new = min(max(known + model.miss, model.low), model.high)
        new = new if (marked >> np.uint32(i)) & one else old
        log_odds[first + i] = new
        is_new = np.uint32(old != old) ^ np.uint32(new != new)
        changed |= is_new | np.uint32(old < new) | np.uint32(new < old)
        turned |= is_new | (np.uint32(old >= zero) ^ np.uint32(new >= zero))
    return changed != 0, turned != 0


@njit(cache=True, nogil=True, error_model="numpy")
def _add_hits(first: np.uint64, bits: np.uint64, model: Model, log_odds: np.ndarray) -> tuple[bool, bool]:
    """Add a hit to a row's marked voxels. Return whether a value changed, and whether a voxel's kind did."""
    changed, turned = False, False
    zero = np.float32(0.0)
    for i in range(np.uint64(SIDE)):
        if bits >> i & np.uint64(1):
            old = log_odds[first + i]
            known = old if old == old else zero
            new = min(max(known + model.hit, model.low), model.high)
            log_odds[first + i] = new
            changed = changed or new != old
            turned = turned or old != old or (old >= zero) != (new >= zero)
    return changed, turned


@njit(cache=True, nogil=True, error_model="numpy")
def enter_board(
    misses: np.ndarray,
    hits: np.ndarray,
    corner: np.ndarray,
    shape: np.ndarray,
    table: np.ndarray,
    table_corner: np.ndarray,
    stamp: int,
    model: Model,
    tiles: Tiles,
    are_touched: np.ndarray,
) -> bool:
    """Enter the marked voxels into tiles, and clear the board. A hit voxel gets no miss.

    Args:
        misses: (words,) uint64: a bit for each voxel that a ray crosses.
        hits: (words,) uint64: a bit for each voxel in which one ends.
        corner: (3,) int64: tile of the board's first bit, x, y, z.
        shape: (3,) int64 of the board, x, y, z: tiles. Along x, the tiles fill words.
        table: (d, h, w) int32: the map's tiles; covers all that is marked. CLOSED places are left out.
        table_corner: (3,) int64: tile of the table's first place, x, y, z.
        stamp: of this change.
        model: of the sensor.
        tiles: the map's.
        are_touched: (tiles,) uint8 of the board, z, y, x: becomes 1 where a voxel is marked.

    Returns:
        False if the tiles ran out. Then call it again with more of them. What is entered is no longer marked.
    """
    words = shape[0] // PER_WORD
    for tile_z in range(shape[2]):
        for tile_y in range(shape[1]):
            for row in range(ROWS):
                z, y = (tile_z << SIDE_BITS) + (row >> SIDE_BITS), (tile_y << SIDE_BITS) + (row & SIDE - 1)
                first_word = (z * (shape[1] << SIDE_BITS) + y) * words
                for word in range(words):
                    free, full = misses[first_word + word], hits[first_word + word]
                    if free | full == NOTHING:
                        continue
                    free &= ~full
                    for part in range(PER_WORD):
                        shift = np.uint64(part * SIDE)
                        free_row, full_row = free >> shift & ROW_BITS, full >> shift & ROW_BITS
                        if free_row | full_row == NOTHING:
                            continue
                        tile_x = word * PER_WORD + part
                        are_touched[(tile_z * shape[1] + tile_y) * shape[0] + tile_x] = 1
                        at = (
                            tile_z + corner[2] - table_corner[2],
                            tile_y + corner[1] - table_corner[1],
                            tile_x + corner[0] - table_corner[0],
                        )
                        tile = table[at]
                        if tile == CLOSED:
                            continue
                        if tile == UNSEEN:
                            if tiles.left[0] == 0:
                                return False
                            tile = take_tile(tiles, stamp)
                            table[at] = tile
                        first = np.uint64(tile * VOXELS + row * SIDE)
                        changed, turned = _add_misses(first, free_row, model, tiles.log_odds)
                        if full_row != NOTHING:
                            hit_changed, hit_turned = _add_hits(first, full_row, model, tiles.log_odds)
                            changed, turned = changed or hit_changed, turned or hit_turned
                        if changed:
                            tiles.written[tile] = stamp
                        if turned:
                            tiles.turned[tile] = stamp
                        keep = ~(ROW_BITS << shift)
                        misses[first_word + word] &= keep
                        hits[first_word + word] &= keep
                    misses[first_word + word] = NOTHING
                    hits[first_word + word] = NOTHING
    return True
