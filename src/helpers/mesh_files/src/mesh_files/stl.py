"""STL as other programs read it: bytes behind the triangles do no harm, missing ones are told."""

from __future__ import annotations

import re
import struct

from mesh_files.contents import text_of
from mesh_files.errors import MeshFileError

HEADER_BYTES, COUNT_BYTES, TRIANGLE_BYTES = 80, 4, 50
TEXT_SAMPLE = 1024
"""Bytes by which an STL of the text form is known: it has none that are 0."""
END_OF_TEXT = 1000
"""The last characters of an STL of the text form, among which is its end."""
UNKNOWN = 0xFFFFFFFF
"""A number of triangles that a program writes which does not know it yet, as 0 is."""
_WORDS = re.compile(
    r"\s+(facet\s+normal|outer\s+loop|vertex|endloop|endfacet|endsolid)(?=\s|$)", re.IGNORECASE
)
_CORNER = re.compile(r"(?m)^\s*vertex\s", re.IGNORECASE)


def is_text_stl(content: bytes) -> bool:
    """Return whether an STL is of the text form."""
    begin = text_of(content[:TEXT_SAMPLE])
    return begin.lstrip()[:5].lower() == "solid" and "\0" not in begin


def stl_triangles(content: bytes) -> int:
    """Return the number of triangles of a binary STL.

    Raises:
        MeshFileError: it is cut.
    """
    size = len(content) - HEADER_BYTES - COUNT_BYTES
    if size < 0:
        raise MeshFileError("the STL is cut within its header. Export it again")
    told = struct.unpack_from("<I", content, HEADER_BYTES)[0]
    held = size // TRIANGLE_BYTES
    if told in (0, UNKNOWN) and held > 0 and size % TRIANGLE_BYTES == 0:
        return held  # a program that did not know the number when it began to write
    if told > held:
        raise MeshFileError(
            f"the STL is cut: {told:,} triangles are told in its header, and {held:,} are in it. "
            "Export it again"
        )
    return int(told)


def whole_stl(content: bytes) -> bytes:
    """Return a binary STL without what stands behind its triangles, with their right number."""
    count = stl_triangles(content)
    begin = HEADER_BYTES + COUNT_BYTES
    return content[:HEADER_BYTES] + struct.pack("<I", count) + content[begin : begin + TRIANGLE_BYTES * count]


def plain_stl(text: str) -> str:
    """Return the text of an STL with each corner on a line of its own.

    Raises:
        MeshFileError: it is cut.
    """
    if "endsolid" not in text[-END_OF_TEXT:].lower():
        raise MeshFileError("the STL is cut: it has no endsolid. Export it again")
    corners = len(re.findall(r"\bvertex\s", text, re.IGNORECASE))
    return text if len(_CORNER.findall(text)) == corners else _WORDS.sub(r"\n\1", text)
