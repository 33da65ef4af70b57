"""What of glTF 2.0 trimesh would read wrong or leave out without a word."""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from typing import Any

from input_schemas import structured
from mesh_files.contents import GLTF
from mesh_files.errors import MeshFileError

COMPRESSED = ("KHR_draco_mesh_compression", "EXT_meshopt_compression")
FAN = 6


@dataclass(frozen=True)
class Asset:
    """Tells the version of glTF, and which program wrote it."""

    version: str
    generator: str = ""


@dataclass(frozen=True)
class Accessor:
    """Tells how numbers are stored."""

    sparse: Any = None
    normalized: bool = False


@dataclass(frozen=True)
class Primitive:
    """Corners and triangles, by the numbers of their accessors."""

    attributes: dict[str, int]
    indices: int | None = None
    mode: int = 4


@dataclass(frozen=True)
class GltfMesh:
    """A thing."""

    primitives: tuple[Primitive, ...]


@dataclass(frozen=True)
class Document:
    """What of a glTF's JSON is read here: https://registry.khronos.org/glTF/specs/2.0."""

    asset: Asset
    accessors: tuple[Accessor, ...] = ()
    meshes: tuple[GltfMesh, ...] = ()
    extensionsUsed: tuple[str, ...] = ()  # noqa: N815
    extensionsRequired: tuple[str, ...] = ()  # noqa: N815


def gltf_document(kind: str, content: bytes) -> Document:
    """Return the JSON of a glTF; raises MeshFileError if it is none, or of another version."""
    try:
        if kind == "glb":
            (length,) = struct.unpack_from("<I", content, 12)
            content = content[20 : 20 + length]
        told = json.loads(content)
    except (struct.error, ValueError, RecursionError):
        raise MeshFileError("is no glTF, or it is cut. Export it again") from None
    document = structured(told, Document, MeshFileError, other_keys=True)
    if document.asset.version.partition(".")[0] != str(GLTF):
        raise MeshFileError(
            f'is glTF "{document.asset.version}", but {GLTF}.0 is read here. Export it as glTF {GLTF}.0'
        )
    return document


def check_gltf(document: Document) -> None:
    """Raise MeshFileError if a glTF has surfaces that are not read as they are meant."""
    used = {*document.extensionsUsed, *document.extensionsRequired}
    compressed = next((each for each in COMPRESSED if each in used), None)
    if compressed:
        raise MeshFileError(f"is compressed ({compressed}). Export it without compression")
    for mesh in document.meshes:
        for each in mesh.primitives:
            if each.mode == FAN:
                raise MeshFileError("has fans of triangles, which are not read. Export plain triangles")
            for number in (each.attributes.get("POSITION"), each.indices):
                if number is not None:
                    _check_accessor(document.accessors, number)


def _check_accessor(accessors: tuple[Accessor, ...], number: int) -> None:
    if not 0 <= number < len(accessors):
        raise MeshFileError(f"has no accessor {number}, which a mesh names. Export it again")
    if accessors[number].sparse is not None:
        raise MeshFileError("has sparse accessors, which are not read. Export it without them")
    if accessors[number].normalized:
        raise MeshFileError("has normalized places, which are not read. Export them as floats")
