"""Gives the memory of numba's compiler back to the system when all kernels are ready."""

from __future__ import annotations

import ctypes
import mmap
from pathlib import Path

COMPILER = "libllvmlite"
"""The library in which numba has LLVM."""
FIELD = "Anonymous:"
"""Of a part of a process's memory: what of it is not as in its file."""


def release_compiler(maps: Path = Path("/proc/self/smaps")) -> int:
    """Take the compiler's program out of the process's memory. Return how many bytes it may have taken.

    numba compiles its own runtime at each start, also where all kernels come from the cache. Then 60 to 70 MB
    of LLVM's program stay in the process, which needs them no more. They are parts of a file, so they come
    back by themselves when they are called. Parts that the linker has written to stay.

    maps: the process's memory, as Linux describes it. Elsewhere nothing happens.
    """
    try:
        parts = _unchanged_parts(maps.read_text())
    except OSError:
        return 0
    advise = ctypes.CDLL(None).madvise
    advise.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    for begin, end in parts:
        advise(begin, end - begin, mmap.MADV_DONTNEED)
    return sum(end - begin for begin, end in parts)


def _unchanged_parts(text: str) -> list[tuple[int, int]]:
    """Return the addresses (begin, end) of the compiler's parts that nobody can write to, or has."""
    parts: list[tuple[int, int]] = []
    begin = end = 0
    for line in text.splitlines():
        words = line.split()
        if not words[0].endswith(":"):  # begins the next part: 7f00-7f80 r-xp 00000000 fe:00 57 /a/file
            is_readonly = words[1].startswith("r") and "w" not in words[1]
            is_ours = is_readonly and COMPILER in " ".join(words[5:])
            begin, end = (int(word, 16) for word in words[0].split("-")) if is_ours else (0, 0)
        elif words[0] == FIELD and end and words[1] == "0":
            parts.append((begin, end))
    return parts
