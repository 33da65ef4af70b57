"""A hash table of voxels, by their level and place: open addressing, linear probing."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit

EMPTY = -1
HALF = 1 << 19
"""Voxels are counted from -HALF to HALF along each axis."""
MASK = (1 << 20) - 1
MULTIPLIER = np.uint64(0x9E3779B97F4A7C15)
"""2^64 by the golden ratio (Knuth, The Art of Computer Programming 3, 6.4)."""


@njit(cache=True)
def key_of(level: int, i: int, j: int, k: int) -> int:
    """Return the key of a voxel. i, j, k: its place in voxels of its level."""
    return (level << 60) | ((i + HALF) & MASK) << 40 | ((j + HALF) & MASK) << 20 | ((k + HALF) & MASK)


@njit(cache=True)
def slot_of(keys: np.ndarray, key: int) -> int:
    """Return the slot that holds a key, or the empty one where it belongs. keys: (2^n,) int64."""
    last = len(keys) - 1
    slot = int((np.uint64(key) * MULTIPLIER) >> np.uint64(32)) & last
    while keys[slot] != key and keys[slot] != EMPTY:
        slot = (slot + 1) & last
    return slot


@njit(cache=True)
def rehash(keys: np.ndarray, rows: np.ndarray, larger_keys: np.ndarray, larger_rows: np.ndarray) -> None:
    """Enter all keys and their rows into a larger, empty table."""
    for slot in range(len(keys)):
        if keys[slot] != EMPTY:
            to = slot_of(larger_keys, keys[slot])
            larger_keys[to] = keys[slot]
            larger_rows[to] = rows[slot]


@njit(cache=True)
def first_of_each_cube(points: np.ndarray, side_m: float, keys: np.ndarray, chosen: np.ndarray) -> int:
    """Choose the first point of each cube of a side. Return how many.

    points: (n, 3). keys: (2^n,) int64, all EMPTY, more than points. chosen: (n,) int64, gets their indices.
    """
    count = 0
    for index in range(len(points)):
        key = key_of(
            0,
            int(np.floor(points[index, 0] / side_m)),
            int(np.floor(points[index, 1] / side_m)),
            int(np.floor(points[index, 2] / side_m)),
        )
        slot = slot_of(keys, key)
        if keys[slot] == EMPTY:
            keys[slot] = key
            chosen[count] = index
            count += 1
    return count
