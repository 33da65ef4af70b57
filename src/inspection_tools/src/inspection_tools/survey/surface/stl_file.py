"""Binary STL as other programs read it: bytes behind the triangles do no harm, missing ones are told."""

from __future__ import annotations

import struct
from pathlib import Path

from inspection_tools.errors import SurveyError

HEADER_BYTES, COUNT_BYTES, TRIANGLE_BYTES = 80, 4, 50
TEXT_SAMPLE = 1024
"""Bytes by which an STL of the text form is known: it has none that are 0."""


def is_text_stl(path: Path) -> bool:
    """Return whether an STL is of the text form."""
    with path.open("rb") as stream:
        begin = stream.read(TEXT_SAMPLE)
    return begin.lstrip()[:5].lower() == b"solid" and b"\0" not in begin


def stl_triangles(path: Path) -> int:
    """Return the number of triangles of a binary STL.

    Raises:
        SurveyError: it is cut.
    """
    size = path.stat().st_size - HEADER_BYTES - COUNT_BYTES
    with path.open("rb") as stream:
        stream.seek(HEADER_BYTES)
        count = stream.read(COUNT_BYTES)
    if len(count) < COUNT_BYTES:
        raise SurveyError(f"{path}: the STL is cut within its header. Export it again.")
    told, held = struct.unpack("<I", count)[0], size // TRIANGLE_BYTES
    if told == 0 and held > 0 and size % TRIANGLE_BYTES == 0:
        return int(held)  # a program that did not know the number when it began to write
    if told > held:
        raise SurveyError(
            f"{path}: the STL is cut: {told:,} triangles are told in its header, and {held:,} are in it. "
            "Export it again."
        )
    return int(told)


def whole_stl(path: Path) -> bytes:
    """Return a binary STL without what stands behind its triangles, with their right number."""
    count = stl_triangles(path)
    with path.open("rb") as stream:
        content = stream.read(HEADER_BYTES + COUNT_BYTES + TRIANGLE_BYTES * count)
    return content[:HEADER_BYTES] + struct.pack("<I", count) + content[HEADER_BYTES + COUNT_BYTES :]
