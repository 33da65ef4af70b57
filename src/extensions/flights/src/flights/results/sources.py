"""The version of the code: the git commit, or a digest of the sources if that is not enough."""

from __future__ import annotations

import hashlib
import subprocess
from pathlib import Path
from typing import Iterator

DIGITS = 12
MARK = ".catkin_workspace"
_SOURCES = ("src", "benchmarks")
_NOT_CODE = frozenset(("__pycache__", "doc", "test", "build", "devel", "results", "logs"))


def commit(folder: Path) -> str:
    """Return the version of the sources in a folder.

    Different code has a different version. It is the git commit. Edited sources add "+changes." and their
    digest. Without git it is "no-git." and the digest. Pages and tests are not part of the digest.
    """
    folder = Path(folder).resolve()
    try:
        revision = _git(folder, "rev-parse", "HEAD")
        changes = _git(folder, "status", "--porcelain", "--untracked-files=no")
        root = Path(_git(folder, "rev-parse", "--show-toplevel"))
    except (OSError, subprocess.SubprocessError):
        return f"no-git.{digest(workspace_of(folder))}"
    return f"{revision}+changes.{digest(root)}" if changes else revision


def workspace_of(folder: Path) -> Path:
    """Return the catkin workspace of a folder, else the folder itself."""
    return next((above for above in (folder, *folder.parents) if (above / MARK).is_file()), folder)


def digest(root: Path) -> str:
    """Return a digest of all code below a workspace (or a plain folder): names and contents."""
    found = hashlib.sha256()
    folders = [root / name for name in _SOURCES if (root / name).is_dir()] or [root]
    for path in sorted(path for folder in folders for path in _code(folder)):
        found.update(f"{path.relative_to(root)}\0".encode())
        try:
            found.update(hashlib.sha256(path.read_bytes()).digest())
        except OSError:
            found.update(b"unreadable")
    return found.hexdigest()[:DIGITS]


def _code(folder: Path) -> Iterator[Path]:
    for path in folder.iterdir():
        if path.name in _NOT_CODE or path.name.startswith("."):
            continue
        if path.is_dir() and not path.is_symlink():
            yield from _code(path)
        elif path.is_file() and path.suffix != ".pyc":
            yield path


def _git(folder: Path, *arguments: str) -> str:
    command = ["git", "-C", str(folder), *arguments]
    return subprocess.run(command, check=True, capture_output=True, text=True, timeout=10).stdout.strip()
