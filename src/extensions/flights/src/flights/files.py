"""Writes files completely or not at all, and converts values for JSON."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
import tempfile
from pathlib import Path
from typing import Any


def replace_file(path: Path, content: bytes | str) -> None:
    """Write a file at once.

    Even after a crash there is either the old file or the complete new one.

    Raises:
        OSError: it cannot be written; nothing has changed.
    """
    path = Path(path)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(content.encode("utf-8") if isinstance(content, str) else content)
            stream.flush()
            os.fsync(stream.fileno())
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:  # also after Ctrl-C
        with contextlib.suppress(FileNotFoundError):
            os.unlink(temporary)
        raise


def plain(value: Any) -> Any:
    """Turn dataclasses, tuples, numpy's values, paths and UTF-8 bytes into JSON's types.

    NaN and infinities become None.
    """
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(item) for item in value]
    if isinstance(value, Path):
        return str(value)
    if isinstance(value, bytes):
        return value.decode("utf-8")
    if hasattr(value, "tolist"):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
