"""A binary heap in two arrays: keys, and the items that they belong to."""

from __future__ import annotations

import numpy as np

from kernel_cache.compiler import njit


@njit(cache=True, nogil=True)
def push(keys: np.ndarray, items: np.ndarray, size: int, key: float, item: int) -> None:
    """Add to a binary heap of `size` entries."""
    place = size
    while place > 0:
        parent = (place - 1) >> 1
        if keys[parent] <= key:
            break
        keys[place], items[place] = keys[parent], items[parent]
        place = parent
    keys[place], items[place] = key, item


@njit(cache=True, nogil=True)
def drop_first(keys: np.ndarray, items: np.ndarray, size: int) -> None:
    """Remove the least entry of a binary heap, which has `size` entries afterwards."""
    key, item = keys[size], items[size]
    place = 0
    while True:
        child = 2 * place + 1
        if child >= size:
            break
        if child + 1 < size and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[place], items[place] = keys[child], items[child]
        place = child
    keys[place], items[place] = key, item
