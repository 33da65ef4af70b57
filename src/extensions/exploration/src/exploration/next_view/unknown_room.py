"""Unknown room: where the UAV would fit if all that is unknown were free."""

from __future__ import annotations

import math

import numpy as np
from scipy import ndimage

from exploration.planning import UNKNOWN
from exploration.planning.if_free import clearances_if_free
from exploration.planning.kernels.distances import squared_clearances
from exploration.planning.space import Space

TOUCHING = np.ones((3, 3, 3), bool)
"""Voxels that share a face, an edge or a corner hang together."""
PIECE_M3, SMALL_SHARE = 1.0, 0.001
"""Smaller pieces of room, in which a UAV hardly turns, count only if all of them are more than this share of
what is known. A large mine is not flown on for a minute for its last niches.
"""


def is_near_room(space: Space, nodes: np.ndarray, least_m3: float) -> np.ndarray:
    """Return (d, h, w) which voxels are so near to a way into unknown room that they may open or close it.

    Room is what the UAV's centre could reach if all that is unknown were free. A way into it ends where the
    centre would enter what is unknown, after places that are free but not clear. nodes: (n, 3) z, y, x, that
    a way leads to. least_m3: less room in one piece does not count.
    """
    reach = math.isqrt(space.need - 1) + 1
    fits = clearances_if_free(space, reach) >= space.need
    is_unclear = space.squares < space.need
    room = unknown_room(space, fits, nodes, least_m3)
    if not room.any():
        return room
    known = joined(fits & (space.grid.kinds != UNKNOWN), nodes)
    gates = room & ndimage.binary_dilation(known, TOUCHING)
    ways = gates | joined(known & is_unclear | gates, np.argwhere(gates))
    near: np.ndarray = squared_clearances(ways, reach) < reach * reach
    return near


def unknown_room(space: Space, fits: np.ndarray, nodes: np.ndarray, least_m3: float) -> np.ndarray:
    """Return (d, h, w) where the UAV's centre could be in what is unknown; see `is_near_room`.

    fits: (d, h, w) where it could be if all that is unknown were free.
    """
    is_unknown = (space.grid.kinds == UNKNOWN) & (space.squares < space.need)
    voxel_m3 = space.grid.resolution_m**3
    spare = SMALL_SHARE * space.grid.known if least_m3 > 0.0 else 0.0  # at 0, all room counts
    return _large(joined(fits, nodes) & is_unknown, least_m3 / voxel_m3, PIECE_M3 / voxel_m3, spare)


def _large(marked: np.ndarray, voxels_min: float, small_max: float, spare: float) -> np.ndarray:
    """Return (d, h, w) the marked voxels without the pieces that have fewer voxels.

    small_max: pieces of fewer voxels count only if all of them together have more than `spare`.
    """
    pieces, _ = ndimage.label(marked, TOUCHING)
    sizes = np.bincount(pieces.ravel())
    is_large = sizes >= voxels_min
    is_large[0] = False
    small = is_large & (sizes < small_max)
    if sizes[small].sum() <= spare:
        is_large[small] = False
    large: np.ndarray = is_large[pieces]
    return large


def joined(fits: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return (d, h, w) what hangs together with nodes (n, 3), by faces, edges or corners."""
    pieces, count = ndimage.label(fits, TOUCHING)
    is_joined = np.zeros(count + 1, bool)
    is_joined[pieces[tuple(nodes.T)]] = True
    is_joined[0] = False
    hangs: np.ndarray = is_joined[pieces]
    return hangs
