"""Complete states in files: an .npz of plain arrays, no pickles."""

from __future__ import annotations

import io
import os
import zipfile
import zlib
from pathlib import Path
from typing import Any, Callable, Sequence, TypeVar

import numpy as np

from gridslam.errors import SlamError, StateError, reason_of
from gridslam.files.replacing import replace_file
from gridslam.files.serialiser import TREE, pack, unpack

FORMAT = 20
"""It counts up whenever a class that is saved gets other fields, or one of them another meaning."""
VERSION = "format"
OF_OLDER_FORMATS = ("filter", "header.npy")
"""Parts of files up to format 9, which have no number where it is now."""
DAMAGE = (
    ArithmeticError,
    AttributeError,
    EOFError,
    LookupError,
    MemoryError,
    NotImplementedError,
    OSError,
    SlamError,
    TypeError,
    ValueError,
    zipfile.BadZipFile,
    zlib.error,
)
"""The exceptions for a damaged or foreign file."""
Built = TypeVar("Built")


def write(state: Any, path: str | Path, is_packed: bool = False) -> None:
    """Write a state: a `FilterState`, a `SessionState`, or a `VolumeState`.

    A kill leaves the old file or the new one. is_packed: most of the state is compressed already.

    Raises:
        StateError: the file cannot be written.
    """
    content = io.BytesIO()
    save = np.savez if is_packed else np.savez_compressed
    save(content, **{VERSION: np.array(FORMAT)}, **pack(state))
    try:
        replace_file(path, content.getvalue())
    except OSError as error:
        raise StateError(f"The state cannot be written to {path}: {error.strerror}.") from None


def read(path: str | Path, build: Callable[[Any], Built], classes: Sequence[type] | None = None) -> Built:
    """Return what ``build`` makes of the state in a file. Whatever is damaged in it becomes a StateError.

    classes: that it may hold; None: those of a filter and a session.

    Raises:
        StateError: the file cannot be read, or holds no state.
    """
    try:
        return build(unpack(_arrays(path), _classes() if classes is None else classes))
    except _OtherVersionError as error:
        raise StateError(
            f"{path} is of another version ({error}) of gridslam, which reads {FORMAT}: begin anew, or give "
            "the map of that run as starting_map."
        ) from None
    except DAMAGE as error:
        raise StateError(f"{path} cannot be read as a saved state: {reason_of(error)}.") from None


class _OtherVersionError(SlamError):
    """The message is the version of a file."""


def _arrays(path: str | Path) -> dict[str, np.ndarray]:
    with zipfile.ZipFile(path) as packed:
        _require_memory(packed)
        names = packed.namelist()
    if f"{TREE}.npy" not in names and any(name in names for name in OF_OLDER_FORMATS):
        raise _OtherVersionError("9 or older")
    with np.load(path, allow_pickle=False) as file:
        if int(file[VERSION]) != FORMAT:
            raise _OtherVersionError(int(file[VERSION]))
        return {name: file[name] for name in file.files}


def _require_memory(packed: zipfile.ZipFile) -> None:
    """Refuse a file whose unpacked parts do not fit into this machine's memory.

    Raises:
        ValueError: they do not.
    """
    size, memory = sum(part.file_size for part in packed.infolist()), memory_bytes()
    if size > memory:
        raise ValueError(f"it claims {size / 1e9:.1f} GB, more than this machine's {memory / 1e9:.1f} GB")


def memory_bytes() -> int:
    """Return how much memory this machine has."""
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")


def _classes() -> tuple[type, ...]:
    """Return every class that is saved."""
    from gridslam.files.saved_classes import SAVED_CLASSES  # only here, because it slows the start

    return SAVED_CLASSES
