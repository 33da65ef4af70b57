"""Reads a mesh or an SDF world as triangles with the names of the things that they belong to."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Sequence

import numpy as np

from flight_basics.errors import SurveyError
from inspection.files.coverage_record import DRAWING, MAP
from mesh_files.bodies import bodies_of
from mesh_files.errors import MeshFileError
from mesh_files.worlds import read_triangles

MOST_TRIANGLES = 2_000_000
ENDLESS_M = 300.0
"""A thing this long is the ground of a world; it does not say how large the room is."""
NOT_SURVEYED = "unknown"
"""Name of a thing that bounds the air and is no surface: what an explored map does not know."""
MAPPED_PLATING, MAPPED_STRUCTURE, MAPPED_BARS = "mapped_plating", "mapped_structure", "mapped_bars"
"""Names of things of sheets that each show their front only: what an explored map knows. Plating is wide, and
between bars one sees through, as between the rungs of a ladder.
"""


def is_mapped(name: str) -> bool:
    """Return whether a thing of this name is what an explored map knows."""
    return name.startswith("mapped")


def reference_of(names: Sequence[str]) -> str:
    """Return what a surface of things of these names is: `MAP` or `DRAWING`."""
    return MAP if any(map(is_mapped, names)) else DRAWING


@dataclass(frozen=True)
class Mesh:
    """triangles_m: (m, 3, 3) corners, map's frame. names: of the things. part: (m,) index of the name."""

    triangles_m: np.ndarray
    names: tuple[str, ...]
    part: np.ndarray

    @property
    def joined(self) -> np.ndarray:
        """(m,) as part, but all that an explored map knows is one thing: its plating ends at no edge."""
        known = np.array([is_mapped(name) for name in self.names])
        return np.where(known[self.part], int(known.argmax()), self.part)

    @cached_property
    def bodies(self) -> tuple[np.ndarray, np.ndarray]:
        """The body (m,) of each triangle, and which bodies (k,) are closed."""
        return bodies_of(self.triangles_m, self.part)

    @property
    def sides(self) -> np.ndarray:
        """(m,) how many sides of each triangle can be a surface in the air.

        A closed body has one, a sheet two. Of an explored map it is the front; what bounds the air has none.
        """
        of, is_closed = self.bodies
        one_sided = np.array([is_mapped(name) for name in self.names])[self.part] | is_closed[of]
        surveyed = np.array([name != NOT_SURVEYED for name in self.names])[self.part]
        return np.where(one_sided, 1, 2) * surveyed

    @property
    def area_m2(self) -> float:
        """Of all sides that can be a surface in the air: what is within reach is a part of it."""
        across = np.cross(*np.moveaxis(self.triangles_m[:, 1:] - self.triangles_m[:, :1], 1, 0))
        return float((0.5 * np.linalg.norm(across, axis=1) * self.sides).sum())

    def bounds_m(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the corners of the box around all but endless ground."""
        kept = np.zeros(len(self.triangles_m), bool)
        for number in range(len(self.names)):
            own = self.part == number
            corners = self.triangles_m[own].reshape(-1, 3)
            kept[own] = np.ptp(corners, axis=0).max() < ENDLESS_M
        corners = self.triangles_m[kept if kept.any() else slice(None)].reshape(-1, 3)
        return corners.min(axis=0), corners.max(axis=0)


def read_mesh(path: Path) -> Mesh:
    """Read an SDF world, or a mesh of the kinds that `mesh_files` knows, in metres, z up.

    Raises:
        SurveyError: the file cannot be read, has no surface, or too many triangles.
    """
    try:
        return Mesh(*read_triangles(path, MOST_TRIANGLES))
    except MeshFileError as error:
        raise SurveyError(f"{path}: {error}.") from None
