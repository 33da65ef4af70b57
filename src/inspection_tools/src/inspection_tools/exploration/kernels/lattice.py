"""Edges of a lattice in free space."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

NEIGHBOURS = np.array(
    [(z, y, x) for z in (-1, 0, 1) for y in (-1, 0, 1) for x in (-1, 0, 1) if (z, y, x) > (0, 0, 0)],
    np.int64,
)
"""(13, 3) one of each pair of opposite steps."""


@njit(cache=True, nogil=True)
def open_edges(
    squares: np.ndarray, need: int, numbers: np.ndarray, spacing: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the edges of which every voxel keeps the clearance: two nodes (n,) and lengths (n,) in voxels.

    Args:
        squares: (d, h, w) squared clearances, voxels.
        need: squared clearance that a path keeps.
        numbers: of the nodes, -1 where there is none.
        spacing: nodes are at every so many voxels along each axis.
    """
    size = 13 * (numbers.size if numbers.size > 0 else 1)
    heads, tails = np.empty(size, np.int64), np.empty(size, np.int64)
    lengths = np.empty(size)
    count = 0
    for z, y, x in np.ndindex(numbers.shape):
        if numbers[z, y, x] < 0:
            continue
        for k in range(13):
            dz, dy, dx = NEIGHBOURS[k]
            c, b, a = z + dz, y + dy, x + dx
            inside = 0 <= c < numbers.shape[0] and 0 <= b < numbers.shape[1] and 0 <= a < numbers.shape[2]
            if not inside or numbers[c, b, a] < 0:
                continue
            clear = True
            for step in range(1, spacing):
                if squares[z * spacing + step * dz, y * spacing + step * dy, x * spacing + step * dx] < need:
                    clear = False
                    break
            if clear:
                heads[count], tails[count] = numbers[z, y, x], numbers[c, b, a]
                lengths[count] = spacing * np.sqrt(float(dz * dz + dy * dy + dx * dx))
                count += 1
    return heads[:count], tails[:count], lengths[:count]
