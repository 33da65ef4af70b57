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
    for i in range(np.uint64(ROWS)):
        tiles.sure[np.uint64(tile) * np.uint64(ROWS) + i] = 0
    tiles.written[tile] = tiles.turned[tile] = stamp
    return tile


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _add_misses(
    first: np.uint64, bits: np.uint64, model: Model, log_odds: np.ndarray
) -> tuple[bool, bool, np.uint16]:
    """Add a miss to a row's marked voxels.

    Returns whether a value changed, whether a voxel's kind did, and which voxels have the least value then.
    """
    marked, one, zero = np.uint32(bits), np.uint32(1), np.float32(0.0)
    changed, turned, sure = np.uint32(0), np.uint32(0), np.uint32(0)
    for i in range(np.uint64(SIDE)):
        old = log_odds[first + i]
        known = old if old == old else zero
        new = min(max(known + model.miss, model.low), model.high)
        new = new if (marked >> np.uint32(i)) & one else old
        log_odds[first + i] = new
        is_new = np.uint32(old != old) ^ np.uint32(new != new)
        changed |= is_new | np.uint32(old < new) | np.uint32(new < old)
        turned |= is_new | (np.uint32(old >= zero) ^ np.uint32(new >= zero))
        sure |= np.uint32(new == model.low) << np.uint32(i)
    return changed != 0, turned != 0, np.uint16(sure)


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
        False if fewer than PER_WORD tiles are left. Then call it again with more of them. What is entered is
        no longer marked.
    """
    words = shape[0] // PER_WORD
    free, full = np.empty(ROWS, np.uint64), np.empty(ROWS, np.uint64)
    for tile_z in range(shape[2]):
        for tile_y in range(shape[1]):
            for word in range(words):
                marked = _words_of_tiles(misses, hits, tile_z, tile_y, word, shape, free, full)
                if marked == NOTHING:
                    continue
                if tiles.left[0] < PER_WORD:
                    return False
                for part in range(PER_WORD):
                    shift = np.uint64(part * SIDE)
                    if marked >> shift & ROW_BITS == NOTHING:
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
                        tile = take_tile(tiles, stamp)
                        table[at] = tile
                    given = free, full, shift, model, tiles.log_odds, tiles.sure
                    changed, turned = _enter_tile(tile, *given)
                    if changed:
                        tiles.written[tile] = stamp
                    if turned:
                        tiles.turned[tile] = stamp
                _clear_words(misses, hits, tile_z, tile_y, word, shape)
    return True


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _first_word(tile_z: int, tile_y: int, word: int, shape: np.ndarray) -> tuple[int, int, int]:
    """Return the board's word of the first row of PER_WORD tiles, and the words to the next row and layer."""
    words = shape[0] // PER_WORD
    layer = (shape[1] << SIDE_BITS) * words
    return (tile_z << SIDE_BITS) * layer + (tile_y << SIDE_BITS) * words + word, words, layer


@njit(cache=True, nogil=True, error_model="numpy")
def _words_of_tiles(
    misses: np.ndarray,
    hits: np.ndarray,
    tile_z: int,
    tile_y: int,
    word: int,
    shape: np.ndarray,
    free: np.ndarray,
    full: np.ndarray,
) -> np.uint64:
    """Copy the words (ROWS,) of PER_WORD tiles from the board; return what is marked in any of them."""
    first, per_row, per_layer = _first_word(tile_z, tile_y, word, shape)
    marked = NOTHING
    for row in range(ROWS):
        at = first + (row >> SIDE_BITS) * per_layer + (row & SIDE - 1) * per_row
        full[row] = hits[at]
        free[row] = misses[at] & ~full[row]
        marked |= free[row] | full[row]
    return marked


@njit(cache=True, nogil=True, error_model="numpy")
def _clear_words(
    misses: np.ndarray, hits: np.ndarray, tile_z: int, tile_y: int, word: int, shape: np.ndarray
) -> None:
    """Take back what is marked in PER_WORD tiles."""
    first, per_row, per_layer = _first_word(tile_z, tile_y, word, shape)
    for row in range(ROWS):
        at = first + (row >> SIDE_BITS) * per_layer + (row & SIDE - 1) * per_row
        misses[at] = hits[at] = NOTHING


@njit(cache=True, nogil=True, error_model="numpy")
def _enter_tile(
    tile: int,
    free: np.ndarray,
    full: np.ndarray,
    shift: np.uint64,
    model: Model,
    log_odds: np.ndarray,
    sure: np.ndarray,
) -> tuple[bool, bool]:
    """Enter the marked voxels of a tile, whose bits begin at shift in the words (ROWS,) of its rows.

    Returns whether a value changed, and whether a voxel's kind did.
    """
    changed, turned = False, False
    first = np.uint64(tile) * np.uint64(ROWS)
    for row in range(np.uint64(ROWS)):
        free_row, full_row = free[row] >> shift & ROW_BITS, full[row] >> shift & ROW_BITS
        at = first + row
        if free_row & ~np.uint64(sure[at]):  # in most of the free space, no voxel can change
            row_changed, row_turned, sure[at] = _add_misses(at * np.uint64(SIDE), free_row, model, log_odds)
            changed, turned = changed or row_changed, turned or row_turned
        if full_row != NOTHING:
            row_changed, row_turned = _add_hits(at * np.uint64(SIDE), full_row, model, log_odds)
            sure[at] &= ~np.uint16(full_row)
            changed, turned = changed or row_changed, turned or row_turned
    return changed, turned
