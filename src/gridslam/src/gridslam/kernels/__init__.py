"""Compiled inner loops on plain arrays.

Kernels call kernels of other files here. When any of these files changes, all kernels are compiled anew: see
`stale_code`.
"""

from __future__ import annotations

from pathlib import Path
from uuid import uuid4

from numba.core.caching import IndexDataCacheFile

from gridslam.stale_code import discard_stale_code


def _data_name(file: IndexDataCacheFile, number: int) -> str:
    """Return a name for a kernel's machine code that no other process gives.

    numba counts: "kernel.1.nbc". Two processes that compile a kernel for different types at the same time
    would both write that file, and the index of one would name the code of the other.
    """
    return file._data_name_pattern.format(number=uuid4().int)


IndexDataCacheFile._data_name = _data_name  # type: ignore[method-assign]
discard_stale_code(Path(__file__).parent)
