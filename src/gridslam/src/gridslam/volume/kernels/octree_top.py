"""The part of an octree above its tiles, in OctoMap's streams."""

from __future__ import annotations

import numpy as np

from gridslam.volume.kernels.octree import INNER, LEAF, NONE, TILE_LEVEL
from kernel_cache.compiler import njit


@njit(cache=True, nogil=True)
def grow_levels(
    codes: np.ndarray, kinds: np.ndarray, values: np.ndarray, firsts: np.ndarray, counts: np.ndarray
) -> int:
    """Make the nodes above tiles, level by level, up to the root.

    Args:
        codes: (TILE_LEVEL + 1, n) int64: Morton codes by level; the last row holds the tiles', in order.
        kinds: (TILE_LEVEL + 1, n) uint8, likewise.
        values: (TILE_LEVEL + 1, n) float32, likewise: a node has the greatest of its children.
        firsts: (TILE_LEVEL + 1, n + 1) int64 takes the first child of each node, on the next level.
        counts: (TILE_LEVEL + 1,) int64: nodes of each level; the last is n.

    Returns:
        The number of nodes from the root to the tiles, without pruned ones.
    """
    nodes = 1
    for level in range(TILE_LEVEL - 1, -1, -1):
        below, count = level + 1, 0
        child = 0
        while child < counts[below]:
            code, first, leaves = codes[below, child] >> 3, child, 0
            greatest = np.float32(-np.inf)
            while child < counts[below] and codes[below, child] >> 3 == code:
                leaves += kinds[below, child] == LEAF and values[below, child] == values[below, first]
                greatest = max(greatest, values[below, child])
                child += 1
            codes[level, count], firsts[level, count], values[level, count] = code, first, greatest
            kinds[level, count] = LEAF if leaves == 8 else INNER
            if leaves != 8:
                nodes += child - first
            count += 1
        counts[level], firsts[level, count] = count, counts[below]
    return nodes


@njit(cache=True, nogil=True)
def assemble(
    codes: np.ndarray,
    kinds: np.ndarray,
    values: np.ndarray,
    firsts: np.ndarray,
    tile_starts: np.ndarray,
    tile_stream: np.ndarray,
    is_binary: bool,
    stream: np.ndarray,
) -> int:
    """Write a whole octree's stream.

    Args:
        codes: as `grow_levels` has left them; so are kinds, values and firsts.
        kinds: see there.
        values: see there.
        firsts: see there.
        tile_starts: (n + 1,) int64: where each tile's bytes begin.
        tile_stream: uint8 of `encode_tiles`.
        is_binary: as there.
        stream: uint8 takes the bytes.

    Returns:
        The number of bytes.
    """
    at, level, word = 0, 0, np.empty(4, np.uint8)
    nodes = np.zeros(TILE_LEVEL + 1, np.int64)  # whose turn it is, on each level
    while True:
        node = nodes[level]
        descends = kinds[level, node] == INNER and level < TILE_LEVEL
        if level == TILE_LEVEL:
            for i in range(tile_starts[node], tile_starts[node + 1]):
                stream[at] = tile_stream[i]
                at += 1
        elif not is_binary:
            word.view(np.float32)[0] = values[level, node]
            for i in range(4):
                stream[at + i] = word[i]
            stream[at + 4] = 0
            at += 5
        if descends:
            first, end = firsts[level, node], firsts[level, node + 1]
            bits = 0
            for child in range(first, end):
                octant = codes[level + 1, child] & 7
                if is_binary:
                    bits |= _code(kinds[level + 1, child], values[level + 1, child]) << 2 * octant
                else:
                    bits |= 1 << octant
            if is_binary:
                stream[at], stream[at + 1] = bits & 255, bits >> 8
                at += 2
            else:
                stream[at - 1] = bits
            level += 1
            nodes[level] = first
            continue
        while level > 0 and nodes[level] + 1 == firsts[level - 1, nodes[level - 1] + 1]:
            level -= 1
        if level == 0:
            return at
        nodes[level] += 1


@njit(cache=True, nogil=True)
def _code(kind: int, value: float) -> int:
    """Return the code of a node in a binary stream: 0 none, 1 free, 2 occupied, 3 with children."""
    if kind == LEAF:
        return 2 if value >= 0.0 else 1
    return INNER if kind == INNER else NONE
