"""numba's compiler, with a cache that several processes may fill at the same time."""

from __future__ import annotations

from uuid import uuid4

from numba import njit
from numba.core.caching import IndexDataCacheFile

__all__ = ["njit"]


def _data_name(file: IndexDataCacheFile, number: int) -> str:
    """Return a name for a kernel's machine code that no other process gives.

    numba counts: "kernel.1.nbc". Two processes that compile a kernel for different types at the same time
    would both write that file, and the index of one would name the code of the other.
    """
    return file._data_name_pattern.format(number=uuid4().int)


IndexDataCacheFile._data_name = _data_name  # type: ignore[method-assign]
