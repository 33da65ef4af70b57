"""Which axis of a file points up. Here it is z."""

from __future__ import annotations

import re

import numpy as np

from mesh_files.gltf import gltf_document

Z_UP = np.eye(3)
Y_UP = np.array(((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0)))
X_UP = np.array(((0.0, -1.0, 0.0), (0.0, 0.0, -1.0), (1.0, 0.0, 0.0)))
"""Turns of places of a file (x, y, z) into places with z up; COLLADA 1.4, <up_axis>."""
_OF_COLLADA = {"X_UP": X_UP, "Y_UP": Y_UP, "Z_UP": Z_UP}
_UP_AXIS = re.compile(rb"<(?:\w+:)?up_axis>\s*(\w+)\s*<")
_TRIMESH = "trimesh"
"""It writes places into glTF as they are, whatever axis points up."""


def turn_of(kind: str, content: bytes) -> np.ndarray:
    """Return the turn (3, 3) of a file's places.

    COLLADA tells its axis; where it does not, the file counts as z up, as in Gazebo. glTF is y up by its
    specification.
    """
    if kind == "dae" and (told := _UP_AXIS.search(content)):
        return _OF_COLLADA.get(told[1].decode("ascii", errors="replace").upper(), Z_UP)
    if kind in ("glb", "gltf") and _TRIMESH not in gltf_document(kind, content).asset.generator:
        return Y_UP
    return Z_UP
