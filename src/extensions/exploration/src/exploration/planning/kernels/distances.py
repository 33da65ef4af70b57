"""Exact distances to blocked voxels, cut at a reach, along one axis after the other.

The square of a distance is the least sum of squares along x, y and z (Felzenszwalb and Huttenlocher, 2012).
With a reach of some tens of voxels, trying each place along an axis is fastest, a row of uint16 at once.
"""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

REACH_MAX = 150
"""Voxels: two squares of it add up to less than uint16 holds."""
FACE_REACH_MAX = 90
"""The same for distances to faces."""


@njit(cache=True, nogil=True)
def _square(way: int, to_faces: bool) -> int:
    """Return the square of a way of so many voxels: to the centre, or to the near face in half voxels."""
    return (2 * way - 1) ** 2 if to_faces and way > 0 else way * way


@njit(cache=True, nogil=True)
def _along_rows(blocked: np.ndarray, reach: int, squares: np.ndarray, to_faces: bool) -> None:
    """Fill squares (d, h, w) with those of the distances along x in blocked (d, h, w)."""
    depth, height, width = blocked.shape
    for z in range(depth):
        for y in range(height):
            way = reach
            for x in range(width):
                way = 0 if blocked[z, y, x] else min(way + 1, reach)
                squares[z, y, x] = _square(way, to_faces)
            way = reach
            for x in range(width - 1, -1, -1):
                way = 0 if blocked[z, y, x] else min(way + 1, reach)
                squares[z, y, x] = min(squares[z, y, x], _square(way, to_faces))


@njit(cache=True, nogil=True)
def _lower(row: np.ndarray, other: np.ndarray, added: np.uint16) -> None:
    """Lower a row to another row plus a number."""
    for x in range(row.size):
        value = np.uint16(other[x] + added)
        row[x] = value if value < row[x] else row[x]


@njit(cache=True, nogil=True)
def squared_clearances(blocked: np.ndarray, reach: int, to_faces: bool = False) -> np.ndarray:
    """Return (d, h, w) uint16: squared distances to the nearest blocked voxel, at most that of the reach.

    blocked: (d, h, w) bool. Nothing outside it counts. reach: voxels. to_faces: the distance is that from a
    voxel's centre to the blocked one's nearest point, in half voxels; else to its centre, in voxels.
    """
    along_x = np.empty(blocked.shape, np.uint16)
    _along_rows(blocked, reach, along_x, to_faces)
    depth, height, _ = blocked.shape
    most = np.uint16(_square(reach, to_faces))
    along_y = np.full(blocked.shape, most)
    for z in range(depth):
        for y in range(height):
            for other in range(max(0, y - reach), min(height, y + reach + 1)):
                _lower(along_y[z, y], along_x[z, other], np.uint16(_square(abs(other - y), to_faces)))
    squares = np.full(blocked.shape, most)
    for z in range(depth):
        for other in range(max(0, z - reach), min(depth, z + reach + 1)):
            for y in range(height):
                _lower(squares[z, y], along_y[other, y], np.uint16(_square(abs(other - z), to_faces)))
    return squares
