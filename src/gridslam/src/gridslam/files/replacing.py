"""Replaces files at once: even after a kill, each is the old one or the complete new one."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from typing import Iterator, Mapping, Sequence

Content = bytes | str | Sequence[bytes | memoryview]
"""Of a file: parts stand one after the other."""


def replace_file(path: str | Path, content: Content) -> None:
    """Write one file as `replace_files` does."""
    replace_files({path: content})


def replace_files(contents: Mapping[str | Path, Content]) -> None:
    """Write files that belong together, and put them into their places when all are complete.

    Text is written as UTF-8. A link stays: the file that it leads to is replaced. What is no plain file, as
    /dev/stdout, is written in place.

    Raises:
        OSError: one cannot be written, and names it.
    """
    with contextlib.ExitStack() as leftovers:
        complete: list[tuple[Path, Path]] = []
        for path, content in contents.items():
            target = Path(os.path.realpath(path))
            with _named(path):
                if target.exists() and not target.is_file():
                    with open(target, "wb") as file:
                        file.writelines(_parts(content))
                    continue
                part = target.with_name(f".part-{os.getpid()}-{target.name}")
                leftovers.callback(part.unlink, missing_ok=True)
                _write_to_disk(part, _parts(content))
                complete.append((part, target))
        for part, target in complete:
            with _named(target):
                os.replace(part, target)


def _parts(content: Content) -> Sequence[bytes | memoryview]:
    if isinstance(content, str):
        return (content.encode("utf-8"),)
    return (content,) if isinstance(content, bytes) else content


def _write_to_disk(path: Path, parts: Sequence[bytes | memoryview]) -> None:
    with open(path, "wb") as file:
        file.writelines(parts)
        file.flush()
        os.fsync(file.fileno())


@contextlib.contextmanager
def _named(path: str | Path) -> Iterator[None]:
    """Let errors name the file that was asked for."""
    try:
        yield
    except OSError as error:
        error.filename, error.filename2 = str(path), None
        raise
