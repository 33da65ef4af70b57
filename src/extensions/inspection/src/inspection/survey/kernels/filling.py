"""Marks the voxels that triangles cross."""

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
