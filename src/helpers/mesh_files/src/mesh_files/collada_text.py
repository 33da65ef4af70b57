"""COLLADA as other programs write it: units with a decimal comma, and polygons with inward corners."""

from __future__ import annotations

import math
import re
from typing import Iterator
from xml.etree import ElementTree

import numpy as np

from mesh_files.errors import MeshFileError
from mesh_files.polygons import ears, has_inward_corner

_UNIT = re.compile(rb"(<(?:\w+:)?unit\b[^>]*?\bmeter\s*=\s*[\"'])([^\"']*)([\"'])")
_WIDE = re.compile(rb"<(?:\w+:)?(?:polylist|polygons)\b")
_SCENE = re.compile(rb"<(?:\w+:)?instance_visual_scene\b")
_SKIN = re.compile(rb"<(?:\w+:)?instance_controller\b")
_UTF16 = (b"\xff\xfe", b"\xfe\xff")


def plain_collada(content: bytes) -> bytes:
    """Return a COLLADA file as pycollada reads it right.

    Raises:
        MeshFileError: its unit is no length, it has no scene, or a shape in it hangs on a skeleton.
    """
    if content.startswith(_UTF16):
        text = content.decode("utf-16", errors="replace")
        content = re.sub(r"^(<\?xml[^>]*?)\s+encoding\s*=\s*([\"']).*?\2", r"\1", text).encode()
    if not _SCENE.search(content):
        raise MeshFileError("the COLLADA has no visual scene, or it is cut. Export it again")
    if _SKIN.search(content):  # pycollada leaves such shapes out
        raise MeshFileError("a shape hangs on a skeleton (instance_controller). Export it without one")
    content = _UNIT.sub(_with_point, content)
    return _with_ears(content) if _WIDE.search(content) else content


def _with_point(unit: re.Match[bytes]) -> bytes:
    told = unit[2].replace(b",", b".").strip()
    try:
        metres = float(told)
    except ValueError:
        metres = math.nan
    if not 0.0 < metres < math.inf:
        raise MeshFileError(
            f'its unit is "{unit[2].decode(errors="replace")}" metres, which is no length. '
            "Export it in metres"
        )
    return unit[1] + told + unit[3]


def _with_ears(content: bytes) -> bytes:
    """Return the file with triangles in place of polygons with inward corners, if it has any."""
    try:
        root = ElementTree.fromstring(content)
        changed = [_split(mesh, each) for mesh in _all(root, "mesh") for each in _all(mesh, "polylist")]
    except (ElementTree.ParseError, ValueError, IndexError, KeyError, AttributeError, StopIteration):
        return content  # its reader tells what is wrong
    if not any(changed):
        return content
    ElementTree.register_namespace("", root.tag[1:].partition("}")[0])
    held: bytes = ElementTree.tostring(root, encoding="utf-8")
    return held


def _split(mesh: ElementTree.Element, polylist: ElementTree.Element) -> bool:
    """Split the polygons of a list that turn inward. Return whether there was one."""
    inputs = [each for each in polylist if _name(each) == "input"]
    stride = max(int(each.get("offset", "0")) for each in inputs) + 1
    corner = next(each for each in inputs if each.get("semantic") == "VERTEX")
    places = _places(mesh, corner.get("source", ""))
    counts_of, rows_of = (next(e for e in polylist if _name(e) == name) for name in ("vcount", "p"))
    counts = np.array((counts_of.text or "").split(), int)
    rows = np.array((rows_of.text or "").split(), int).reshape(-1, stride)
    first = np.concatenate(([0], np.cumsum(counts)[:-1]))
    of_corner = rows[:, int(corner.get("offset", "0"))]
    split: dict[int, np.ndarray] = {}
    for size in np.unique(counts[counts > 3]):
        which = np.flatnonzero(counts == size)
        corners = places[of_corner[first[which][:, None] + np.arange(size)]]
        for k in np.flatnonzero(has_inward_corner(corners)):
            split[int(which[k])] = first[which[k]] + np.array(ears(corners[k])).ravel()
    if not split:
        return False
    order = [split.get(k, first[k] + np.arange(counts[k])) for k in range(len(counts))]
    sizes = [[3] * (len(each) // 3) if k in split else [len(each)] for k, each in enumerate(order)]
    told = [size for several in sizes for size in several]
    counts_of.text = " ".join(map(str, told))
    rows_of.text = " ".join(map(str, rows[np.concatenate(order)].ravel().tolist()))
    polylist.set("count", str(len(told)))
    return True


def _places(mesh: ElementTree.Element, vertices: str) -> np.ndarray:
    """Return the places (n, 3) that an element <vertices> names."""
    ids = {each.get("id", ""): each for each in mesh.iter()}
    position = next(e for e in ids[vertices.lstrip("#")] if e.get("semantic") == "POSITION")
    source = ids[position.get("source", "").lstrip("#")]
    values = np.array((next(_all(source, "float_array")).text or "").split(), float)
    stride = int(next(_all(source, "accessor")).get("stride", "3"))
    return values.reshape(-1, stride)[:, :3]


def _all(element: ElementTree.Element, name: str) -> Iterator[ElementTree.Element]:
    return (each for each in element.iter() if _name(each) == name)


def _name(element: ElementTree.Element) -> str:
    return str(element.tag).rpartition("}")[2]
