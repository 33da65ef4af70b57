"""OFF, as Geomview's page says: https://www.geomview.org/docs/html/OFF.html."""

from __future__ import annotations

import re

import numpy as np

from mesh_files.errors import MeshFileError
from mesh_files.polygons import triangulated

_HEAD = re.compile(r"\s*(ST)?(C)?(N)?(4)?OFF(?!\w)")


def read_off(text: str) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) and triangles (m, 3) of an OFF of the text form; raises MeshFileError."""
    text = re.sub(r"#.*", "", text)
    head = _HEAD.match(text)
    if head is None or head[4]:
        raise MeshFileError("is no OFF of three dimensions in text. Export it as OBJ or PLY")
    lines = [line.split() for line in text[head.end() :].splitlines() if line.strip()]
    try:
        points, faces = int(lines[0][0]), int(lines[0][1])
        vertices = np.array([line[:3] for line in lines[1 : points + 1]], float).reshape(points, 3)
        rows = lines[points + 1 : points + 1 + faces]
        polygons = [[int(word) for word in row[1 : int(row[0]) + 1]] for row in rows]
        if len(polygons) < faces or any(len(p) != int(row[0]) for p, row in zip(polygons, rows)):
            raise IndexError
        corners = [corner for each in polygons for corner in each]
        if corners and not 0 <= min(corners) <= max(corners) < points:
            raise MeshFileError("a face has a corner that does not exist. Export it again")
    except (ValueError, IndexError):
        raise MeshFileError("the OFF is cut or damaged. Export it again") from None
    return vertices, triangulated(vertices, polygons)
