"""3MF, as its core specification 1.3 says: objects of triangles or of other objects, placed by transforms.

The production extension puts objects into models of their own, which a path names.
"""

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
            package = _Package(archive)
            unit = package.model(package.root).get("unit", "millimeter").lower()
            if unit not in UNITS_M:
                raise MeshFileError(f'its unit is "{unit}", which is unknown. Export it in metres')
            return [
                (name, UNITS_M[unit] * vertices, triangles)
                for item in _children(package.model(package.root), "build", "item")
                for name, vertices, triangles in _placed(package, package.root, item, DEEPEST)
            ]
    except (zipfile.BadZipFile, ElementTree.ParseError, ValueError, KeyError, TypeError, EOFError) as error:
        raise MeshFileError(f"is no whole 3MF ({error}). Export it again") from None


class _Package:
    """The models of a 3MF. root: path of the one that is to be built; others hold objects for it."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive, self._models = archive, dict[str, ElementTree.Element]()
        names = [each for each in archive.namelist() if each.lower().endswith(".model")]
        if not names:
            raise MeshFileError("the 3MF holds no model")
        self.root = self._told_root() or min(names, key=len)

    def _told_root(self) -> str | None:
        """Return the path that the package calls its start; None: it tells none."""
        try:
            told = ElementTree.fromstring(self._archive.read("_rels/.rels"))
        except KeyError:
            return None
        targets = [each.get("Target", "") for each in told if each.get("Type", "").endswith("/3dmodel")]
        return targets[0].lstrip("/") if targets else None

    def model(self, path: str) -> ElementTree.Element:
        """Return a model."""
        if path not in self._models:
            self._models[path] = ElementTree.fromstring(self._archive.read(path))
        return self._models[path]

    def object(self, path: str, number: str) -> ElementTree.Element:
        """Return an object of a model."""
        return next(e for e in _children(self.model(path), "resources", "object") if e.get("id") == number)


def _placed(package: _Package, path: str, item: ElementTree.Element, left: int) -> list[Placed]:
    """Return what an item or a component places. path: of the model that it stands in."""
    if not left:
        raise MeshFileError("its objects hold each other without end")
    number = item.attrib["objectid"]
    path = next((v.lstrip("/") for key, v in item.attrib.items() if key.endswith("}path")), path)
    try:
        thing, turn = package.object(path, number), _transform(item.get("transform"))
    except StopIteration:
        raise MeshFileError(
            f"is no whole 3MF (there is no object {number} in {path}). Export it again"
        ) from None
    found = [
        (name, np.column_stack((vertices, np.ones(len(vertices)))) @ turn, triangles)
        for part in _children(thing, "components", "component")
        for name, vertices, triangles in _placed(package, path, part, left - 1)
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
