"""numba's compiler. It keeps machine code where only kernels of the same sources find it."""

from __future__ import annotations

import inspect
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Callable, TypeVar
from uuid import uuid4

import numba
from numba.core.caching import IndexDataCacheFile
from numba.core.codegen import CPUCodeLibrary, ll
from numba.np import linalg

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

_load = vars(CPUCodeLibrary)["_unserialize"].__func__
_for_linking = CPUCodeLibrary._get_module_for_linking


def _load_machine_code(kind: type[CPUCodeLibrary], codegen: Any, state: tuple) -> CPUCodeLibrary:
    """Load a kernel, and keep only its machine code ready.

    numba also keeps the kernel as LLVM's objects, to compile it into others. That is 0.4 MB for each kernel,
    and machine code that is kept needs none of it.
    """
    library = _load(kind, codegen, state)
    if library._shared_module is not None:
        library._shared_module, library._bitcode = None, state[2][1]
    return library


def _module_for_linking(library: CPUCodeLibrary) -> Any:
    """Return LLVM's objects of a kernel, which another one is compiled with."""
    bitcode = getattr(library, "_bitcode", None)
    if library._shared_module is None and bitcode is not None:
        library._shared_module = ll.parse_bitcode(bitcode)
    return _for_linking(library)


CPUCodeLibrary._unserialize = classmethod(_load_machine_code)  # type: ignore[method-assign, assignment]
CPUCodeLibrary._get_module_for_linking = _module_for_linking  # type: ignore[method-assign]

_ensure_blas = linalg.ensure_blas


def _find_blas() -> None:
    """Answer numba's first question for BLAS, which it asks while it loads the first kernel.

    numba would import scipy.linalg for the answer. That takes 0.06 s of each node's start, and only a kernel
    with a product of matrices needs it. All later questions go to numba's own function.
    """
    linalg.ensure_blas = _ensure_blas
    if find_spec("scipy") is None:
        raise ImportError("there is no scipy")


linalg.ensure_blas = _find_blas
