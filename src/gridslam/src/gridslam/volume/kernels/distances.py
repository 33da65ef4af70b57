"""Truncated Euclidean distances to occupied voxels, exact, along one axis after the other.

The square of a distance is the least sum of squares along x, y and z (Felzenszwalb and Huttenlocher, 2012).
With a truncation of some tens of voxels, the search along an axis tries all of them: rows of uint16 are
compared at once.
"""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

FAR = np.uint16(60000)
"""Square of a distance beyond the truncation. A square within it can be added without an overflow."""


@njit(cache=True, nogil=True)
def _along_x(occupied: np.ndarray, reach: int, squares: np.ndarray) -> None:
    """Fill squares (d, h, w) of the distance along x within rows of occupied (d, h, w + 2 * reach)."""
    width = occupied.shape[2]
    for z in range(occupied.shape[0]):
        for y in range(occupied.shape[1]):
            last = -width
            for x in range(width - reach):
                if occupied[z, y, x]:
                    last = x
                if x >= reach:
                    way = x - last
                    squares[z, y, x - reach] = way * way if way <= reach else FAR
            last = 2 * width
            for x in range(width - 1, reach - 1, -1):
                if occupied[z, y, x]:
                    last = x
                if x < width - reach:
                    way = last - x
                    if way <= reach and way * way < squares[z, y, x - reach]:
                        squares[z, y, x - reach] = way * way


@njit(cache=True, nogil=True)
def _lower(target: np.ndarray, other: np.ndarray, added: np.uint16) -> None:
    """Lower a row's values to those of another row plus a number."""
    for x in range(target.size):
        value = np.uint16(other[x] + added)
        target[x] = value if value < target[x] else target[x]


@njit(cache=True, nogil=True)
def block_squares(occupied: np.ndarray, reach: int) -> np.ndarray:
    """Return the squared distances in voxels, at most reach**2, in the middle of a block.

    Args:
        occupied: (d + 2 * reach, h + 2 * reach, w + 2 * reach) bool.
        reach: voxels, at most 200.

    Returns:
        (d, h, w) uint16.
    """
    depth, height, width = occupied.shape
    along_x = np.empty((depth, height, width - 2 * reach), np.uint16)
    _along_x(occupied, reach, along_x)
    along_y = np.full((depth, height - 2 * reach, width - 2 * reach), FAR, np.uint16)
    for z in range(depth):
        for y in range(height - 2 * reach):
            for way in range(-reach, reach + 1):
                _lower(along_y[z, y], along_x[z, y + reach + way], np.uint16(way * way))
    squares = np.full((depth - 2 * reach, height - 2 * reach, width - 2 * reach), reach**2, np.uint16)
    for z in range(depth - 2 * reach):
        for y in range(height - 2 * reach):
            for way in range(-reach, reach + 1):
                _lower(squares[z, y], along_y[z + reach + way, y], np.uint16(way * way))
    return squares


@njit(cache=True, nogil=True)
def mark_frontiers(kinds: np.ndarray, are_frontiers: np.ndarray) -> None:
    """Mark free voxels beside an unknown one, in the middle of kinds (d + 2, h + 2, w + 2), uint8.

    are_frontiers: (d, h, w) bool. The six neighbours that share a side count.
    """
    for z in range(1, kinds.shape[0] - 1):
        for y in range(1, kinds.shape[1] - 1):
            for x in range(1, kinds.shape[2] - 1):
                is_beside_unknown = (
                    (kinds[z, y, x - 1] == 0)
                    | (kinds[z, y, x + 1] == 0)
                    | (kinds[z, y - 1, x] == 0)
                    | (kinds[z, y + 1, x] == 0)
                    | (kinds[z - 1, y, x] == 0)
                    | (kinds[z + 1, y, x] == 0)
                )
                are_frontiers[z - 1, y - 1, x - 1] = (kinds[z, y, x] == 1) & is_beside_unknown
