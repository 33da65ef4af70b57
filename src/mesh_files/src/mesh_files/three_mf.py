"""3MF, as its core specification 1.3 says: objects of triangles or of other objects, placed by transforms."""

from __future__ import annotations

import io
import zipfile
from typing import Iterator
from xml.etree import ElementTree

import numpy as np

from mesh_files.errors import MeshFileError

UNITS_M = {
    "micron": 1e-6, "millimeter": 1e-3, "centimeter": 1e-2, "inch": 0.0254, "foot": 0.3048, "meter": 1.0
}  # fmt: skip
DEEPEST = 20
"""Objects within objects; a file whose objects hold each other has no end."""
Placed = tuple[str, np.ndarray, np.ndarray]
"""Name, vertices (n, 3) in metres, and triangles (m, 3)."""


def read_3mf(content: bytes) -> list[Placed]:
    """Return the things of a 3MF; raises MeshFileError if it is damaged."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            names = [each for each in archive.namelist() if each.lower().endswith(".model")]
            if not names:
                raise MeshFileError("the 3MF holds no model")
            model = ElementTree.fromstring(archive.read(min(names, key=len)))
        unit = model.get("unit", "millimeter")
        if unit not in UNITS_M:
            raise MeshFileError(f'its unit is "{unit}", which is unknown. Export it in metres')
        objects = {each.get("id", ""): each for each in _children(model, "resources", "object")}
        return [
            (name, UNITS_M[unit] * vertices, triangles)
            for item in _children(model, "build", "item")
            for name, vertices, triangles in _placed(objects, item, DEEPEST)
        ]
    except (zipfile.BadZipFile, ElementTree.ParseError, ValueError, KeyError, TypeError, EOFError) as error:
        raise MeshFileError(f"is no whole 3MF ({error}). Export it again") from None


def _placed(objects: dict[str, ElementTree.Element], item: ElementTree.Element, left: int) -> list[Placed]:
    """Return what an item or a component places."""
    if not left:
        raise MeshFileError("its objects hold each other without end")
    number = item.attrib["objectid"]
    thing, turn = objects[number], _transform(item.get("transform"))
    found = [
        (name, np.column_stack((vertices, np.ones(len(vertices)))) @ turn, triangles)
        for part in _children(thing, "components", "component")
        for name, vertices, triangles in _placed(objects, part, left - 1)
    ]
    vertices = np.array(
        [[float(v.attrib[a]) for a in "xyz"] for v in _children(thing, "mesh", "vertices", "vertex")]
    )
    if len(vertices):
        corners = [
            [int(t.attrib[a]) for a in ("v1", "v2", "v3")]
            for t in _children(thing, "mesh", "triangles", "triangle")
        ]
        placed = np.column_stack((vertices, np.ones(len(vertices)))) @ turn
        found.append((thing.get("name") or number, placed, np.array(corners, int).reshape(-1, 3)))
    return found


def _transform(told: str | None) -> np.ndarray:
    """Return (4, 3): a row (x, y, z, 1) times it is the place."""
    if not told:
        return np.eye(4)[:, :3]
    return np.array([float(value) for value in told.split()]).reshape(4, 3)


def _children(element: ElementTree.Element, *names: str) -> Iterator[ElementTree.Element]:
    """Yield the elements along a path of names, whatever their namespace."""
    for child in element:
        if child.tag.rpartition("}")[2] == names[0]:
            if len(names) == 1:
                yield child
            else:
                yield from _children(child, *names[1:])
