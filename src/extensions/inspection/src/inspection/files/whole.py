"""Writes files so that whoever reads them finds the old or the new ones, also after a loss of power."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Mapping


def write_whole(files: Mapping[Path, bytes]) -> None:
    """Write files aside, make sure that they are on the disk, and then give them their names, in this order.

    Raises:
        OSError: one cannot be written; all stay as they were.
    """
    partials = {path: partial_of(path) for path in files}
    try:
        for path, content in files.items():
            with partials[path].open("wb") as stream:
                stream.write(content)
                settle(stream.fileno())
        for path, partial in partials.items():
            os.replace(partial, path)
    finally:
        for partial in partials.values():
            with contextlib.suppress(OSError):
                partial.unlink(missing_ok=True)
    for folder in {path.parent for path in files}:
        settle_folder(folder)


def partial_of(path: Path) -> Path:
    """Return the name under which a file is written before it is whole."""
    return path.with_name(path.name + ".part")


def settle(descriptor: int) -> None:
    """Wait until what was written to an open file is on the disk; raises OSError if it cannot get there."""
    os.fsync(descriptor)


def settle_folder(folder: Path) -> None:
    """Wait until the names in a folder are on the disk, where its file system can say so."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
