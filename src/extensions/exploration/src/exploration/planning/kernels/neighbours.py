"""The 26 voxels around one, and the rule by which a path may step from voxel to voxel."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

STEPS = np.array(
    [(z, y, x) for z in (-1, 0, 1) for y in (-1, 0, 1) for x in (-1, 0, 1) if (z, y, x) != (0, 0, 0)],
    np.int64,
)
"""(26, 3) z, y, x."""
LENGTHS = np.sqrt((STEPS**2).sum(axis=1))
"""(26,) in voxels."""


@njit(cache=True, nogil=True)
def may_step(here: int, there: int, need: int) -> bool:
    """Return whether a path may go on to a voxel.

    Args:
        here: squared clearance of the voxel that it comes from.
        there: that of the next one.
        need: squared clearance that a path keeps. A path that begins nearer may only go outward.
    """
    return there >= need or (here < need and there >= here and there > 0)
