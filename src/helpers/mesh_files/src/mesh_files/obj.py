"""OBJ as other programs write it: decimal commas, remarks, indices that count back, inward corners."""

from __future__ import annotations

import re
from typing import Iterator

import numpy as np

from mesh_files.errors import MeshFileError
from mesh_files.polygons import ears, has_inward_corner

_COMMA = re.compile(r"(?m)^(\s*(?:v|vn|vt|vertex|facet)\s.*\d,\d.*)$")
_BACK = re.compile(r"(?m)^\s*f\s.*-\d")
_ZERO = re.compile(r"(?m)^ *f .*?(?<![\d/.-])0+(?![\d.])")
_REMARK = re.compile(r"(?m)^( *(?:v|vn|vt|f) [^#\n]*)#.*$")
_WIDE = re.compile(r"(?m)^ *f +(?:\S+ +){3}\S")
_COUNTED = ("v", "vt", "vn")


def with_points(text: str) -> str:
    """Return the text of an OBJ or an STL with decimal points, if it has decimal commas."""
    return _COMMA.sub(lambda line: line[1].replace(",", "."), text)


def plain_obj(text: str) -> str:
    """Return the text of an OBJ as trimesh reads it right.

    Raises:
        MeshFileError: a face names the vertex 0, which none has.
    """
    text = text.replace("\\\n", " ").replace("\t", " ")
    text = with_own_indices(_REMARK.sub(r"\1", with_points(text)))
    if _ZERO.search(text):
        raise MeshFileError("a face has the vertex 0, but an OBJ counts from 1. Export it again")
    return with_ears(text) if _WIDE.search(text) else text


def with_own_indices(text: str) -> str:
    """Return the text of an OBJ whose faces count their corners from the file's beginning.

    -1 is the last vertex before the face, not the last one of the file.
    """
    if not _BACK.search(text):
        return text
    counts, lines = dict.fromkeys(_COUNTED, 0), []
    for line in text.splitlines():
        key, *words = line.split() or [""]
        if key in counts:
            counts[key] += 1
        elif key == "f":
            line = " ".join(["f", *(_corner(word, counts) for word in words)])
        lines.append(line)
    return "\n".join(lines)


def _corner(word: str, counts: dict[str, int]) -> str:
    """Return a corner's indices of vertex, texture and normal."""
    indices = []
    for index, kind in zip(word.split("/"), _COUNTED):
        indices.append(str(counts[kind] + 1 + int(index)) if index.startswith("-") else index)
    return "/".join(indices)


def with_ears(text: str) -> str:
    """Return the text of an OBJ whose polygons with inward corners are triangles."""
    lines = text.splitlines()
    words = {k: line.split()[1:] for k, line in enumerate(lines) if line.lstrip().startswith("f ")}
    wide = {k: each for k, each in words.items() if len(each) > 3}
    places = [line.split()[1:4] for line in lines if line.lstrip().startswith("v ")]
    try:
        vertices = np.array(places, float).reshape(-1, 3)
        for k, triangles in _ears_of(vertices, wide):
            lines[k] = "\n".join(" ".join(("f", *(wide[k][corner] for corner in each))) for each in triangles)
    except (ValueError, IndexError):
        return text  # whoever reads it says what is wrong
    return "\n".join(lines)


def _ears_of(
    vertices: np.ndarray, wide: dict[int, list[str]]
) -> Iterator[tuple[int, list[tuple[int, int, int]]]]:
    """Yield the line and the triangles of each face with an inward corner."""
    by_size: dict[int, list[int]] = {}
    for k, each in wide.items():
        by_size.setdefault(len(each), []).append(k)
    for several in by_size.values():
        corners = vertices[[[int(word.split("/")[0]) - 1 for word in wide[k]] for k in several]]
        for number in np.flatnonzero(has_inward_corner(corners)):
            yield several[number], ears(corners[number])
