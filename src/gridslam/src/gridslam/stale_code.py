"""Deletes numba's cached machine code of changed kernels. numba checks only a kernel's own file for changes.

If a kernel calls one of another file, it would keep the old code of that one. So all kernels of a folder
count as one: if any source differs, all are compiled anew.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
from pathlib import Path

DIGEST_FILE = "kernels.sha256"


def discard_stale_code(folder: Path) -> None:
    """Delete numba's files in ``folder/__pycache__`` unless they belong to the present sources in ``folder``.

    A read-only folder is left alone, because numba writes nothing there either.
    """
    cache = folder / "__pycache__"
    digest = _digest(folder)
    with contextlib.suppress(OSError):
        if _kept(cache / DIGEST_FILE) == digest:
            return
        for code in [*cache.glob("*.nbi"), *cache.glob("*.nbc")]:
            code.unlink(missing_ok=True)
        cache.mkdir(exist_ok=True)
        part = cache / f".{DIGEST_FILE}.{os.getpid()}"
        part.write_text(digest, encoding="ascii")
        part.replace(cache / DIGEST_FILE)  # several processes may start at the same time


def _digest(folder: Path) -> str:
    sources = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        sources.update(path.name.encode() + b"\0" + path.read_bytes())
    return sources.hexdigest()


def _kept(path: Path) -> str:
    return path.read_text(encoding="ascii") if path.exists() else ""
