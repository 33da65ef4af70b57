"""PLY of the text and the binary form: http://paulbourke.net/dataformats/ply."""

from __future__ import annotations

from typing import Iterator, NamedTuple, Sequence

import numpy as np

from mesh_files.errors import MeshFileError
from mesh_files.polygons import triangulated

TYPES = {
    "char": "i1", "int8": "i1", "uchar": "u1", "uint8": "u1", "short": "i2", "int16": "i2", "ushort": "u2",
    "uint16": "u2", "int": "i4", "int32": "i4", "uint": "u4", "uint32": "u4", "float": "f4",
    "float32": "f4", "double": "f8", "float64": "f8",
}  # fmt: skip
ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">", "ascii": ""}
CORNERS = ("vertex_indices", "vertex_index")
MOST_HEADER = 64 * 1024
_CUT = "the PLY is cut or damaged. Export it again"


class Property(NamedTuple):
    """A value of an element. length: type of the number of values of a list; empty: it is one value."""

    name: str
    kind: str
    length: str = ""


class Element(NamedTuple):
    """So many things of a kind stand one behind the other."""

    name: str
    number: int
    properties: list[Property]


def read_ply(content: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and triangles (m, 3) of faces and strips; raises MeshFileError.

    What stands behind the last element does no harm.
    """
    try:
        order, elements, body = _header(content)
        reader = _Binary(body, order) if order else _Text(body)
        held = {each.name: reader.element(each) for each in elements}
        vertex = held["vertex"]
        vertices = np.column_stack([np.asarray(vertex[axis], float) for axis in "xyz"])
        polygons = _lists(held.get("face", {}))
        strips = [each for strip in _lists(held.get("tristrips", {})) for each in _of_strip(strip)]
        if strips:
            polygons = [*polygons, *strips]
        corners = polygons if isinstance(polygons, np.ndarray) else np.concatenate([*polygons, []])
        if corners.size and not 0 <= corners.min() <= corners.max() < len(vertices):
            raise MeshFileError("a face has a corner that does not exist. Export it again")
    except (ValueError, IndexError, KeyError):
        raise MeshFileError(_CUT) from None
    return vertices, triangulated(vertices, polygons)


def _lists(held: dict) -> Sequence | np.ndarray:
    return next((held[name] for name in CORNERS if name in held), [])


def _of_strip(strip: np.ndarray) -> Iterator[list[int]]:
    """Yield the triangles of a strip; -1 ends one, and every second triangle is the other way round."""
    odd, before = False, list[int]()
    for corner in map(int, strip):
        if corner < 0:
            odd, before = False, []
            continue
        if len(before) == 2:
            yield [before[1], before[0], corner] if odd else [*before, corner]
            odd = not odd
        before = [*before, corner][-2:]


def _header(content: bytes) -> tuple[str, list[Element], bytes]:
    """Return the byte order, empty for text, the elements, and what stands behind the header."""
    end = content.find(b"end_header", 0, MOST_HEADER)
    if end < 0:
        raise ValueError
    order, elements = "", list[Element]()
    for line in content[:end].decode("latin-1").splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "format":
            order = ORDERS[words[1]]
        elif words[0] == "element":
            elements.append(Element(words[1], int(words[2]), []))
        elif words[0] == "property" and words[1] == "list":
            elements[-1].properties.append(Property(words[4], TYPES[words[3]], TYPES[words[2]]))
        elif words[0] == "property":
            elements[-1].properties.append(Property(words[2], TYPES[words[1]]))
    end += len(b"end_header")
    end += 2 if content[end : end + 2] == b"\r\n" else 1
    return order, elements, content[end:]


class _Text:
    """Takes elements of the text form, value after value."""

    def __init__(self, body: bytes) -> None:
        self._words, self._at = body.split(), 0

    def _take(self, count: int) -> np.ndarray:
        words = self._words[self._at : self._at + count]
        if len(words) < count:
            raise ValueError
        self._at += count
        return np.array(words).astype(float)

    def element(self, element: Element) -> dict:
        """Return the values of each property: an array, or a list of arrays."""
        names = [each.name for each in element.properties]
        if not any(each.length for each in element.properties):
            values = self._take(element.number * len(names)).reshape(element.number, len(names))
            return dict(zip(names, values.T))
        alike = self._alike(element.number) if len(names) == 1 else None
        if alike is not None:
            return {names[0]: alike}
        held: dict[str, list] = {name: [] for name in names}
        for _ in range(element.number):
            for each in element.properties:
                size = int(self._take(1)[0]) if each.length else 1
                held[each.name].append(self._take(size).astype(np.int64) if each.length else self._take(1)[0])
        return held

    def _alike(self, count: int) -> np.ndarray | None:
        """Return lists that are all as long as the first, (count, its length); None: they are not."""
        begin = self._at
        if not count or begin >= len(self._words):
            return None
        size = int(self._words[begin])
        if begin + (size + 1) * count <= len(self._words):
            rows = self._take((size + 1) * count).reshape(count, size + 1)
            if (rows[:, 0] == size).all():
                return rows[:, 1:].astype(np.int64)
        self._at = begin
        return None


class _Binary:
    """Takes elements of the binary form."""

    def __init__(self, body: bytes, order: str) -> None:
        self._body, self._order, self._at = body, order, 0

    def _take(self, kind: object, count: int) -> np.ndarray:
        values = np.frombuffer(self._body, kind, count, self._at)  # type: ignore[call-overload]
        self._at += values.nbytes
        held: np.ndarray = values
        return held

    def element(self, element: Element) -> dict:
        """Return the values of each property: an array, or a list of arrays."""
        if not element.number:
            return {each.name: [] for each in element.properties}
        if not any(each.length for each in element.properties):
            kind = np.dtype([(each.name, self._order + each.kind) for each in element.properties])
            values = self._take(kind, element.number)
            return {name: values[name] for name in values.dtype.names or ()}
        return self._alike(element) or self._each(element)

    def _alike(self, element: Element) -> dict | None:
        """Return what `element` does if all lists are as long as those of the first; None: they are not."""
        begin, fields = self._at, list[tuple]()
        for each in element.properties:
            if each.length:
                (size,) = self._take(self._order + each.length, 1).tolist()
                fields.append((f"{each.name} size", self._order + each.length))
                fields.append((each.name, self._order + each.kind, (size,)))
                self._take(self._order + each.kind, size)
            else:
                fields.append((each.name, self._order + each.kind))
                self._take(self._order + each.kind, 1)
        kind, self._at = np.dtype(fields), begin
        if begin + kind.itemsize * element.number > len(self._body):
            return None
        values = self._take(kind, element.number)
        sizes = [f"{each.name} size" for each in element.properties if each.length]
        if any((values[size] != values[size][0]).any() for size in sizes):
            self._at = begin
            return None
        return {each.name: values[each.name] for each in element.properties}

    def _each(self, element: Element) -> dict:
        held: dict[str, list] = {each.name: [] for each in element.properties}
        for _ in range(element.number):
            for each in element.properties:
                size = int(self._take(self._order + each.length, 1)[0]) if each.length else 1
                held[each.name].append(self._take(self._order + each.kind, size))
        return held
