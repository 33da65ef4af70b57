"""numba's compiler. It keeps machine code where only kernels of the same sources find it."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import Any, Callable, TypeVar
from uuid import uuid4

import numba
from numba.core.caching import IndexDataCacheFile

from kernel_cache.folders import folder_for

Kernel = TypeVar("Kernel", bound=Callable[..., Any])


def njit(**options: Any) -> Callable[[Kernel], Kernel]:
    """Return a decorator as `numba.njit` with these options."""

    def compiled(function: Kernel) -> Kernel:
        if not options.get("cache"):
            return numba.njit(**options)(function)
        folder = folder_for(Path(inspect.getfile(function)).resolve())
        if folder is None:
            return numba.njit(**{**options, "cache": False})(function)
        config: Any = numba.config
        given, config.CACHE_DIR = config.CACHE_DIR, str(folder)
        try:
            return numba.njit(**options)(function)
        finally:
            config.CACHE_DIR = given

    return compiled


def _data_name(file: IndexDataCacheFile, number: int) -> str:
    """Return a name for a kernel's machine code that no other process gives.

    numba counts: "kernel.1.nbc". Two processes that compile a kernel for different types at the same time
    would both write that file, and the index of one would name the code of the other.
    """
    return file._data_name_pattern.format(number=uuid4().int)


IndexDataCacheFile._data_name = _data_name  # type: ignore[method-assign]
