"""The folders that hold the kernels' machine code. A folder's name ends in the digest of its sources."""

from __future__ import annotations

import contextlib
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path

from kernel_cache.sources import digest_of

USERS_OWN = "kernel_cache"
"""In the user's folder for caches."""


@cache
def folder_for(file: Path) -> Path | None:
    """Return an existing folder for the code of a file's kernels; None: no folder can be written.

    If it is new and the folder beside the source has code, it begins with a copy of that.
    """
    beside = _beside(file)
    for folder in _choices(file):
        if folder == beside and not folder.exists():
            _discard_older(folder)
        elif folder != beside and not folder.exists():
            _copy(beside, folder)
        if _is_writable(folder):
            return folder
    return None


def has_code(file: Path) -> bool:
    """Whether a process would find code for a kernel of this file."""
    return any(any(folder.rglob("*.nbi")) for folder in (_beside(file), *_choices(file)))


def _beside(file: Path) -> Path:
    """Return the folder beside the source."""
    return file.parent / "__pycache__" / "kernels" / f"{file.stem}-{digest_of(file)}"


def _choices(file: Path) -> list[Path]:
    """Return the folders that may be used, the best first."""
    beside, given = _beside(file), os.environ.get("NUMBA_CACHE_DIR")
    if given:
        return [Path(given).absolute() / beside.name]
    users = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    return [beside, Path(users) / USERS_OWN / beside.name]


def _is_writable(folder: Path) -> bool:
    """Whether files can be written there, as numba will."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError:
        return False
    return True


def _discard_older(folder: Path) -> None:
    """Delete the code of older sources of the same file."""
    stem = folder.name[: folder.name.rindex("-")]
    for other in folder.parent.glob(f"{stem}-*"):
        if other.name[: other.name.rindex("-")] == stem:
            shutil.rmtree(other, ignore_errors=True)


def _copy(source: Path, folder: Path) -> None:
    """Copy a folder as a whole, if there is one; another process may do so at the same time."""
    if not source.is_dir():
        return
    with contextlib.suppress(OSError, shutil.Error):
        folder.parent.mkdir(parents=True, exist_ok=True)
        part = Path(tempfile.mkdtemp(prefix=".copying-", dir=folder.parent))
        try:
            shutil.copytree(source, part / folder.name)
            (part / folder.name).replace(folder)
        finally:
            shutil.rmtree(part, ignore_errors=True)
