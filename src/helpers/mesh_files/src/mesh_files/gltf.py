"""What of glTF 2.0 trimesh would read wrong or leave out without a word."""

from __future__ import annotations

import json
import struct
from typing import Any

from mesh_files.errors import MeshFileError

COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")
STRIPS_AND_TRIANGLES, FAN = (None, 4, 5), 6


def gltf_document(kind: str, content: bytes) -> dict[str, Any]:
    """Return the JSON of a glTF; empty: it cannot be read, which its reader tells."""
    try:
        if kind == "glb":
            (length,) = struct.unpack_from("<I", content, 12)
            content = content[20 : 20 + length]
        document = json.loads(content)
        return document if isinstance(document, dict) else {}
    except (struct.error, ValueError):
        return {}


def check_gltf(document: dict[str, Any]) -> None:
    """Raise MeshFileError if a glTF has surfaces that are not read as they are meant."""
    used = {*document.get("extensionsUsed", ()), *document.get("extensionsRequired", ())}
    compressed = next((each for each in COMPRESSED if each in used), None)
    if compressed:
        raise MeshFileError(f"is compressed ({compressed}). Export it without compression")
    accessors = document.get("accessors", [])
    for mesh in document.get("meshes", ()):
        for each in mesh.get("primitives", ()):
            if each.get("mode") == FAN:
                raise MeshFileError("has fans of triangles, which are not read. Export plain triangles")
            numbers = (each.get("attributes", {}).get("POSITION"), each.get("indices"))
            for number in numbers:
                _check_accessor(accessors[number] if isinstance(number, int) else {})


def _check_accessor(accessor: dict[str, Any]) -> None:
    if "sparse" in accessor:
        raise MeshFileError("has sparse accessors, which are not read. Export it without them")
    if accessor.get("normalized"):
        raise MeshFileError("has normalized places, which are not read. Export them as floats")
