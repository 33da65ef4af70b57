"""Marks the voxels that triangles cross, and tells where air gets to between them."""

from __future__ import annotations

import math

import numpy as np

from kernel_cache.compiler import njit

ON_EDGE = 1e-6


@njit(cache=True, nogil=True)
def mark_columns(triangles: np.ndarray, blocked: np.ndarray) -> None:
    """Mark the voxels where triangles cross the middle lines of columns along their steepest axis.

    So no way from voxel to voxel over faces leads through a triangle.

    Args:
        triangles: (m, 3, 3) corners, z, y, x in voxels.
        blocked: (d, h, w) bool.
    """
    for t in range(len(triangles)):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        n = np.cross(b - a, c - a)
        k = int(np.argmax(np.abs(n)))
        u, v = (k + 1) % 3, (k + 2) % 3
        area = n[k]
        if area == 0.0:
            continue
        low_u = max(math.ceil(min(a[u], b[u], c[u]) - 0.5 - ON_EDGE), 0)
        high_u = min(math.floor(max(a[u], b[u], c[u]) - 0.5 + ON_EDGE), blocked.shape[u] - 1)
        low_v = max(math.ceil(min(a[v], b[v], c[v]) - 0.5 - ON_EDGE), 0)
        high_v = min(math.floor(max(a[v], b[v], c[v]) - 0.5 + ON_EDGE), blocked.shape[v] - 1)
        voxel = np.zeros(3, np.int64)
        for i in range(low_u, high_u + 1):
            for j in range(low_v, high_v + 1):
                pu, pv = i + 0.5, j + 0.5
                wa = ((b[u] - pu) * (c[v] - pv) - (b[v] - pv) * (c[u] - pu)) / area
                wb = ((c[u] - pu) * (a[v] - pv) - (c[v] - pv) * (a[u] - pu)) / area
                wc = 1.0 - wa - wb
                if wa < -ON_EDGE or wb < -ON_EDGE or wc < -ON_EDGE:
                    continue
                voxel[u], voxel[v] = i, j
                voxel[k] = math.floor(wa * a[k] + wb * b[k] + wc * c[k])
                if 0 <= voxel[k] < blocked.shape[k]:
                    blocked[voxel[0], voxel[1], voxel[2]] = True


@njit(cache=True, nogil=True)
def reached_from(blocked: np.ndarray, begins: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and the last voxel (3,) of the box around what is reached from some voxels over faces.

    It takes a byte for each voxel, and some for those at the front of what is reached so far.

    Args:
        blocked: (d, h, w) bool, what nothing passes.
        begins: (d, h, w) bool, none of them blocked.
    """
    depth, height, width = blocked.shape
    first, last = np.array((depth, height, width)), np.full(3, -1)
    closed = blocked.copy()
    left = np.empty(4096, np.int32)  # `MOST_VOXELS` fit
    count = 0
    for i in range(depth):
        for j in range(height):
            for k in range(width):
                if not begins[i, j, k] or closed[i, j, k]:
                    continue
                closed[i, j, k] = True
                left[0] = (i * height + j) * width + k
                count = 1
                while count:
                    count -= 1
                    place = left[count]
                    z, y, x = place // (height * width), place // width % height, place % width
                    first[0], first[1], first[2] = min(first[0], z), min(first[1], y), min(first[2], x)
                    last[0], last[1], last[2] = max(last[0], z), max(last[1], y), max(last[2], x)
                    if count + 6 > len(left):
                        left = np.concatenate((left, np.empty(len(left), np.int32)))
                    for axis in range(3):
                        for step in (-1, 1):
                            a = z + step if axis == 0 else z
                            b = y + step if axis == 1 else y
                            c = x + step if axis == 2 else x
                            if a < 0 or b < 0 or c < 0 or a >= depth or b >= height or c >= width:
                                continue
                            if not closed[a, b, c]:
                                closed[a, b, c] = True
                                left[count] = (a * height + b) * width + c
                                count += 1
    return first, last
