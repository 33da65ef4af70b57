"""What a mesh file holds: its text, or what stands there in place of the mesh that its name promises."""

from __future__ import annotations

import codecs
import struct

from mesh_files.errors import MeshFileError

MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))
"""Byte order marks."""
SAMPLE = 1024
"""Bytes by which a file that is no mesh is known."""
_LFS = "version https://git-lfs.github.com/spec/"
_PAGE = ("<!doctype html", "<html")
_GLB = struct.Struct("<4sII")
GLTF = 2
"""The version of glTF that is read."""


def text_of(content: bytes) -> str:
    """Return the text, without a byte order mark and with ends of lines as here.

    Numbers are the same in any code page, so letters that are no UTF-8 do no harm.
    """
    encoding = next((name for mark, name in MARKS if content.startswith(mark)), "utf-8")
    text = content.decode(encoding, errors="replace").removeprefix("\ufeff")
    return text.replace("\r\n", "\n").replace("\r", "\n")


def check_content(kind: str, content: bytes) -> None:
    """Raise MeshFileError if a file holds something that is no mesh, or a GLB that is cut."""
    begin = text_of(content[:SAMPLE]).lstrip().lower()
    if begin.startswith(_LFS):
        raise MeshFileError("is a pointer of Git LFS, not the mesh itself. Fetch the mesh with: git lfs pull")
    if begin.startswith(_PAGE):
        raise MeshFileError("is a web page, not a mesh. Download the file itself")
    if kind == "glb":
        _check_glb(content)


def _check_glb(content: bytes) -> None:
    if len(content) < _GLB.size or not content.startswith(b"glTF"):
        raise MeshFileError("is no GLB, or it is cut within its header. Export it again")
    _, version, length = _GLB.unpack_from(content)
    if version != GLTF:
        raise MeshFileError(f"is a GLB of version {version}, but {GLTF} is read here. Export it as glTF 2.0")
    if length > len(content):
        raise MeshFileError(
            f"the GLB is cut: {length:,} bytes are told in its header, and {len(content):,} are in it. "
            "Export it again"
        )
