"""Octrees of voxels as OctoMap prunes and streams them.

A node with eight leaves of the same value becomes a leaf itself. OctoMap's tree has 16 levels below its root.
A tile is a node of level 12. `encode_tiles` writes what is below each tile, `assemble` what is above.
"""

from __future__ import annotations

import numpy as np

from gridslam.volume.kernels.tiles import SIDE_BITS, VOXELS
from kernel_cache.compiler import njit

NONE, LEAF, INNER = 0, 1, 3
"""Kinds of nodes. INNER is also the code of a node with children in a binary stream."""
TILE_LEVEL = 12
"""Of a tile's node; the root's is 0."""
NODES = 1 + 8 + 64 + 512 + VOXELS
"""In a tile's pyramid: from level 12 on, level by level, each in Morton order."""
STARTS = (0, 1, 9, 73, 585)
"""First node of each level in a pyramid."""
BINARY_BYTES_MAX = 2 * 585
"""Of a tile in a binary stream."""
FULL_BYTES_MAX = 5 * NODES
"""Of a tile in a full stream."""


def _morton_order() -> np.ndarray:
    """Return the place (VOXELS,) in a tile of each voxel in Morton order, in which x is the lowest bit."""
    codes = np.arange(VOXELS)
    order = np.zeros(VOXELS, np.int64)
    for bit in range(SIDE_BITS):
        for axis in range(3):
            order += (codes >> 3 * bit + axis & 1) << bit + SIDE_BITS * axis
    return order


MORTON = _morton_order()


@njit(cache=True, nogil=True)
def _prune(first: int, values: np.ndarray, kinds: np.ndarray) -> tuple[int, np.float32]:
    """Return kind and value of the node above eight children, whose first is given."""
    known, leaves, greatest = 0, 0, np.float32(-np.inf)
    for child in range(first, first + 8):
        if kinds[child] != NONE:
            known += 1
            leaves += kinds[child] == LEAF and values[child] == values[first]
            greatest = max(greatest, values[child])
    if known == 0:
        return NONE, np.float32(np.nan)
    return (LEAF if leaves == 8 else INNER), greatest


@njit(cache=True, nogil=True)
def _pyramid(cube: np.ndarray, values: np.ndarray, kinds: np.ndarray) -> None:
    """Fill the values and kinds (NODES,) of a tile's pyramid from its log-odds (VOXELS,)."""
    for i in range(VOXELS):
        value = cube[MORTON[i]]
        values[STARTS[4] + i] = value
        kinds[STARTS[4] + i] = NONE if value != value else LEAF
    for level in range(3, -1, -1):
        for i in range(1 << 3 * level):
            kind, value = _prune(STARTS[level + 1] + 8 * i, values, kinds)
            kinds[STARTS[level] + i], values[STARTS[level] + i] = kind, value


@njit(cache=True, nogil=True)
def _put_value(value: np.float32, at: int, word: np.ndarray, stream: np.ndarray) -> int:
    """Write a value in four bytes, the lowest first. ``word`` (4,) is scratch. Return the place behind it."""
    word.view(np.float32)[0] = value
    for i in range(4):
        stream[at + i] = word[i]
    return at + 4


@njit(cache=True, nogil=True)
def _put_children(first: int, kinds: np.ndarray, at: int, stream: np.ndarray) -> int:
    """Write which of eight children there are, for a full stream. Return the place behind it."""
    bits = 0
    for child in range(8):
        bits |= (kinds[first + child] != NONE) << child
    stream[at] = bits
    return at + 1


@njit(cache=True, nogil=True)
def _put_kinds(first: int, values: np.ndarray, kinds: np.ndarray, at: int, stream: np.ndarray) -> int:
    """Write the kinds of eight children, for a binary stream. Return the place behind it."""
    for half in range(2):
        bits = 0
        for i in range(4):
            child = first + 4 * half + i
            bits |= _code(kinds[child], values[child]) << 2 * i
        stream[at + half] = bits
    return at + 2


@njit(cache=True, nogil=True)
def _code(kind: int, value: float) -> int:
    """Return the code of a node in a binary stream: 0 none, 1 free, 2 occupied, 3 with children."""
    if kind == LEAF:
        return 2 if value >= 0.0 else 1
    return kind


@njit(cache=True, nogil=True)
def _put_tile(
    values: np.ndarray, kinds: np.ndarray, is_binary: bool, at: int, word: np.ndarray, stream: np.ndarray
) -> int:
    """Write a tile's subtree, with its own node in a full stream. Return the place behind it."""
    # Of the node whose turn it is: its level below the tile, and its place on each level down to that
    level, path = 0, np.zeros(5, np.int64)
    while True:
        node = STARTS[level] + path[level]
        descends = kinds[node] == INNER
        if not is_binary and kinds[node] != NONE:
            at = _put_value(values[node], at, word, stream)
            if descends:
                at = _put_children(STARTS[level + 1] + 8 * path[level], kinds, at, stream)
            else:
                stream[at] = 0
                at += 1
        elif is_binary and descends:
            at = _put_kinds(STARTS[level + 1] + 8 * path[level], values, kinds, at, stream)
        if descends and not (is_binary and level == 3):
            path[level + 1] = 8 * path[level]
            level += 1
            continue
        while level > 0 and path[level] & 7 == 7:
            level -= 1
        if level == 0:
            return at
        path[level] += 1


@njit(cache=True, nogil=True)
def encode_tiles(
    cubes: np.ndarray,
    is_binary: bool,
    tile_kinds: np.ndarray,
    tile_values: np.ndarray,
    lengths: np.ndarray,
    stream: np.ndarray,
) -> tuple[int, int]:
    """Write the subtrees of tiles one after the other.

    Args:
        cubes: (n, VOXELS) float32 log-odds, NaN for unknown ones.
        is_binary: whether voxels are only free or occupied; then values become -1 and 1.
        tile_kinds: (n,) uint8 takes each tile's kind.
        tile_values: (n,) float32 takes each tile's value.
        lengths: (n,) int64 takes the bytes of each tile.
        stream: uint8 takes the bytes. It has room for the most that n tiles may need.

    Returns:
        The bytes, and the number of nodes below the tiles.
    """
    values, kinds = np.empty(NODES, np.float32), np.empty(NODES, np.uint8)
    cube, word = np.empty(VOXELS, np.float32), np.empty(4, np.uint8)
    at, nodes = 0, 0
    for tile in range(cubes.shape[0]):
        for i in range(VOXELS):
            value = cubes[tile, i]
            if is_binary and value == value:
                value = np.float32(1.0) if value >= 0.0 else np.float32(-1.0)
            cube[i] = value
        _pyramid(cube, values, kinds)
        start = at
        if kinds[0] == INNER or (kinds[0] == LEAF and not is_binary):
            at = _put_tile(values, kinds, is_binary, at, word, stream)
        tile_kinds[tile], tile_values[tile], lengths[tile] = kinds[0], values[0], at - start
        nodes += _nodes_below(kinds)
    return at, nodes


@njit(cache=True, nogil=True)
def _nodes_below(kinds: np.ndarray) -> int:
    """Return the number of nodes below a tile's own, without those that are pruned."""
    nodes = 0
    for level in range(4):
        for i in range(1 << 3 * level):
            if kinds[STARTS[level] + i] == INNER:
                first = STARTS[level + 1] + 8 * i
                for child in range(first, first + 8):
                    nodes += kinds[child] != NONE
    return nodes
