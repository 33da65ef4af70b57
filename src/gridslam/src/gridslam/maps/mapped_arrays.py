"""Large arrays with memory of their own, which goes back to the system when they are dropped."""

from __future__ import annotations

import mmap

import numpy as np
from numpy.typing import DTypeLike


def mapped_zeros(shape: tuple[int, ...], dtype: DTypeLike) -> np.ndarray:
    """Return an array that takes memory only where it is written, and gives it back when it is dropped.

    The C library does so for its first large arrays only. After one is freed, it keeps their
    memory, and clears it for the next ones. A forked process gets a copy (MAP_PRIVATE), as of any array.
    """
    memory = mmap.mmap(-1, size_bytes(shape, dtype), mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
    return np.ndarray(shape, dtype, memory)


def size_bytes(shape: tuple[int, ...], dtype: DTypeLike) -> int:
    """Return the size of an array."""
    return int(np.prod(shape)) * np.dtype(dtype).itemsize
