"""Compiled inner loops on plain arrays.

Conventions: ``ranges`` are float64 metres on a full turn of beams, +inf where nothing is seen; directions are
unit vectors in the grid's own frame (beam 0 along x). numba's cache notices changes of a kernel's own file
only, so no kernel calls one of another file.
"""

from __future__ import annotations

from typing import Any, Callable
from uuid import uuid4

from numba.core.caching import IndexDataCacheFile


def _data_name(file: IndexDataCacheFile, number: int) -> str:
    """Return a name for a kernel's machine code that no other process gives.

    numba counts: "kernel.1.nbc". Two processes that compile a kernel for different types at the same time
    would both write that file, and the index of one would name the code of the other.
    """
    return file._data_name_pattern.format(number=uuid4().int)


def _without_what_is_gone(
    load: Callable[[IndexDataCacheFile], dict[Any, str]],
) -> Callable[[IndexDataCacheFile], dict[Any, str]]:
    """Return ``load`` of an index, which finds nothing if the index names a tuple that older sources had.

    numba reads the index before it looks whether the sources have changed.
    """

    def load_index(file: IndexDataCacheFile) -> dict[Any, str]:
        try:
            return load(file)
        except (AttributeError, ImportError):
            return {}

    return load_index


IndexDataCacheFile._data_name = _data_name  # type: ignore[method-assign]
IndexDataCacheFile._load_index = _without_what_is_gone(  # type: ignore[method-assign]
    IndexDataCacheFile._load_index
)
