"""Compiled inner loops on plain arrays.

Conventions: ``ranges`` are float64 metres on a full turn of beams, +inf where nothing is seen; directions are
unit vectors in the grid's own frame (beam 0 along x). numba's cache notices changes of a kernel's own file
only, so no kernel calls one of another file.
"""

from __future__ import annotations

from uuid import uuid4

from numba.core.caching import IndexDataCacheFile


def _data_name(file: IndexDataCacheFile, number: int) -> str:
    """Return a name for a kernel's machine code that no other process gives.

    numba counts: "kernel.1.nbc". Two processes that compile a kernel for different types at the same time
    would both write that file, and the index of one would name the code of the other.
    """
    return file._data_name_pattern.format(number=uuid4().int)


IndexDataCacheFile._data_name = _data_name  # type: ignore[method-assign]
